// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/batch_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>

#include "apps/panoptic/batch_options.h"
#include "apps/panoptic/commands.h"
#include "panoptic/base/child_process.h"
#include "panoptic/base/files.h"
#include "panoptic/base/os.h"
#include "panoptic/batch/fingerprint.h"
#include "panoptic/labels.h"
#include "panoptic/parallel.h"
#include "panoptic/predict/model.h"
#include "panoptic/predict/network.h"
#include "panoptic/run_outputs.h"
#include "panoptic/source.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

fs::path truth_folder(const BatchScene& scene) {
  return is_folder(scene.recording) || is_simulated(scene.recording) ? fs::path(scene.recording)
                                                                     : fs::path(scene.recording).parent_path();
}

void require_truth(const std::vector<BatchScene>& scenes) {
  Words without_truth;
  for (const BatchScene& scene : scenes) {
    if (is_simulated(scene.recording)) continue;
    const Words names = names_in_folder(truth_folder(scene));
    const bool has_truth = std::ranges::any_of(names, [](const std::string& n) { return n.ends_with(".aggregation.json"); });
    if (!has_truth || scene.recording.ends_with(".toml")) without_truth.push_back(scene.name);
  }
  if (without_truth.empty()) return;
  throw Error(fmt::format("--gt: {} of {} scenes have no ScanNet truth beside their recording, {} for one; leave them out",
                          without_truth.size(), scenes.size(), without_truth.front()));
}

// The files that the scores of a scene depend on beside its map.
std::string truth_fingerprint(const BatchScene& scene) {
  Fingerprint truth;
  if (is_simulated(scene.recording)) {
    truth.add(scene.recording);
    return truth.text();
  }
  const fs::path folder = truth_folder(scene);
  for (const std::string& name : names_in_folder(folder)) {
    const bool is_part = std::ranges::any_of(std::array{".aggregation.json", ".segs.json", ".ply"},
                                             [&](const char* end) { return name.ends_with(end); });
    if (is_part) truth.add_stamps(folder / name);
  }
  fs::path place = folder;
  for (int level = 0; level < 3; ++level, place = place.parent_path()) {  // where eval looks for the names of the classes
    truth.add_stamps(place / "scannetv2-labels.combined.tsv");
  }
  return truth.text();
}

void add_file(Fingerprint& fingerprint, const std::string& path) {
  if (!path.empty()) fingerprint.add_stamps(path);
}

// The files that options name; weights are looked up as they will be, and an error shows now.
void add_named_files(Fingerprint& fingerprint, const Options& options) {
  Words models = options.networks.semantic;
  if (!options.networks.instance.empty()) models.push_back(options.networks.instance);
  for (const std::string& path : models) {
    fingerprint.add_stamps(path);
    fingerprint.add_stamps(find_weights(load_model(path), engine_from(options.networks.engine)));
  }
  if (options.labels.empty()) return;
  load_label_set(options.labels);
  add_file(fingerprint, options.labels);
}

// The plan of one scene is like that of all others.
struct Planner {
  const Arguments& arguments;
  Fingerprint program = {};
  std::string threads = {};  // of each process, unless the run options say
  InputOwners owners = {};

  // The words that make the predictions of a scene, and what they are made with, in words.
  struct Predictions {
    fs::path folder = {};  // empty: none are shared
    std::string made_by = {};
    Words command = {};
  };

  Words with_threads(Words command, const Words& options) const {
    const bool is_given = std::ranges::any_of(options, [](const std::string& w) { return w.starts_with("--threads"); });
    if (!is_given && !threads.empty()) command.insert(command.end(), {"--threads", threads});
    return command;
  }

  Predictions predictions_of(const BatchScene& scene, const Arguments& run, const Options& options) const;
  SceneTask task_of(const BatchScene& scene);
  void add_scoring(SceneTask& task) const;
};

Words predict_command(const BatchScene& scene, const Arguments& run, const Options& options, const fs::path& partial) {
  Words words{kThisProgram, "predict", scene.recording, "-o", partial.string()};
  const auto add = [&](const char* flag, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {flag, value});
  };
  for (const std::string& model : options.networks.semantic) add("--semantic", model);
  for (const std::string& setting : run.settings) add("--set", setting);
  add("--instance", options.networks.instance);
  add("--labels", options.labels);
  add("--preset", run.preset);
  add("--config", run.config);
  add("--calibration", run.calibration);
  add("--frames", run.frames);
  if (run.pair_tolerance_s) add("--pair-tolerance", fmt::format("{}", *run.pair_tolerance_s));
  if (run.threads > 0) add("--threads", fmt::format("{}", run.threads));
  if (run.no_preflight) words.emplace_back("--no-preflight");
  return words;
}

