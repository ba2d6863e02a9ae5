// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <utility>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/base/child_process.h"
#include "panoptic/base/files.h"
#include "panoptic/batch/batch_run.h"
#include "panoptic/batch/fingerprint.h"
#include "panoptic/benchmark/report.h"
#include "panoptic/parallel.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

// A little below what was measured (docs/benchmarks.md): the simulation gives the same frames everywhere, so what falls through
// is a change of the code.
const std::array<Floor, 4> kQuickFloors{
    {{"no regularizer", 0.615, 0.66}, {"default", 0.645, 0.68}, {"oracle masks", 0.89, 0.915}, {"oracle", 0.915, 0.93}}};

constexpr const char* kResult = "part.json";

// A group of the full study may be looked at quickly too: on the small home alone.
Study study_of(const Arguments& arguments) {
  if (arguments.group.empty()) return arguments.quick ? quick_study() : full_study();
  Study study = only(full_study(), arguments.group);
  if (arguments.quick) study.experiment.homes = quick_study().experiment.homes;
  return study;
}

fs::path folder_of(const Arguments& a, std::size_t part) { return fs::path(a.output) / "parts" / fmt::format("{}", part); }

// The input of a part. Times are a part of the result, and so the threads are one of the input.
std::string fingerprint_of(const Arguments& a, std::size_t part, int threads) {
  static const Fingerprint kProgram = [] {
    Fingerprint program;
    program.add_this_program();
    return program;
  }();
  Fingerprint input = kProgram;
  input.add(fmt::format("{} {} {} {}", part, a.quick, threads, a.group));
  return input.text();
}

// The result of a part, if it was made of this input.
std::optional<PartResult> result_of(const Arguments& a, const ExperimentPart& part, std::size_t number,
                                    const std::string& fingerprint) {
  const fs::path file = folder_of(a, number) / kResult;
  if (!is_file(file)) return std::nullopt;
  try {
    const Json json = read_json_file(file);
    if (json.value("fingerprint", "") != fingerprint) return std::nullopt;
    PartResult result = part_result_in(json, file.string());
    return result.counts.size() == part.settings.size() ? std::optional(std::move(result)) : std::nullopt;
  } catch (const std::exception&) {  // damaged: it is made again
    return std::nullopt;
  }
}

// A part of the benchmark, as a program of its own.
int run_one_part(const Arguments& a, const Experiment& experiment) {
  const std::vector<ExperimentPart> parts = parts_of(experiment);
  if (*a.benchmark_part >= parts.size()) throw Error(fmt::format("there are {} parts", parts.size()));
  watch_for_interrupt();
  Progress progress("frames", experiment.homes[parts[*a.benchmark_part].home].frames);
  const std::optional<PartResult> result =
      run_part(experiment, parts[*a.benchmark_part], [&](std::size_t done, std::size_t /*total*/) {
        progress.advance(done);
        return !interrupted();
      });
  if (!result) return kInterrupted;
  Json json = to_json(*result);
  json["fingerprint"] = fingerprint_of(a, *a.benchmark_part, a.threads);
  write_json_file(folder_of(a, *a.benchmark_part) / kResult, json);
  return kDone;
}

int threads_of_each(const Arguments& a) { return std::max(1, thread_count() / a.jobs.value_or(1)); }

// A part as a scene of a batch.
SceneTask task_of(const Arguments& a, const SimulationOptions& home, std::size_t number) {
  SceneTask task;
  task.record.scene = {fmt::format("{}", number), fmt::format("sim:{},rooms={}", home.seed, home.rooms)};
  task.record.fingerprint = fingerprint_of(a, number, threads_of_each(a));
  task.folder = fs::absolute(folder_of(a, number));
  std::vector<std::string> command{kThisProgram, "benchmark", "-o", a.output, "--part", fmt::format("{}", number)};
  command.insert(command.end(), {"--threads", fmt::format("{}", threads_of_each(a))});
  if (a.quick) command.emplace_back("--quick");
  if (!a.group.empty()) command.insert(command.end(), {"--group", a.group});
  task.steps.push_back({std::move(command), {}, {}, {}});
  task.outdated = {task.folder / kResult};
  task.leaves_map = false;
  return task;
}

// Works on all parts that are not finished; false if interrupted. Throws Error if one failed.
bool run_parts(const Arguments& a, const Experiment& experiment) {
  const std::vector<ExperimentPart> parts = parts_of(experiment);
  std::vector<SceneTask> tasks;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    SceneTask task = task_of(a, experiment.homes[parts[i].home], i);
    if (!result_of(a, parts[i], i, task.record.fingerprint)) tasks.push_back(std::move(task));
  }
  const std::size_t all = parts.size();
  fmt::print("{} parts, {} of them done before\n", all, all - tasks.size());
  std::fflush(stdout);
  if (tasks.empty()) return true;
  Progress progress("parts", tasks.size());
  std::size_t done = 0;
  std::string failed;
  const BatchWatch watch{[&](const SceneRecord& record) {
                           if (record.state == SceneState::kFailed)
                             failed = fmt::format("part {} failed: {}", record.scene.name, record.reason);
                           progress.advance(++done);
                         },
                         [] { return !interrupted(); }};
  const bool is_whole = run_scenes(tasks, a.jobs.value_or(1), watch);
  if (is_whole && !failed.empty()) throw Error(failed + "; the same command tries it again");
  return is_whole;
}

std::vector<SettingResult> gathered(const Arguments& a, const Experiment& experiment) {
  const std::vector<ExperimentPart> parts = parts_of(experiment);
  std::vector<PartResult> results;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    auto result = result_of(a, parts[i], i, fingerprint_of(a, i, threads_of_each(a)));
    if (!result) throw Error(fmt::format("{}: what was made there is gone; run the command again", folder_of(a, i).string()));
    results.push_back(std::move(*result));
  }
  return outcomes_of(experiment, results);
}

}  // namespace

int benchmark(const Arguments& arguments) {
  set_thread_count(arguments.threads);
  require_writable_folder(arguments.output);
  const Study study = study_of(arguments);
  require_sound(study.experiment);
  if (arguments.benchmark_part) return run_one_part(arguments, study.experiment);
  constexpr double kPatience_s = 5;  // the parts of a benchmark that was killed die with it, but may need a moment
  const auto claim = claim_folder(fs::path(arguments.output) / "batch.lock", FolderClaim::Kind::kAlone, kPatience_s);
  if (!claim) throw Error(fmt::format("another benchmark writes {}: wait, or choose another folder", arguments.output));
  watch_for_interrupt();
  fmt::print("{} homes under {} settings\n", study.experiment.homes.size(), study.experiment.settings.size());
  const Stopwatch stopwatch;
  if (!run_parts(arguments, study.experiment)) {
    tell("interrupted: the same command goes on from here\n");
    return kInterrupted;
  }
  const std::vector<SettingResult> outcomes = gathered(arguments, study.experiment);
  write_report(arguments.output, study, outcomes);
  fmt::print("\n{}\ndone in {:.0f} s\nlook at   {}/report.md and the charts beside it\n", markdown(study, outcomes),
             stopwatch.seconds(), arguments.output);
  if (!arguments.quick || !arguments.group.empty()) return kDone;
  const std::vector<std::string> fallen = below(kQuickFloors, outcomes);
  for (const std::string& line : fallen) tell(fmt::format("below its floor: {}\n", line));
  return fallen.empty() ? kDone : kWorldIsWrong;
}

}  // namespace panoptic
