// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The seam to Slurm: its commands sbatch, scontrol and squeue.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace panoptic {

// A program that runs for each of many tasks, and one that runs when all of them have ended, however that was.
struct SlurmWork {
  std::filesystem::path folder;   // absolute; for scripts, logs and the numbers of the jobs
  std::vector<std::string> task;  // `--task N` is put behind its first word but one, N from 0
  std::vector<std::string> gather;
  std::size_t tasks = 0;
  int at_once = 0;                   // tasks at most; 0 = as many as Slurm likes
  std::vector<std::string> options;  // of sbatch, for the tasks; the gathering takes some of them
};

// Submits the tasks as arrays that the site allows, and the gathering as a job that depends on them. Returns the numbers of the
// jobs, the gathering last. Throws Error: Slurm is not here, or refuses.
std::vector<std::string> submit(const SlurmWork& work);

// The jobs that were submitted from this folder and are not done. Throws Error if Slurm is not here to say so.
std::vector<std::string> jobs_not_done(const std::filesystem::path& folder);

// The largest array of the site, from what `scontrol show config` prints. Throws Error.
std::size_t max_array_size(const std::string& config);

// The options that the gathering takes over from the tasks: partition, account and quality of service.
std::vector<std::string> gathering_options(const std::vector<std::string>& options);

// The words as a line that a POSIX shell takes apart into the same words.
std::string shell_line(const std::vector<std::string>& words);

}  // namespace panoptic
