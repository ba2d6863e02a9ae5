// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/mapping_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/mapping/frame_finder.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/online_playback.h"
#include "panoptic/mapping/run_recorder.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

constexpr const char* kInterrupted = "interrupted";

// The part of the range that is not in the map yet.
FrameRange rest_of(FrameRange range, std::uint64_t done) {
  range.begin += done * range.step;
  return range;
}

Segmentation predict(const MappingRun& run, const Frame& frame) {
  if (run.predictor == nullptr || !check(frame).used) return {};
  const Stopwatch predicting;
  Segmentation segmentation = run.predictor->predict(frame);
  run.mapper.profile().add("predict", predicting.seconds());
  return segmentation;
}

using FollowPoses = std::function<void(std::span<const PoseUpdate>)>;

// Corrections of poses that come from outside, each at its moment.
class PoseCorrector {
 public:
  // `apply`: lets the map follow some.
  PoseCorrector(const MappingRun& run, FollowPoses apply) : left_(run.pose_updates), apply_(std::move(apply)) {
    if (run.checkpoints == nullptr) return;
    // A map that is gone on with followed the corrections up to there.
    for (const FrameRecord& record : run.checkpoints->resumed_frames()) pass(record.frame);
  }

  // The run has come to this frame, whether or not it could be used.
  void passed(std::int64_t frame) {
    while (!left_.empty() && left_.front().at_frame == frame) apply_next();
  }
  void apply_all() {
    while (!left_.empty()) apply_next();
  }

 private:
  void pass(std::int64_t frame) {
    while (!left_.empty() && left_.front().at_frame == frame) left_ = left_.subspan(1);
  }
  void apply_next() {
    const PoseUpdates& updates = left_.front();
    left_ = left_.subspan(1);
    apply_(updates.poses);
  }

  std::span<const PoseUpdates> left_;
  FollowPoses apply_;
};

// The frames that a map that is gone on with has already.
void note_earlier(const MappingRun& run, FrameFinder& finder) {
  if (run.checkpoints != nullptr) finder.note(run.checkpoints->resumed_frames(), run.range);
}

// The pose that the recording gives, if it gives one.
std::optional<Pose> given_pose(const Frame& frame, std::size_t position, const MappingRun& run) {
  if (run.given_poses == nullptr) return std::nullopt;
  return run.given_poses == &run.dataset ? std::optional(frame.world_from_camera) : run.given_poses->pose(position);
}

// False if the camera is lost: then the frame counts as skipped.
bool locate(Frame& frame, std::size_t position, const MappingRun& run, RunRecorder& recorder) {
  if (run.tracker == nullptr) return true;
  const Stopwatch tracking;
  const auto given = given_pose(frame, position, run);
  const Outcome located = run.tracker->locate(frame, run.mapper.map().voxels, given);
  run.mapper.profile().add("locate", tracking.seconds());
  if (located.used) return true;
  run.mapper.skip({frame.index, located.reason});
  recorder.not_given({.frame = frame.index, .time_s = frame.time_s, .unused_because = located.reason});
  return false;
}

void follow_loops(RunTracker& tracker, const FollowPoses& follow) {
  if (const std::vector<PoseUpdate> poses = tracker.corrections(); !poses.empty()) follow(poses);
}

// The mask of what moves, at the size of the depth image.
void write_moving_mask(const std::filesystem::path& folder, const Frame& frame, const MovingSight& moving) {
  Image<std::uint8_t> mask(frame.depth.width(), frame.depth.height());
  std::copy(moving.mask.begin(), moving.mask.end(), mask.data());
  write_file(folder / fmt::format("{:06}.png", frame.index), encode_png(mask));
}

void map_frame(Frame read, const MappingRun& run, RunRecorder& recorder, LoopPublisher* publisher) {
  const auto frame = std::make_shared<const Frame>(publisher != nullptr ? kept(std::move(read)) : std::move(read));
  const auto segmentation = std::make_shared<const Segmentation>(predict(run, *frame));
  const Outcome outcome = run.mapper.add(*frame, *segmentation);
  if (outcome.used && run.tracker != nullptr) run.tracker->keep(*frame);
  if (outcome.used && !run.moving_masks.empty()) write_moving_mask(run.moving_masks, *frame, run.mapper.parts().moving());
  recorder.frame(*frame, !segmentation->segment_at.empty(), outcome);
  if (outcome.used && publisher != nullptr) publisher->added(frame, segmentation);
}

// Returns why it ended before the range did; empty if it did not.
std::string map_frames(const MappingRun& run, RunRecorder& recorder, LoopPublisher* publisher,
                       std::vector<Correction>& corrections) {
  FrameFinder finder(run.dataset);
  note_earlier(run, finder);
  const ReadFrame read_again = [&](std::int64_t frame) { return finder.read(frame); };
  const FollowPoses follow = [&](std::span<const PoseUpdate> poses) {
    corrections.push_back(run.mapper.update_poses(poses, read_again));
  };
  PoseCorrector corrector(run, follow);
  std::size_t done = run.checkpoints != nullptr ? run.checkpoints->positions() : 0;
  FrameStream stream(run.dataset, rest_of(run.range, done));
  for (;; ++done) {
    if (publisher != nullptr) publisher->at(done);
    if (!run.go_on(done)) return kInterrupted;
    const Stopwatch waiting;
    std::optional<ReadResult> read = stream.next();
    if (!read) break;
    run.mapper.profile().add("read", waiting.seconds());
    const std::int64_t frame = read->frame ? read->frame->index : read->skipped.index;
    const std::size_t position = run.range.begin + done * run.range.step;
    if (read->frame && locate(*read->frame, position, run, recorder)) {
      map_frame(std::move(*read->frame), run, recorder, publisher);
    } else if (!read->frame) {
      run.mapper.skip(read->skipped);
      recorder.not_given({.frame = read->skipped.index, .unused_because = read->skipped.reason});
    }
    finder.note(frame, position);
    corrector.passed(frame);
    if (run.tracker != nullptr) follow_loops(*run.tracker, follow);
    recorder.save_if_due(run.mapper);
  }
  corrector.apply_all();
  return "";
}

