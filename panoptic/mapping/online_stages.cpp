// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/online_stages.h"

#include <algorithm>
#include <mutex>
#include <span>
#include <utility>

#include "panoptic/base/memory.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

using Clock = RunControl::Clock;

// The frame goes into the map file; blocks are copied if it is time, so the mapper must be held.
void record(SharedRun& run, const ArrivedFrame& arrived, const Frame& frame, const Outcome& outcome) {
  if (run.parts.recorder == nullptr) return;
  record_dropped(run);
  arrived.position = run.parts.recorder->frame(frame, false, outcome);
  run.parts.recorder->save_if_due(run.parts.mapper);
}

// The frame with the pose that counts; nullptr if the camera is lost.
std::shared_ptr<const Frame> located(const SharedRun& run, const SharedFrame& arrived) {
  return run.parts.tracker != nullptr ? arrived->located : std::shared_ptr<const Frame>(arrived, &arrived->frame);
}

// Finds the pose of the frame. Tracking reads voxels, so the mapper must be held.
Outcome locate(SharedRun& run, const ArrivedFrame& arrived) {
  const Stopwatch tracking;
  Frame frame = arrived.frame;
  Outcome outcome = run.parts.tracker->locate(frame, run.parts.mapper.map().voxels, std::nullopt);
  run.counters.took("locate", tracking);
  if (outcome.used) {
    arrived.located = std::make_shared<const Frame>(std::move(frame));
    return outcome;
  }
  run.parts.mapper.skip({frame.index, outcome.reason});
  if (run.parts.recorder != nullptr) {
    record_dropped(run);
    run.parts.recorder->not_given({.frame = frame.index, .time_s = frame.time_s, .unused_because = outcome.reason});
  }
  return outcome;
}

Outcome add_geometry(SharedRun& run, const SharedFrame& arrived) {
  const std::lock_guard lock(run.mapper_mutex);
  if (run.parts.tracker != nullptr) {
    if (Outcome outcome = locate(run, *arrived); !outcome.used) return outcome;
  }
  const std::shared_ptr<const Frame> frame = located(run, arrived);
  Outcome outcome = run.parts.mapper.add_geometry(*frame);
  record(run, *arrived, *frame, outcome);
  if (!outcome.used) return outcome;
  run.publisher.fused(frame);
  run.fused_unseen.push_back(arrived->read_at);
  return outcome;
}

// Says that the map is being fused anew, as long as it lives.
class Correcting {
 public:
  explicit Correcting(std::atomic<bool>& is_correcting) : is_correcting_(is_correcting) { is_correcting_.store(true); }
  ~Correcting() { is_correcting_.store(false); }
  Correcting(const Correcting&) = delete;
  Correcting& operator=(const Correcting&) = delete;

 private:
  std::atomic<bool>& is_correcting_;
};

// The mapper is held for two moments alone. Its surface is ready before the maps change places, and the old one is destroyed
// afterwards, so that nobody has to wait for either.
void correct(SharedRun& run, std::span<const PoseUpdate> poses) {
  run.parts.before_work("correction");
  const Correcting correcting(run.is_correcting);
  const std::lock_guard no_regularizer(run.regularizing);
  const Stopwatch stopwatch;
  MapperParts& parts = run.parts.mapper.parts();
  Stopwatch holding;
  const auto begin = [&] {
    const std::lock_guard lock(run.mapper_mutex);
    holding = Stopwatch();
    return parts.begin_anew(poses);
  };
  MapAnew anew = begin();
  Correction& correction = anew.correction;
  correction.pause_ms = 1000 * holding.seconds();
  if (correction.frames > 0) {
    parts.fuse(anew, run.parts.read_again);
    anew.parts->settle();
    anew.parts->surface();
    {
      const std::lock_guard lock(run.mapper_mutex);
      holding = Stopwatch();
      parts.take_over(anew);
      correction.pause_ms += 1000 * holding.seconds();
    }
    anew.parts.reset();
    give_back_free_memory();
  }
  correction.ms = 1000 * stopwatch.seconds();
  run.counters.took("correct", stopwatch);
  run.counters.corrected(correction);
}

// Keyframes and loops need no map, so the mapper is not held for them.
void follow_loops(SharedRun& run, const Frame& frame) {
  run.parts.tracker->keep(frame);
  if (const std::vector<PoseUpdate> poses = run.parts.tracker->corrections(); !poses.empty()) correct(run, poses);
}

void fuse_geometry(SharedRun& run, const SharedFrame& arrived) {
  const Outcome outcome = add_geometry(run, arrived);
  if (!outcome.used) return run.counters.refused();
  run.counters.fused(arrived->read_at);
  if (run.parts.tracker != nullptr) follow_loops(run, *arrived->located);
}

void fuse_labels(SharedRun& run, const FusionJob& job) {
  const std::shared_ptr<const Frame> frame = located(run, job.arrived);
  if (frame == nullptr) return;
  {
    const std::lock_guard lock(run.mapper_mutex);
    Mapper& mapper = run.parts.mapper;
    if (!mapper.add_labels(*frame, *job.segmentation).used) return;
    if (run.parts.recorder != nullptr)
      run.parts.recorder->labelled(*frame, mapper.parts().pose_of(*frame), job.arrived->position);
    run.publisher.labelled({frame, job.segmentation, mapper.segment_ids()});
  }
  run.counters.labelled(job.arrived->read_at);
}

