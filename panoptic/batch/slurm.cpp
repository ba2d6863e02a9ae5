// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/batch/slurm.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>
#include <string_view>

#include "panoptic/base/child_process.h"
#include "panoptic/base/files.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

struct Answer {
  int exit_code = 0;
  std::string text;
};

Answer ask(const Words& command, const fs::path& folder) {
  const fs::path said = folder / "said.txt";
  write_file(said, "");
  const EndedChild ended = wait_for_child(start_child(command, said));
  return {ended.exit_code, read_file(said)};
}

// The answer of squeue, or that there is no squeue at all.
Answer answer_about(const std::string& job, const fs::path& folder) {
  try {
    return ask({"squeue", "--noheader", "--format=%i", "--jobs=" + job}, folder);
  } catch (const Error& e) {
    return {1, e.what()};
  }
}

std::string answer_to(const Words& command, const fs::path& folder) {
  const Answer answer = ask(command, folder);
  if (answer.exit_code == 0) return answer.text;
  throw Error(fmt::format("{} failed: {}; is this a machine from which jobs are submitted?", command.front(), answer.text));
}

// The last line has the number of the job: "12", or "12;cluster".
std::string job_number(const std::string& text) {
  std::string number;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::string begin = line.substr(0, line.find(';'));
    const bool is_number = !begin.empty() && begin.find_first_not_of("0123456789") == std::string::npos;
    if (is_number) number = begin;
  }
  if (number.empty()) throw Error(fmt::format("sbatch gave no number of a job: {}", text));
  return number;
}

fs::path write_script(const fs::path& path, const std::string& line) {
  write_file(path, fmt::format("#!/bin/sh\nexec {}\n", line));
  return path;
}

Words sbatch_words(const char* name) {
  return {"sbatch", "--parsable", fmt::format("--job-name={}", name), fmt::format("--chdir={}", fs::current_path().string())};
}

// Doubles the sign that may stand in a path and means something to sbatch.
std::string output_option(const fs::path& folder, const std::string& name) {
  std::string path;
  for (const char c : folder.string()) path += c == '%' ? std::string("%%") : std::string(1, c);
  return fmt::format("--output={}/{}", path, name);
}

// The tasks from `first` on, as many as an array may have.
std::string submit_array(const SlurmWork& work, std::size_t first, std::size_t count, const std::string& after) {
  Words words = sbatch_words("panoptic");
  const std::string limit = work.at_once > 0 ? fmt::format("%{}", work.at_once) : "";
  words.push_back(fmt::format("--array=0-{}{}", count - 1, limit));
  words.push_back(output_option(work.folder, "%A_%a.log"));
  if (!after.empty()) words.push_back(fmt::format("--dependency=afterany:{}", after));
  words.insert(words.end(), work.options.begin(), work.options.end());
  Words task = work.task;
  std::string line = shell_line({task.begin(), task.begin() + 2}) + " --task $(($1 + SLURM_ARRAY_TASK_ID)) ";
  line += shell_line({task.begin() + 2, task.end()});
  words.push_back(write_script(work.folder / "task.sh", line).string());
  words.push_back(fmt::format("{}", first));
  return job_number(answer_to(words, work.folder));
}

std::string submit_gathering(const SlurmWork& work, const Words& arrays) {
  Words words = sbatch_words("panoptic-gather");
  words.push_back(output_option(work.folder, "gather.log"));
  if (!arrays.empty()) words.push_back(fmt::format("--dependency=afterany:{}", fmt::join(arrays, ":")));
  const Words options = gathering_options(work.options);
  words.insert(words.end(), options.begin(), options.end());
  words.push_back(write_script(work.folder / "gather.sh", shell_line(work.gather)).string());
  return job_number(answer_to(words, work.folder));
}

void write_jobs(const SlurmWork& work, const Words& jobs) {
  write_file(work.folder / "jobs.txt", fmt::format("{}\n", fmt::join(jobs, "\n")));
}

}  // namespace

std::string shell_line(const Words& words) {
  Words quoted;
  for (const std::string& word : words) {
    std::string text;
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    quoted.push_back(fmt::format("'{}'", text));
  }
  return fmt::format("{}", fmt::join(quoted, " "));
}

Words gathering_options(const Words& options) {
  constexpr std::array<std::string_view, 3> kLong = {"--partition", "--account", "--qos"};
  constexpr std::array<std::string_view, 3> kShort = {"-p", "-A", "-q"};
  Words kept;
  bool has_value_to_come = false;
  for (const std::string& word : options) {
    const std::string name = word.substr(0, word.find('='));
    const bool is_long = std::ranges::find(kLong, name) != kLong.end();
    const bool is_short = std::ranges::find(kShort, word.substr(0, 2)) != kShort.end();
    if (is_long || is_short || has_value_to_come) kept.push_back(word);
    has_value_to_come = (is_long && name == word) || (is_short && word.size() == 2);
  }
  return kept;
}

std::size_t max_array_size(const std::string& config) {
  const std::size_t key = config.find("MaxArraySize");
  const std::size_t digit = key == std::string::npos ? key : config.find_first_of("0123456789", key);
  std::size_t size = 0;
  if (digit != std::string::npos) std::from_chars(config.data() + digit, config.data() + config.size(), size);
  if (size > 1) return size - 1;  // the largest number of a task is one below it, and we keep clear of the limit
  throw Error("scontrol show config: no MaxArraySize above 1: this site does not allow arrays of jobs; use --jobs");
}

std::vector<std::string> submit(const SlurmWork& work) {
  require_writable_folder(work.folder);
  const std::size_t most = max_array_size(answer_to({"scontrol", "show", "config"}, work.folder));
  Words jobs;
  for (std::size_t first = 0; first < work.tasks; first += most) {
    // A limit on tasks at a time is one of an array: the next array waits.
    const std::string after = work.at_once > 0 && !jobs.empty() ? jobs.back() : "";
    jobs.push_back(submit_array(work, first, std::min(most, work.tasks - first), after));
    write_jobs(work, jobs);
  }
  jobs.push_back(submit_gathering(work, jobs));
  write_jobs(work, jobs);
  return jobs;
}

std::vector<std::string> jobs_not_done(const fs::path& folder) {
  if (!is_file(folder / "jobs.txt")) return {};
  Words left;
  std::istringstream jobs(read_file(folder / "jobs.txt"));
  for (std::string job; std::getline(jobs, job);) {
    // Slurm forgets jobs that are long done, and calls them invalid.
    const Answer answer = answer_about(job, folder);
    if (answer.exit_code == 0 && answer.text.find_first_of("0123456789") != std::string::npos) left.push_back(job);
    if (answer.exit_code != 0 && answer.text.find("Invalid job id") == std::string::npos) {
      throw Error(fmt::format("{} was submitted to Slurm, which does not say whether it is done: {}; remove {} if it is",
                              folder.parent_path().string(), answer.text, (folder / "jobs.txt").string()));
    }
  }
  return left;
}

}  // namespace panoptic
