// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <vector>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/map_result.h"
#include "apps/panoptic/progress.h"
#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/eval/change_scores.h"
#include "panoptic/eval/id_space.h"
#include "panoptic/eval/labelled_vertices.h"
#include "panoptic/eval/scores_text.h"
#include "panoptic/eval/submission.h"
#include "panoptic/eval/vertex_labels.h"
#include "panoptic/evaluation.h"
#include "panoptic/io/dynamics.h"
#include "panoptic/parallel.h"
#include "panoptic/scan_truth.h"
#include "panoptic/source.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) tell(fmt::format("warning: {}\n", warning));
}

// Returns why the scores say nothing, if that is so.
std::string evaluate_run(const Arguments& a, Evaluation& evaluation) {
  std::vector<std::string> warnings;
  const bool is_file = is_map_file(a.evaluated);
  const LabelledMap map = is_file ? map_to_score(a.evaluated, warnings) : read_run_folder(a.evaluated, &warnings);
  const bool is_simulated = a.truth.starts_with("sim:");
  const ScanTruth truth = is_simulated ? simulated_truth(a.truth) : read_scan_truth(a.truth, a.category_map, &warnings);
  print_warnings(warnings);
  const LabelledVertices prediction = evaluation.add(map, truth);
  if (!a.submission.empty()) write_submission(a.submission, truth.scene, prediction, labels_of(truth));
  return place_notice(map, truth);
}

SubmissionForm form_of(const std::string& name) {
  if (name == "semantic") return SubmissionForm::kSemantic;
  return name == "instance" ? SubmissionForm::kInstance : SubmissionForm::kPanoptic;
}

// The class of each vertex: of masks that overlap, that of the last.
std::vector<ClassId> classes_of(const std::vector<InstanceMask>& masks, std::size_t vertices) {
  std::vector<ClassId> classes(vertices);
  for (const InstanceMask& mask : masks) {
    for (const std::uint32_t v : mask.vertices) classes[v] = mask.class_id;
  }
  return classes;
}

void evaluate_scene(const Arguments& a, const std::string& scene, Evaluation& evaluation) {
  const SubmissionForm form = form_of(a.evaluated);
  const IdSpace space = id_space_of(a.id_space);
  const fs::path folder = a.predictions;
  const VertexLabels truth = read_truth(a.truth, scene, form, a.category_map);
  std::vector<ClassId> classes;
  if (form == SubmissionForm::kSemantic) {
    classes = read_semantic(folder / (scene + ".txt"), space);
    evaluation.add_semantic(scene, truth, classes);
  } else if (form == SubmissionForm::kInstance) {
    const std::vector<InstanceMask> masks = read_instances(folder, scene, truth.class_id.size(), space);
    evaluation.add_instances(scene, truth, masks);
    classes = classes_of(masks, truth.class_id.size());
  } else {
    const VertexLabels prediction = read_panoptic(folder / (scene + ".txt"), space);
    require_stuff(scene, truth.class_id, prediction.class_id);
    evaluation.add_panoptic(scene, truth, prediction);
    classes = prediction.class_id;
  }
  if (space == IdSpace::kNyu40) print_warnings(label_notices(scene, truth.class_id, classes));
}

// Tells of scenes without a prediction: as in the benchmark, only predicted scenes count.
void warn_of_missing_scenes(const Arguments& a, const std::vector<std::string>& scenes) {
  std::size_t missing = 0;
  for (const fs::path name : names_in_folder(a.truth)) {
    const bool is_truth = name.extension() == ".txt" || is_folder(a.truth / name);
    if (is_truth && !std::binary_search(scenes.begin(), scenes.end(), name.stem().string())) ++missing;
  }
  if (missing > 0) print_warnings({fmt::format("{} scenes of {} have no prediction and do not count", missing, a.truth)});
}

Eigen::AlignedBox3d box_of(const std::vector<Vec3f>& points) {
  constexpr double kMargin_m = 0.5;  // what stands before walls that were never seen
  Eigen::AlignedBox3d box;
  for (const Vec3f& point : points) box.extend(point.cast<double>());
  if (!box.isEmpty()) box = {box.min() - Vec3d::Constant(kMargin_m), box.max() + Vec3d::Constant(kMargin_m)};
  return box;
}

// Scores what the run says of a world that moves.
ChangeScores evaluate_changes(const Arguments& a, const std::optional<SurfaceScores>& surface) {
  const fs::path scan = a.truth;
  const DynamicsTruth truth = read_dynamics(scan / kDynamicsFile);
  ChangeScores scores = change_scores(true_changes(truth), claimed_changes(a.evaluated), surface);
  if (a.moving.empty()) return scores;
  const Eigen::AlignedBox3d box = box_of(read_scan_truth(scan, a.category_map).positions);
  scores.moving = score_moving(*open_recording(scan), scan / kMovingFolder, a.moving, box);
  return scores;
}

void require_possible_evaluation(const Arguments& a, bool is_form) {
  if (is_form && a.predictions.empty()) {
    throw UsageError(fmt::format("eval {0} needs --pred DIR; a run in a folder called '{0}' is ./{0}", a.evaluated));
  }
  if (!is_form && a.id_space != "nyu40") throw UsageError("--id-space goes with --pred");
  if (!is_form && !a.predictions.empty()) throw UsageError("--pred goes with eval semantic, eval instance or eval panoptic");
  if (is_form && !a.submission.empty()) throw UsageError("--write-submission takes a run, not a submission");
  if (!a.changes) return;
  if (is_form || is_map_file(a.evaluated)) throw UsageError("--changes takes the folder of a run");
  if (a.truth.starts_with("sim:")) throw UsageError("--changes needs a folder of panoptic simulate --dynamics for --gt");
}

Json settings_json(const Arguments& a) {
  Json json = {{"evaluated", a.evaluated}, {"ground_truth", a.truth}};
  if (a.predictions.empty()) {
    json["reach_voxels"] = kReach_voxels;
    json["confidence"] = "class probability * observations / (observations + 10)";
  } else {
    json["predictions"] = a.predictions;
    json["id_space"] = a.id_space;
  }
  return json;
}

}  // namespace

int evaluate(const Arguments& a) {
  const bool is_form = a.evaluated == "semantic" || a.evaluated == "instance" || a.evaluated == "panoptic";
  require_possible_evaluation(a, is_form);
  set_thread_count(a.threads);
  Evaluation evaluation(a.variant);
  std::string misplaced;
  if (is_form) {
    const std::vector<std::string> scenes = scenes_in(a.predictions);
    warn_of_missing_scenes(a, scenes);
    for (const std::string& scene : scenes) evaluate_scene(a, scene, evaluation);
  } else {
    misplaced = evaluate_run(a, evaluation);
  }
  const Scores scores = evaluation.scores();
  fmt::print("{}", to_table(scores));
  std::optional<ChangeScores> changes;
  if (a.changes) changes = evaluate_changes(a, scores.surface);
  if (changes) fmt::print("{}", to_table(*changes));
  if (!a.json.empty()) {
    Json json = to_json(scores);
    if (changes) json["changes"] = to_json(*changes);
    json["settings"] = settings_json(a);
    write_json_file(a.json, json);
  }
  if (!a.csv.empty()) write_file(a.csv, to_csv(scores));
  if (misplaced.empty()) return kDone;
  std::fflush(stdout);  // the scores stand above the line that says what they are worth
  throw Error(misplaced);
}

}  // namespace panoptic