void fuse(SharedRun& run, const FusionJob& job) {
  if (job.arrived == nullptr) {
    correct(run, job.poses);
  } else if (job.segmentation != nullptr) {
    fuse_labels(run, job);
  } else {
    fuse_geometry(run, job.arrived);
  }
}

Segmentation predict(SharedRun& run, const SharedFrame& arrived) {
  if (!run.halves) return run.parts.predictor->predict(arrived->frame);
  run.semantic_todo.push(arrived);
  run.parts.before_work("instance");
  const Stopwatch running;
  const std::vector<Instance> instances = run.halves->instances(arrived->frame.color);
  run.counters.took("instance", running);
  const std::optional<Image<ClassId>> semantic = run.semantic_done.pop();
  return semantic ? run.halves->join(*semantic, instances) : Segmentation();  // nothing: the run has failed
}

// Tile by tile: mapping pauses only while one is copied or written. A map that is being fused anew is regularized with it.
void regularize(SharedRun& run) {
  const std::unique_lock regularizing(run.regularizing, std::try_to_lock);
  if (!regularizing.owns_lock()) return;
  std::vector<std::vector<Slot>> tiles;
  {
    const std::lock_guard lock(run.mapper_mutex);
    tiles = run.parts.mapper.parts().choose_tiles();
  }
  for (const std::vector<Slot>& blocks : tiles) {
    if (!run.control.wait_until(Clock::now()) || run.is_correcting) return;
    TileGraph tile;
    {
      const std::lock_guard lock(run.mapper_mutex);
      tile = run.parts.mapper.parts().gather(blocks);
    }
    TileChanges changes = run.parts.mapper.parts().solve(tile);
    const std::lock_guard lock(run.mapper_mutex);
    run.parts.mapper.parts().write_back(std::move(changes));
  }
}

// Calls `work` every so many seconds, late rather than twice, until the stages are to end.
template <typename Work>
void now_and_then(SharedRun& run, float every_s, const char* stage, const Work& work) {
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(every_s));
  for (auto due = Clock::now() + period; run.control.wait_until(due); due = std::max(due + period, Clock::now())) {
    run.parts.before_work(stage);
    work();
  }
}

}  // namespace

void fuse_jobs(SharedRun& run) {
  while (const std::optional<FusionJob> job = run.jobs.pop()) {
    run.parts.before_work("fusion");
    fuse(run, *job);
  }
}

void predict_newest(SharedRun& run) {
  while (const std::optional<SharedFrame> arrived = run.newest.take()) {
    run.parts.before_work("networks");
    if (!check((*arrived)->frame).used) continue;
    const Stopwatch predicting;
    auto segmentation = std::make_shared<const Segmentation>(predict(run, *arrived));
    run.counters.took("predict", predicting);
    // One place is kept for labels, so that frames cannot crowd them out.
    if (segmentation->segment_at.empty()) continue;
    if (run.jobs.push({*arrived, std::move(segmentation)}, 1) == Pushed::kClosed) break;
  }
  run.semantic_todo.close();
}

void run_semantic_network(SharedRun& run) {
  while (const std::optional<SharedFrame> arrived = run.semantic_todo.pop()) {
    run.parts.before_work("semantic");
    const Stopwatch running;
    Image<ClassId> classes = run.halves->semantic((*arrived)->frame.color);
    run.counters.took("semantic", running);
    run.semantic_done.push(std::move(classes));
  }
}

void regularize_now_and_then(SharedRun& run) {
  now_and_then(run, run.options.regularize_every_s, "regularizer", [&] {
    const Stopwatch regularizing;
    regularize(run);
    run.counters.took("regularize beside", regularizing);
  });
}

void publish_now_and_then(SharedRun& run) {
  now_and_then(run, run.options.mesh_every_s, "mesher", [&] { publish(run, false); });
}

void publish(SharedRun& run, bool finished) {
  const Stopwatch publishing;
  RunState state = run.counters.run_state();
  state.frames_total = run.parts.total;
  state.finished = finished;
  state.stopped_by = run.control.stopped_by();
  std::vector<Clock::time_point> seen;
  MapCapture capture;
  {
    const std::lock_guard lock(run.mapper_mutex);
    capture = run.publisher.capture(run.parts.mapper, std::move(state));
    seen.swap(run.fused_unseen);
  }
  run.publisher.publish(std::move(capture));
  run.counters.took("publish", publishing);
  run.counters.visible(seen);
}

void record_dropped(SharedRun& run) {
  if (run.parts.recorder == nullptr) return;
  for (FrameRecord& record : run.dropped.take_all()) run.parts.recorder->not_given(std::move(record));
}

void fail(SharedRun& run, std::exception_ptr failure) {
  run.control.fail(std::move(failure));
  run.jobs.abandon();
  run.newest.abandon();
  run.semantic_todo.abandon();
  run.semantic_done.close();
}

}  // namespace panoptic
