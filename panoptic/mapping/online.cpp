// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/online.h"

#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "panoptic/base/config.h"
#include "panoptic/base/os.h"
#include "panoptic/error.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/online_stages.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/mapping/published_map.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

constexpr const char* kDropped = "dropped: fusion was behind";

// A stage on a thread of its own; whatever it throws ends the run.
std::jthread start(const char* name, SharedRun& run, void (*stage)(SharedRun&)) {
  std::jthread thread([&run, stage] {
    try {
      stage(run);
    } catch (...) {
      fail(run, std::current_exception());
    }
  });
  os::name_thread(thread, name);
  return thread;
}

}  // namespace

Fields fields(OnlineOptions& o) {
  return {
      {"mesh_every_s", &o.mesh_every_s, "seconds between two snapshots of the surface for those who look on",
       in_range(0.05, 3600)},
      {"regularize_every_s", &o.regularize_every_s, "seconds between two regularizations; it also runs at the end",
       in_range(0.1, 1e6)},
      {"waiting_frames", &o.waiting_frames, "a frame that comes while so many wait for fusion is dropped", in_range(1, 1000)}};
}

struct OnlinePipeline::Inside {
  Inside(const Parts& parts, const OnlineOptions& options);
  ~Inside() { end_stages(); }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;

  void start_stages();
  void end_stages();
  bool take(Frame frame, bool when_free);

  const LabelSet labels;  // of the map, which changes places while it is corrected
  LatestSnapshot unseen;  // where nobody looks on
  LatestSnapshot& latest;
  SharedRun run;
  std::jthread fusion, networks, semantic, regularizer, mesher;
  std::optional<OnlineReport> report;
};

OnlinePipeline::Inside::Inside(const Parts& parts, const OnlineOptions& options)
    : labels(parts.mapper.map().labels),
      latest(parts.latest != nullptr ? *parts.latest : unseen),
      run{.parts = parts,
          .options = options,
          .halves = parts.predictor != nullptr ? parts.predictor->halves() : std::nullopt,
          .publisher = SnapshotPublisher(latest),
          .jobs = BoundedQueue<FusionJob>(static_cast<std::size_t>(options.waiting_frames))} {}

OnlinePipeline::OnlinePipeline(const Parts& parts, const OnlineOptions& options)
    : inside_(std::make_unique<Inside>(parts, options)) {
  inside_->start_stages();
}

OnlinePipeline::~OnlinePipeline() {
  stop("abandoned");
  finish();
}

void OnlinePipeline::Inside::start_stages() {
  fusion = start("fusion", run, fuse_jobs);
  if (run.parts.predictor != nullptr) networks = start("networks", run, predict_newest);
  if (run.halves) semantic = start("semantic", run, run_semantic_network);
  regularizer = start("regularizer", run, regularize_now_and_then);
  mesher = start("mesher", run, publish_now_and_then);
}

// In the order in which work flows, so that each stage gets what the one before it still gives. To let go of a thread is to
// wait for its end.
void OnlinePipeline::Inside::end_stages() {
  run.newest.close();
  networks = {};
  run.semantic_todo.close();
  semantic = {};
  run.jobs.close();
  fusion = {};
  run.control.end();
  regularizer = {};
  mesher = {};
}

// The networks learn of a frame only now that its geometry is on its way, so its labels can never come first.
bool OnlinePipeline::Inside::take(Frame frame, bool when_free) {
  if (run.control.stopped()) return false;
  const auto arrived = std::make_shared<const ArrivedFrame>(ArrivedFrame{kept(std::move(frame)), RunControl::Clock::now()});
  const Pushed pushed = when_free ? run.jobs.push({arrived}) : run.jobs.try_push({arrived});
  const bool dropped = pushed == Pushed::kFull;
  const bool passed_over = pushed == Pushed::kYes && run.parts.predictor != nullptr && run.newest.put(arrived);
  if (dropped && run.parts.recorder != nullptr) run.dropped.put(record_of(arrived->frame, false, Outcome::refused(kDropped)));
  run.counters.arrived(dropped, passed_over);
  return pushed == Pushed::kYes;
}

bool OnlinePipeline::push(Frame frame) { return inside_->take(std::move(frame), false); }
bool OnlinePipeline::push_when_free(Frame frame) { return inside_->take(std::move(frame), true); }

bool OnlinePipeline::update_poses(std::vector<PoseUpdate> poses) {
  SharedRun& run = inside_->run;
  if (!run.parts.read_again && !run.parts.mapper.parts().keeps_copies()) {
    throw Error("the map cannot follow corrected poses: Parts::read_again is missing, and map.log is not copy");
  }
  return !run.control.stopped() && run.jobs.push({.poses = std::move(poses)}) == Pushed::kYes;
}

bool OnlinePipeline::is_correcting() const { return inside_->run.is_correcting; }

void OnlinePipeline::skip(const SkippedFrame& frame) {
  SharedRun& run = inside_->run;
  {
    const std::lock_guard lock(run.mapper_mutex);
    run.parts.mapper.skip(frame);
    if (run.parts.recorder != nullptr) run.parts.recorder->not_given({.frame = frame.index, .unused_because = frame.reason});
  }
  run.counters.unreadable();
}

PublishedMap OnlinePipeline::published() const { return published_map(*inside_->latest.newest(), inside_->labels); }

void OnlinePipeline::stop(const std::string& why) { inside_->run.control.stop(why); }
bool OnlinePipeline::stopped() const { return inside_->run.control.stopped(); }

OnlineReport OnlinePipeline::finish() {
  SharedRun& run = inside_->run;
  if (inside_->report) return *inside_->report;
  inside_->end_stages();
  record_dropped(run);
  try {
    if (!run.control.failure()) run.parts.mapper.finish();
    publish(run, true);
  } catch (...) {
    fail(run, std::current_exception());
  }
  run.parts.mapper.profile().add(run.counters.stages());
  OnlineReport& report = inside_->report.emplace(run.counters.report());
  report.stopped_by = run.control.stopped_by();
  report.failure = run.control.failure();
  return report;
}

}  // namespace panoptic
