// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/panoptic/batch_plan.h"
#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/base/child_process.h"
#include "panoptic/base/files.h"
#include "panoptic/batch/batch_report.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

// `patience_s`: how long somebody else may still have it. Throws Error.
std::unique_ptr<FolderClaim> claimed(const fs::path& lock_file, FolderClaim::Kind kind, double patience_s) {
  if (auto claim = claim_folder(lock_file, kind, patience_s)) return claim;
  throw Error(
      fmt::format("another batch writes {}: wait until it is done, or choose another folder", lock_file.parent_path().string()));
}

// The programs of a batch that was killed die with it, but may need a moment.
constexpr double kPatience_s = 5;

// Tasks may begin while the batch that submits them, or one that is refused, still has the folder.
constexpr double kPatienceOfTasks_s = 60;

BatchReport report_of(const Arguments& a, const BatchPlan& plan) {
  BatchReport report;
  report.list = a.dataset;
  report.run_options = a.run_options;
  report.jobs = a.jobs.value_or(1);
  report.skipped = plan.records.size() - plan.tasks.size();
  report.scenes = plan.records;
  return report;
}

void take(const SceneRecord& record, BatchReport& report) {
  const auto place = std::ranges::find(report.scenes, record.scene.name, [](const SceneRecord& r) { return r.scene.name; });
  *place = record;
}

// Runs what is not finished; false if interrupted.
bool run_plan(const Arguments& a, const BatchPlan& plan, BatchReport& report) {
  const Stopwatch stopwatch;
  write_batch_report(a.output, report);
  if (plan.tasks.empty()) return true;
  Progress progress("scenes", plan.tasks.size());
  std::size_t done = 0;
  const BatchWatch watch{[&](const SceneRecord& record) {
                           take(record, report);
                           report.wall_s = stopwatch.seconds();
                           write_batch_report(a.output, report);
                           if (record.state == SceneState::kFailed) {
                             tell(fmt::format("\n{}: failed: {}\n", record.scene.name, record.reason));
                           } else if (!record.reason.empty()) {
                             tell(fmt::format("\n{}: not scored: {}\n", record.scene.name, record.reason));
                           }
                           progress.advance(++done);
                         },
                         [] { return !interrupted(); }};
  const bool is_whole = run_scenes(plan.tasks, a.jobs.value_or(1), watch);
  report.wall_s = stopwatch.seconds();
  return is_whole;
}

void tell_left_out(const BatchPlan& plan, const std::string& folder) {
  if (plan.left_out.empty()) return;
  tell(fmt::format("note: {} names in {} are no recordings and are left out, {} for one\n", plan.left_out.size(), folder,
                   plan.left_out.front()));
}

// The end of a batch: scores, report, and what it says in a line.
int conclude(const Arguments& a, BatchReport& report, bool is_whole) {
  if (a.with_truth && is_whole) report.scores = write_batch_scores(a.output, report.scenes);
  write_batch_report(a.output, report);
  const std::size_t failed = count(report, SceneState::kFailed);
  const std::size_t waiting = count(report, SceneState::kWaiting);
  fmt::print("{}{} scenes: {} done ({} before), {} failed, {} waiting; {:.0f} s\nread      {}/batch.md, batch.json\n",
             report.scores, report.scenes.size(), count(report, SceneState::kFinished), report.skipped, failed, waiting,
             report.wall_s, a.output);
  if (!is_whole) {
    tell("interrupted: the same command goes on from here\n");
    return kInterrupted;
  }
  const std::size_t unscored = count_unscored(report);
  if (failed + waiting + unscored == 0) return kDone;
  throw Error(
      fmt::format("{} of {} scenes failed; {}/batch.md says why, and log.txt in their folders; the same command tries them again",
                  failed + waiting + unscored, report.scenes.size(), a.output));
}

// One scene, as a task of a submitted batch. Others run beside it.
int run_task(const Arguments& a) {
  const std::string name = scene_of_task(a);
  const auto shared = claimed(fs::path(a.output) / "batch.lock", FolderClaim::Kind::kShared, kPatienceOfTasks_s);
  BatchPlan plan = plan_batch(a, name);
  const fs::path folder = plan.tasks.front().folder;
  require_writable_folder(folder);
  const auto claim = claimed(folder / "scene.lock", FolderClaim::Kind::kAlone, kPatience_s);
  leave_out_finished(plan);
  if (plan.tasks.empty()) return kDone;
  watch_for_interrupt();
  SceneRecord result;
  const bool is_whole = run_scenes(plan.tasks, 1, {[&](const SceneRecord& r) { result = r; }, [] { return !interrupted(); }});
  if (!is_whole) return kInterrupted;
  if (!result.reason.empty()) throw Error(fmt::format("{}: {}", name, result.reason));
  return kDone;
}

// Reports the records that the tasks of a submitted batch left.
int gather(const Arguments& a, const BatchPlan& plan) {
  BatchReport report = report_of(a, plan);
  for (SceneRecord& scene : report.scenes) {
    const auto record = read_record(fs::path(a.output) / scene.scene.name);
    if (!record || record->fingerprint != scene.fingerprint) continue;
    scene = *record;
    if (scene.state == SceneState::kFinished && !a.with_truth) scene.reason.clear();
  }
  return conclude(a, report, true);
}

}  // namespace

int batch(const Arguments& a) {
  if (a.slurm_task) return run_task(a);
  BatchPlan plan = plan_batch(a);
  require_writable_folder(a.output);
  const double patience_s = a.slurm_gather ? kPatienceOfTasks_s : kPatience_s;
  const auto claim = claimed(fs::path(a.output) / "batch.lock", FolderClaim::Kind::kAlone, patience_s);
  if (!a.slurm_gather) require_no_submission(a);
  leave_out_finished(plan);
  if (a.slurm_gather) return gather(a, plan);
  tell_left_out(plan, a.dataset);
  if (a.with_truth || !plan.tasks.empty()) remove_batch_scores(a.output);
  if (a.slurm) {
    submit_batch(a, plan);
    return kDone;
  }
  watch_for_interrupt();
  fmt::print("{} scenes, {} of them finished before\n", plan.records.size(), plan.records.size() - plan.tasks.size());
  std::fflush(stdout);
  BatchReport report = report_of(a, plan);
  const bool is_whole = run_plan(a, plan, report);
  return conclude(a, report, is_whole);
}

}  // namespace panoptic
