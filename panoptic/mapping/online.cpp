// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/online.h"

#include <pthread.h>

#include <mutex>
#include <thread>
#include <utility>

#include "panoptic/base/config.h"
#include "panoptic/mapping/online_stages.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

constexpr const char* kDropped = "dropped: fusion was behind";

// A stage on a thread of its own; whatever it throws ends the run.
std::thread start(const char* name, SharedRun& run, void (*stage)(SharedRun&)) {
  std::thread thread([&run, stage] {
    try {
      stage(run);
    } catch (...) {
      fail(run, std::current_exception());
    }
  });
  pthread_setname_np(thread.native_handle(), name);  // for top and debuggers
  return thread;
}

void join(std::thread& thread) {
  if (thread.joinable()) thread.join();
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
  SharedRun run;
  std::thread fusion = {}, networks = {}, semantic = {}, regularizer = {}, mesher = {};
  bool finished = false;
  OnlineReport report = {};

  void start_stages();
  void end_stages();
  bool hand_over(const SharedFrame& arrived, BoundedQueue<FusionJob>::Pushed pushed);
};

OnlinePipeline::OnlinePipeline(const Parts& parts, const OnlineOptions& options)
    : unseen_(std::make_unique<LatestSnapshot>()),
      inside_(new Inside{{.options = options,
                          .total = parts.total,
                          .before_work = parts.before_work,
                          .predictor = parts.predictor,
                          .halves = parts.predictor != nullptr ? parts.predictor->halves() : std::nullopt,
                          .mapper = parts.mapper,
                          .recorder = parts.recorder,
                          .publisher = SnapshotPublisher(parts.latest != nullptr ? *parts.latest : *unseen_),
                          .jobs = BoundedQueue<FusionJob>(static_cast<std::size_t>(options.waiting_frames))}}) {
  try {
    inside_->start_stages();
  } catch (...) {
    fail(inside_->run, std::current_exception());
    inside_->end_stages();
    throw;
  }
}

OnlinePipeline::~OnlinePipeline() {
  stop("abandoned");
  finish();
}

void OnlinePipeline::Inside::start_stages() {
  fusion = start("fusion", run, fuse_jobs);
  if (run.predictor != nullptr) networks = start("networks", run, predict_newest);
  if (run.halves) semantic = start("semantic", run, run_semantic_network);
  regularizer = start("regularizer", run, regularize_now_and_then);
  mesher = start("mesher", run, publish_now_and_then);
}

// In the order in which work flows, so that each stage gets what the one before it still gives.
void OnlinePipeline::Inside::end_stages() {
  run.newest.close();
  join(networks);
  run.semantic_todo.close();
  join(semantic);
  run.jobs.close();
  join(fusion);
  run.control.end();
  join(regularizer);
  join(mesher);
}

// The networks learn of a frame only now that its geometry is on its way, so its labels can never come first.
bool OnlinePipeline::Inside::hand_over(const SharedFrame& arrived, BoundedQueue<FusionJob>::Pushed pushed) {
  using Pushed = BoundedQueue<FusionJob>::Pushed;
  using Arrival = OnlineCounters::Arrival;
  const bool taken = pushed == Pushed::kYes;
  const bool dropped = pushed == Pushed::kFull;
  const bool passed_over = taken && run.predictor != nullptr && run.newest.put(arrived);
  if (dropped && run.recorder != nullptr) run.dropped.put(record_of(arrived->frame, false, Outcome::refused(kDropped)));
  run.counters.arrived(taken ? Arrival::kTaken : dropped ? Arrival::kDropped : Arrival::kTooLate, passed_over);
  return taken;
}

bool OnlinePipeline::push(Frame frame) {
  if (stopped()) return false;
  const auto arrived = std::make_shared<const ArrivedFrame>(ArrivedFrame{kept(std::move(frame)), RunControl::Clock::now()});
  return inside_->hand_over(arrived, inside_->run.jobs.try_push({arrived, nullptr}));
}

bool OnlinePipeline::push_when_free(Frame frame) {
  using Pushed = BoundedQueue<FusionJob>::Pushed;
  if (stopped()) return false;
  const auto arrived = std::make_shared<const ArrivedFrame>(ArrivedFrame{kept(std::move(frame)), RunControl::Clock::now()});
  return inside_->hand_over(arrived, inside_->run.jobs.push({arrived, nullptr}) ? Pushed::kYes : Pushed::kClosed);
}

void OnlinePipeline::skip(const SkippedFrame& frame) {
  SharedRun& run = inside_->run;
  {
    const std::lock_guard lock(run.mapper_mutex);
    run.mapper.skip(frame);
    if (run.recorder != nullptr) run.recorder->not_given({.frame = frame.index, .unused_because = frame.reason});
  }
  run.counters.unreadable();
}

void OnlinePipeline::stop(const std::string& why) { inside_->run.control.stop(why); }
bool OnlinePipeline::stopped() const { return inside_->run.control.stopped(); }

OnlineReport OnlinePipeline::finish() {
  SharedRun& run = inside_->run;
  if (std::exchange(inside_->finished, true)) return inside_->report;
  inside_->end_stages();
  record_dropped(run);
  try {
    if (!run.control.failure()) run.mapper.finish();
    publish(run, true);
  } catch (...) {
    fail(run, std::current_exception());
  }
  run.mapper.profile().add(run.counters.stages());
  OnlineReport& report = inside_->report;
  report = run.counters.report();
  report.stopped_by = run.control.stopped_by();
  report.failure = run.control.failure();
  return report;
}

}  // namespace panoptic