// The end of the mapping. An interrupted map stays in its file as it was between two frames, because it can be resumed.
void finish(const MappingRun& run, bool complete) {
  if (run.checkpoints != nullptr && !complete) run.checkpoints->finish(run.mapper, false);
  run.mapper.finish();
  if (run.checkpoints != nullptr && complete) run.checkpoints->finish(run.mapper, true);
}

MappingResult result_of(const MappingRun& run, const RunRecorder& recorder) {
  MappingResult result;
  if (run.predictor != nullptr) result.without_prediction = run.mapper.frames().used() - run.mapper.labelled();
  result.first_used = recorder.first_used();
  result.last_used = recorder.last_used();
  if (run.tracker != nullptr) result.tracking = run.tracker->report();
  return result;
}

// A run from a recording that is played, with what is told of each frame before it is handed over.
class PlayedRun {
 public:
  explicit PlayedRun(const MappingRun& run) : run_(run), finder_(run.dataset) { note_earlier(run, finder_); }

  // From any thread.
  ReadResult read_again(std::int64_t frame) {
    const std::lock_guard lock(finding_);
    return finder_.read(frame);
  }
  // Hands each correction over behind the frame that it comes after.
  void play_to(OnlinePipeline& pipeline, double speed) {
    std::size_t seen = 0;
    const auto look = [&](std::size_t done) {
      seen = done;
      if (!run_.go_on(done)) pipeline.stop(kInterrupted);
    };
    PoseCorrector corrector(run_, [&](std::span<const PoseUpdate> poses) {
      look(seen);  // the queue may be full of corrections, which take long
      pipeline.update_poses({poses.begin(), poses.end()});
    });
    std::optional<std::int64_t> before;
    const auto comes = [&](const ReadResult& read, std::size_t position) {
      const std::int64_t frame = read.frame ? read.frame->index : read.skipped.index;
      note(read, frame, position);
      if (before) corrector.passed(*before);
      before = frame;
    };
    play(run_.dataset, {run_.range, speed}, pipeline, look, comes);
    corrector.apply_all();
  }
  const std::vector<FramePose>& given() const { return given_; }  // poses of the recording

 private:
  void note(const ReadResult& read, std::int64_t frame, std::size_t position) {
    const std::lock_guard lock(finding_);
    finder_.note(frame, position);
    if (!read.frame) return;
    if (const auto pose = given_pose(*read.frame, position, run_)) given_.push_back({frame, read.frame->time_s, *pose});
  }

  const MappingRun& run_;
  std::mutex finding_;  // a frame may be noted while another is read again
  FrameFinder finder_;
  std::vector<FramePose> given_;
};

// The text for a person of what the action throws; empty if it throws nothing.
std::string failure_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::bad_alloc&) {
    return kOutOfMemory;
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

}  // namespace

MappingResult map_offline(const MappingRun& run, LoopPublisher* publisher) {
  RunRecorder recorder(run.checkpoints);
  if (run.checkpoints != nullptr && run.checkpoints->was_complete()) return result_of(run, recorder);
  std::string stopped_by;
  std::vector<Correction> corrections;
  std::string failure = failure_of([&] {
    stopped_by = map_frames(run, recorder, publisher, corrections);
    finish(run, stopped_by.empty());
  });
  if (!failure.empty()) stopped_by = failure;
  if (publisher != nullptr) {
    const std::string unseen = failure_of([&] { publisher->finish(stopped_by); });
    if (failure.empty()) failure = unseen;
  }
  MappingResult result = result_of(run, recorder);
  result.stopped_by = std::move(stopped_by);
  result.failure = std::move(failure);
  result.corrections = std::move(corrections);
  return result;
}

MappingResult map_online(const MappingRun& run, double speed, const OnlineOptions& options, LatestSnapshot& latest) {
  RunRecorder recorder(run.checkpoints);
  PlayedRun played(run);
  OnlinePipeline::Parts parts{run.mapper, run.predictor, &latest, run.range.count(run.dataset.size())};
  parts.recorder = &recorder;
  parts.read_again = [&](std::int64_t frame) { return played.read_again(frame); };
  parts.tracker = run.tracker;
  OnlinePipeline pipeline(parts, options);
  std::string failure = failure_of([&] { played.play_to(pipeline, speed); });
  if (!failure.empty()) pipeline.stop(failure);
  const OnlineReport report = pipeline.finish();
  if (report.failure) failure = failure_of([&] { std::rethrow_exception(report.failure); });
  if (run.checkpoints != nullptr) {
    const bool complete = failure.empty() && report.stopped_by.empty();
    const std::string unsaved = failure_of([&] { run.checkpoints->finish(run.mapper, complete); });
    if (failure.empty()) failure = unsaved;
  }
  MappingResult result = result_of(run, recorder);
  result.stopped_by = failure.empty() ? report.stopped_by : failure;
  result.failure = std::move(failure);
  result.online = report;
  result.corrections = report.corrections;
  if (result.tracking) result.tracking->given = played.given();
  return result;
}

}  // namespace panoptic
