// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The scores of a batch: counts of all scenes added up, from the labels that each left for the vertices of its truth.
#include <fmt/format.h>

#include "apps/panoptic/batch_plan.h"
#include "panoptic/base/files.h"
#include "panoptic/eval/scores_text.h"
#include "panoptic/eval/submission.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

struct Totals {
  Evaluation semantic = Evaluation();
  Evaluation instance = Evaluation();
  Evaluation panoptic = Evaluation();
};

void add_scene(const fs::path& folder, const std::string& name, Totals& totals) {
  const fs::path truth = folder / "truth";
  const std::vector<std::string> scenes = scenes_in(folder / "semantic");
  if (scenes.size() != 1) {
    throw Error(fmt::format("{}: labels of {} scenes where one is expected; remove {} and run the command again", folder.string(),
                            scenes.size(), folder.parent_path().string()));
  }
  const std::string& scene = scenes.front();
  totals.semantic.add_semantic(name, read_truth(truth / "semantic", scene, SubmissionForm::kSemantic),
                               read_semantic(folder / "semantic" / (scene + ".txt")));
  const VertexLabels instances = read_truth(truth / "instance", scene, SubmissionForm::kInstance);
  totals.instance.add_instances(name, instances, read_instances(folder / "instance", scene, instances.class_id.size()));
  totals.panoptic.add_panoptic(name, read_truth(truth / "panoptic", scene, SubmissionForm::kPanoptic),
                               read_panoptic(folder / "panoptic" / (scene + ".txt")));
}

}  // namespace

void remove_batch_scores(const fs::path& output) {
  for (const char* name : {"scores.json", "scores.csv"}) os::remove(output / name);
}

std::string write_batch_scores(const fs::path& output, const std::vector<SceneRecord>& records) {
  Totals totals;
  bool is_empty = true;
  for (const SceneRecord& record : records) {
    if (record.state != SceneState::kFinished || !record.scored) continue;
    add_scene(output / record.scene.name / "submission", record.scene.name, totals);
    is_empty = false;
  }
  if (is_empty) {
    remove_batch_scores(output);
    return "";
  }
  Scores scores = totals.semantic.scores();
  scores.instance = totals.instance.scores().instance;
  scores.panoptic = totals.panoptic.scores().panoptic;
  write_json_file(output / "scores.json", to_json(scores));
  write_file(output / "scores.csv", to_csv(scores));
  return to_table(scores);
}

}  // namespace panoptic