Planner::Predictions Planner::predictions_of(const BatchScene& scene, const Arguments& run, const Options& options) const {
  if (arguments.shared_predictions.empty()) return {};
  require_flags_for_networks(run.settings);
  if (!options.predictions.empty()) throw UsageError("--share-predictions and --predictions after -- exclude each other");
  Predictions result{fs::absolute(arguments.shared_predictions).lexically_normal() / scene.name};
  const bool has_networks = !options.networks.semantic.empty() || !options.networks.instance.empty();
  const bool is_made = is_file(result.folder / "made_by.txt");
  if (has_networks) {
    Fingerprint made = program;
    add_recording(made, scene.recording);
    add_named_files(made, options);
    Options networks;
    networks.networks = options.networks;
    networks.labels = options.labels;
    made.add(to_toml(networks));
    made.add(run.frames);
    made.add(fmt::format("{}", run.pair_tolerance_s.value_or(-1)));
    if (!run.calibration.empty()) made.add_stamps(run.calibration);
    result.made_by = fmt::format("{} {}\n", networks_text(options.networks), made.text());
    Fingerprint owner;  // other batches may make the same
    owner.add(fs::absolute(arguments.output).lexically_normal().string());
    const fs::path partial = result.folder.parent_path() / fmt::format(".{}.{}.{}", scene.name, made.text(), owner.text());
    result.command = with_threads(predict_command(scene, run, options, partial), arguments.run_options);
  }
  if (is_there(result.folder) && has_networks && (!is_made || read_file(result.folder / "made_by.txt") != result.made_by)) {
    throw Error(
        fmt::format("{}: predictions of other networks, options or frames, or by another build of this program; choose another "
                    "folder, or leave out --semantic "
                    "and --instance to use them as they are",
                    result.folder.string()));
  }
  if (!has_networks && !is_there(result.folder)) {
    throw Error(fmt::format("{}: no predictions of {} here; name --semantic or --instance after --, which make them",
                            result.folder.string(), scene.name));
  }
  return result;
}

SceneTask Planner::task_of(const BatchScene& scene) {
  const fs::path folder = fs::absolute(arguments.output).lexically_normal() / scene.name;
  Words words = options_for(scene, arguments.run_options);
  const Arguments run = run_arguments(scene, folder, words);
  require_possible(run);
  frame_range_from(run);
  const Options options = options_from(run);
  require_own_input("predictions", options.predictions, scene, owners);
  require_own_input("--pose-updates", run.pose_updates, scene, owners);
  const Predictions predictions = predictions_of(scene, run, options);

  SceneTask task;
  Fingerprint fingerprint = program;
  for (const std::string& word : without(words, "--threads")) fingerprint.add(word);
  fingerprint.add(to_toml(options));
  add_named_files(fingerprint, options);
  add_recording(fingerprint, scene.recording);
  for (const std::string& file : {run.calibration, run.config, run.pose_updates, options.predictions})
    add_file(fingerprint, file);
  fingerprint.add(predictions.folder.string());
  fingerprint.add(predictions.made_by);
  if (predictions.made_by.empty()) add_file(fingerprint, predictions.folder.string());
  task.record = {.scene = scene, .fingerprint = fingerprint.text()};
  task.folder = folder;
  task.outdated = {folder / "scores.json", folder / "submission"};
  if (!predictions.command.empty()) {
    task.steps.push_back({predictions.command, predictions.folder, predictions.command.at(4), predictions.made_by});
  }
  if (!predictions.folder.empty()) {
    words = without(without(words, "--semantic"), "--instance");
    words.insert(words.end(), {"--predictions", predictions.folder.string()});
  }
  Words command{kThisProgram, "run", scene.recording, "-o", folder.string()};
  command.insert(command.end(), words.begin(), words.end());
  task.steps.push_back({with_threads(command, words), {}, {}, {}});
  return task;
}

void Planner::add_scoring(SceneTask& task) const {
  Words command{kThisProgram, "eval", task.folder.string(), "--gt", truth_folder(task.record.scene).string()};
  command.insert(command.end(), {"--json", (task.folder / "scores.json").string()});
  command.insert(command.end(), {"--write-submission", (task.folder / "submission").string()});
  if (!threads.empty()) command.insert(command.end(), {"--threads", threads});
  task.steps.push_back({command, {}, {}, {}});
  task.scores = true;
  task.truth = truth_fingerprint(task.record.scene);
}

// A task has the cores that Slurm gave it; scenes beside each other on one machine share its cores.
std::string threads_of_each(const Arguments& a) {
  if (a.slurm_task) return os::environment("SLURM_CPUS_PER_TASK");
  const int jobs = a.jobs.value_or(1);
  return jobs > 1 ? fmt::format("{}", std::max(1, thread_count() / jobs)) : "";
}

}  // namespace

BatchPlan plan_batch(const Arguments& a, const std::string& only) {
  require_allowed(a.run_options);
  std::vector<fs::path> own{a.output};
  if (!a.shared_predictions.empty()) own.emplace_back(a.shared_predictions);
  SceneList list = read_scenes(a.dataset, own);
  require_apart(a, list.scenes);
  if (!only.empty()) std::erase_if(list.scenes, [&](const BatchScene& scene) { return scene.name != only; });
  if (list.scenes.empty()) throw Error(fmt::format("{}: no scene {} here; submit the batch again", a.dataset, only));
  if (a.with_truth) require_truth(list.scenes);
  Planner planner{.arguments = a, .threads = threads_of_each(a)};
  planner.program.add_this_program();
  BatchPlan plan;
  plan.left_out = std::move(list.left_out);
  for (const BatchScene& scene : list.scenes) {
    SceneTask task = planner.task_of(scene);
    if (a.with_truth) planner.add_scoring(task);
    plan.records.push_back(task.record);
    plan.tasks.push_back(std::move(task));
  }
  return plan;
}

void leave_out_finished(BatchPlan& plan) {
  plan.records.clear();
  std::vector<SceneTask> left;
  for (SceneTask& task : plan.tasks) {
    const auto record = read_record(task.folder);
    task.is_mapped = is_finished(record, task.record.fingerprint);
    if (task.is_mapped) {
      task.record = *record;
      task.record.reason.clear();  // a scoring that failed is tried again, or not asked for
    }
    plan.records.push_back(task.record);
    if (task.is_mapped && (!task.scores || (record->scored && record->truth == task.truth))) continue;
    left.push_back(std::move(task));
  }
  plan.tasks = std::move(left);
}

}  // namespace panoptic
