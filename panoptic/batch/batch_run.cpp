// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/batch/batch_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <thread>

#include "panoptic/base/child_process.h"
#include "panoptic/base/files.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kPause{10};  // between two looks at the programs
constexpr double kPatience_s = 20;               // until a program that was asked to end is killed
constexpr int kKilledBy = 128;

std::string log_of(const SceneTask& task) { return (task.folder / "log.txt").string(); }

// A scene that is being made.
struct Course {
  const SceneTask* task = nullptr;
  SceneRecord record;
  std::size_t step = 0;
  std::optional<int> child;
  bool is_mapped = false;  // and recorded: only the scoring is left
  double mapped_s = 0;     // that the map took
  Stopwatch since_start;
};

void remove_tree(const fs::path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error) throw FileError(fmt::format("cannot remove {}: {}; check its permissions", path.string(), error.message()));
}

// Removes earlier results, which are not to be taken for those of what begins now.
void remove_outdated(const Course& course) {
  const SceneTask& task = *course.task;
  if (!course.is_mapped) {
    remove_record(task.folder);
    write_file(log_of(task), "");
  } else if (course.record.scored) {
    SceneRecord unscored = task.record;
    unscored.scored = false;
    unscored.truth.clear();
    write_record(task.folder, unscored);
  }
  for (const fs::path& path : task.outdated) remove_tree(path);
}

void begin_attempt(Course& course) {
  const SceneTask& task = *course.task;
  require_writable_folder(task.folder);
  remove_outdated(course);
  course.record.scored = false;
  course.record.truth.clear();
  course.record.reason.clear();
  course.step = course.is_mapped ? task.steps.size() - 1 : 0;
  if (!course.is_mapped) course.record.peak_mb = 0;
  ++course.record.attempts;
  course.since_start = Stopwatch();
}

// Why a folder that is there already cannot stand for what the step makes; empty if it can.
std::string difference_of(const BatchStep& step) {
  const fs::path file = step.made / "made_by.txt";
  if (is_file(file) && read_file(file) == step.made_by) return "";
  return fmt::format("{} was made by another program, or of other networks, options, frames or recordings; choose another folder",
                     step.made.string());
}

// Starts the next program that is needed; false if all are done, or with the reason why it cannot be.
bool start_next(Course& course) {
  for (; course.step < course.task->steps.size(); ++course.step) {
    const BatchStep& step = course.task->steps[course.step];
    if (!step.made.empty() && is_there(step.made)) {
      course.record.reason = difference_of(step);
      if (course.record.reason.empty()) continue;
      return false;
    }
    if (!step.partial.empty()) remove_tree(step.partial);  // of an attempt that was cut short
    course.child = start_child(step.command, log_of(*course.task));
    return true;
  }
  return false;
}

// Gives what a step made its name. Where another batch was faster, its result must be the same. Returns the reason if it is not.
std::string keep_made(const BatchStep& step) {
  if (step.made.empty()) return "";
  write_file(step.partial / "made_by.txt", step.made_by);
  if (os::rename(step.partial, step.made)) return "";
  if (!is_there(step.made)) throw FileError(fmt::format("cannot give {} its name {}", step.partial.string(), step.made.string()));
  remove_tree(step.partial);
  return difference_of(step);
}

std::string reason_of(const EndedChild& ended, const SceneTask& task) {
  const std::string said = last_error(read_file(log_of(task)));
  if (ended.exit_code == kKilledBy + SIGKILL) {
    return fmt::format("killed (by the system, if it ran out of memory); the last line was: {}", said);
  }
  if (ended.exit_code > kKilledBy)
    return fmt::format("ended by signal {}; the last line was: {}", ended.exit_code - kKilledBy, said);
  return said.empty() ? fmt::format("exit code {}", ended.exit_code) : said;
}

