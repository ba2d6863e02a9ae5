// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/online_counters.h"

#include <string>

#include "panoptic/mapping/publisher.h"
#include "panoptic/profile.h"

namespace panoptic {

void OnlineCounters::arrived(bool dropped, bool passed_over) {
  const std::lock_guard lock(mutex_);
  ++report_.read;
  if (dropped) ++report_.dropped;
  if (passed_over) ++report_.passed_over;
}

void OnlineCounters::unreadable() {
  const std::lock_guard lock(mutex_);
  ++report_.read;
  ++report_.skipped;
}

void OnlineCounters::corrected(const Correction& correction) {
  const std::lock_guard lock(mutex_);
  report_.corrections.push_back(correction);
}

void OnlineCounters::fused(Clock::time_point read_at) {
  const std::lock_guard lock(mutex_);
  ++report_.used;
  geometry_rate_.count(now_s());
  report_.latency.add("fused", seconds_since(read_at));
}

void OnlineCounters::refused() {
  const std::lock_guard lock(mutex_);
  ++report_.skipped;
}

void OnlineCounters::labelled(Clock::time_point read_at) {
  const std::lock_guard lock(mutex_);
  ++report_.labelled;
  label_rate_.count(now_s());
  report_.latency.add("labelled", seconds_since(read_at));
}

void OnlineCounters::visible(const std::vector<Clock::time_point>& read_at) {
  const std::lock_guard lock(mutex_);
  for (const Clock::time_point time : read_at) report_.latency.add("visible", seconds_since(time));
}

void OnlineCounters::took(const char* stage, const Stopwatch& stopwatch) {
  const std::lock_guard lock(mutex_);
  stages_.add(stage, stopwatch.seconds());
}

RunState OnlineCounters::run_state() {
  const std::lock_guard lock(mutex_);
  RunState run;
  run.frames_done = report_.read;
  run.dropped = {{"fusion", report_.dropped}, {"networks", report_.passed_over}};
  run.elapsed_s = now_s();
  run.geometry_hz = geometry_rate_.recent_hz(run.elapsed_s);
  run.label_hz = label_rate_.recent_hz(run.elapsed_s);
  for (const auto& [name, times] : stages_.stages()) run.stages[name] = stage_time(times);
  for (const auto& [name, times] : report_.latency.stages()) run.stages["until " + name] = stage_time(times);
  return run;
}

OnlineReport OnlineCounters::report() const {
  const std::lock_guard lock(mutex_);
  OnlineReport report = report_;
  report.lost = report.read - report.used - report.skipped - report.dropped;
  report.geometry_hz = geometry_rate_.hz();
  report.label_hz = label_rate_.hz();
  return report;
}

Profile OnlineCounters::stages() const {
  const std::lock_guard lock(mutex_);
  return stages_;
}

}  // namespace panoptic
