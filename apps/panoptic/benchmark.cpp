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
  write_json_file(folder_of(a, *a.benchmark_part) / kResult, to_json(*result));
  return kDone;
}

// Each part as a scene of a batch.
std::vector<SceneTask> tasks_of(const Arguments& a, const Experiment& experiment) {
  const std::vector<ExperimentPart> parts = parts_of(experiment);
  const int jobs = a.jobs.value_or(1);
  Fingerprint program;
  program.add_this_program();
  std::vector<SceneTask> tasks;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const SimulationOptions& home = experiment.homes[parts[i].home];
    SceneTask& task = tasks.emplace_back();
    std::vector<std::string> command{kThisProgram, "benchmark", "-o", a.output, "--part", fmt::format("{}", i)};
    if (a.quick) command.emplace_back("--quick");
    if (!a.group.empty()) command.insert(command.end(), {"--group", a.group});
    Fingerprint input = program;
    for (std::size_t word = 2; word < command.size(); ++word) input.add(command[word]);
    const int threads = std::max(1, (a.threads > 0 ? a.threads : thread_count()) / jobs);
    command.insert(command.end(), {"--threads", fmt::format("{}", threads)});
    task.record.scene = {fmt::format("{}", i), fmt::format("sim:{},rooms={}", home.seed, home.rooms)};
    task.record.fingerprint = input.text();
    task.folder = fs::absolute(folder_of(a, i));
    task.steps.push_back({std::move(command), {}, {}, {}});
    task.leaves_map = false;
  }
  return tasks;
}

// Works on all parts that are not finished; false if interrupted. Throws Error if one failed.
bool run_parts(const Arguments& a, const Experiment& experiment) {
  std::vector<SceneTask> tasks = tasks_of(a, experiment);
  const std::size_t all = tasks.size();
  std::erase_if(tasks, [](const SceneTask& task) { return is_finished(read_record(task.folder), task.record.fingerprint); });
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
  std::vector<PartResult> results;
  for (std::size_t i = 0; i < parts_of(experiment).size(); ++i) {
    const fs::path file = folder_of(a, i) / kResult;
    results.push_back(part_result_in(read_json_file(file), file.string()));
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
  const FolderClaim claim(fs::path(arguments.output) / "batch.lock", FolderClaim::Kind::kAlone);
  if (!claim.is_ours()) throw Error(fmt::format("another benchmark writes {}: wait, or choose another folder", arguments.output));
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
