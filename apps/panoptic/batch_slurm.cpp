// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A batch on a cluster: what it submits, and what the tasks then find.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <sstream>

#include "apps/panoptic/batch_plan.h"
#include "apps/panoptic/progress.h"
#include "panoptic/base/child_process.h"
#include "panoptic/base/files.h"
#include "panoptic/batch/slurm.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

fs::path slurm_folder(const Arguments& a) { return fs::absolute(a.output).lexically_normal() / "slurm"; }

// The list as it is now: it may change before the tasks run.
fs::path freeze_list(const fs::path& folder, const BatchPlan& plan) {
  std::string scenes;
  for (const SceneRecord& record : plan.records) scenes += record.scene.recording + "\n";
  write_file(folder / "scenes.txt", scenes);
  std::string tasks;
  for (const SceneTask& task : plan.tasks) tasks += task.record.scene.name + "\n";
  write_file(folder / "tasks.txt", tasks);
  return folder / "scenes.txt";
}

// The same batch, of the frozen list, by this very file of the program.
std::vector<std::string> batch_command(const Arguments& a, const fs::path& list) {
  std::vector<std::string> words{fs::read_symlink(kThisProgram).string(), "batch", list.string(), "-o",
                                 fs::absolute(a.output).lexically_normal().string()};
  if (a.with_truth) words.emplace_back("--gt");
  if (!a.shared_predictions.empty()) words.insert(words.end(), {"--share-predictions", a.shared_predictions});
  return words;
}

void add_run_options(const Arguments& a, std::vector<std::string>& words) {
  if (a.run_options.empty()) return;
  words.emplace_back("--");
  words.insert(words.end(), a.run_options.begin(), a.run_options.end());
}

}  // namespace

void submit_batch(const Arguments& a, const BatchPlan& plan) {
  const fs::path folder = slurm_folder(a);
  require_writable_folder(folder);
  SlurmWork work{.folder = folder, .tasks = plan.tasks.size(), .at_once = a.jobs.value_or(0), .options = a.slurm_options};
  work.task = batch_command(a, freeze_list(folder, plan));
  work.gather = work.task;
  work.gather.emplace_back("--gather");
  add_run_options(a, work.task);
  add_run_options(a, work.gather);
  const std::vector<std::string> jobs = submit(work);
  fmt::print("{} of {} scenes submitted, jobs {}\nread      {}/batch.md when the last of them is done\n", plan.tasks.size(),
             plan.records.size(), fmt::join(jobs, " "), a.output);
}

std::string scene_of_task(const Arguments& a) {
  const fs::path file = slurm_folder(a) / "tasks.txt";
  std::istringstream names(read_file(file));
  std::string name;
  for (std::size_t i = 0; i <= *a.slurm_task; ++i) {
    if (!std::getline(names, name)) throw Error(fmt::format("{}: no task {}", file.string(), *a.slurm_task));
  }
  return name;
}

void require_no_submission(const Arguments& a) {
  const std::vector<std::string> jobs = jobs_not_done(slurm_folder(a));
  if (jobs.empty()) return;
  throw Error(fmt::format("{} is being made by Slurm's jobs {}: wait until they are done, or scancel them", a.output,
                          fmt::join(jobs, " ")));
}

}  // namespace panoptic