// Takes what the run left. The record stands from now on, whatever becomes of the scores.
void conclude_map(Course& course) {
  try {
    if (course.task->leaves_map) take_results(course.task->folder, course.record);
  } catch (const Error& e) {
    course.record.reason = e.what();
    return;
  }
  course.mapped_s = course.since_start.seconds();
  course.since_start = Stopwatch();
  course.record.wall_s = course.mapped_s;
  course.is_mapped = true;
  SceneRecord record = course.record;
  record.state = SceneState::kFinished;
  write_record(course.task->folder, record);
}

// Fills the record of a scene whose programs are all done, or one of them has failed.
void conclude(Course& course) {
  const SceneTask& task = *course.task;
  if (course.record.reason.empty() && !course.is_mapped) conclude_map(course);
  course.record.wall_s = course.mapped_s + course.since_start.seconds();
  if (!course.record.reason.empty()) return;
  course.record.scored = task.scores;
  if (task.scores) course.record.truth = task.truth;
  course.record.state = SceneState::kFinished;
}

// Takes a program that has ended into account.
void take_end(Course& course, const EndedChild& ended) {
  const SceneTask& task = *course.task;
  course.child.reset();
  course.record.peak_mb = std::max(course.record.peak_mb, ended.peak_mb);
  course.record.reason = ended.exit_code == 0 ? keep_made(task.steps[course.step]) : reason_of(ended, task);
  if (!course.record.reason.empty()) return;
  ++course.step;
  if (task.scores && !course.is_mapped && course.step + 1 == task.steps.size()) conclude_map(course);
}

// Takes the scene as far as it goes without waiting; true once it has ended.
bool advance(Course& course) {
  if (course.child) {
    const std::optional<EndedChild> ended = ended_child(*course.child);
    if (!ended) return false;
    take_end(course, *ended);
  }
  if (course.record.reason.empty() && start_next(course)) return false;
  conclude(course);
  if (course.record.state == SceneState::kFinished) return true;
  if (course.record.attempts >= kMostAttempts) {
    course.record.state = course.is_mapped ? SceneState::kFinished : SceneState::kFailed;
    return true;
  }
  begin_attempt(course);
  return false;
}

void end_children(std::vector<std::unique_ptr<Course>>& running) {
  for (const auto& course : running) {
    if (course->child) ask_child_to_end(*course->child);
  }
  const Stopwatch since_asked;
  for (const auto& course : running) {
    while (course->child && !ended_child(*course->child)) {
      if (since_asked.seconds() > kPatience_s) kill_child(*course->child);
      std::this_thread::sleep_for(kPause);
    }
    course->child.reset();
  }
}

std::unique_ptr<Course> begin(const SceneTask& task) {
  auto course = std::make_unique<Course>();
  course->task = &task;
  course->record = task.record;
  course->record.state = SceneState::kWaiting;
  course->record.attempts = 0;
  course->is_mapped = task.is_mapped;
  course->mapped_s = task.is_mapped ? task.record.wall_s : 0;
  begin_attempt(*course);
  return course;
}

// One look at every scene that runs; those that have ended are recorded.
void look_after(std::vector<std::unique_ptr<Course>>& running, const BatchWatch& watch) {
  for (const auto& course : running) {
    // An interruption that reaches everybody is no failure of the scene.
    if (!watch.go_on() || !advance(*course)) continue;
    write_record(course->task->folder, course->record);
    watch.ended(course->record);
  }
  std::erase_if(running, [](const auto& course) { return course->record.state != SceneState::kWaiting; });
}

}  // namespace

bool run_scenes(const std::vector<SceneTask>& tasks, int jobs, const BatchWatch& watch) {
  std::vector<std::unique_ptr<Course>> running;
  std::size_t next = 0;
  try {
    while (next < tasks.size() || !running.empty()) {
      if (!watch.go_on()) {
        end_children(running);
        return false;
      }
      while (next < tasks.size() && running.size() < static_cast<std::size_t>(jobs)) running.push_back(begin(tasks[next++]));
      look_after(running, watch);
      std::this_thread::sleep_for(kPause);
    }
  } catch (...) {
    end_children(running);
    throw;
  }
  return true;
}

}  // namespace panoptic
