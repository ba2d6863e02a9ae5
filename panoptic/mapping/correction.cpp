// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The map follows corrected poses: it is fused anew from the log. The new map grows beside the old one, which stays as it is if
// anything fails.
#include <fmt/format.h>

#include <algorithm>
#include <future>
#include <map>
#include <set>
#include <utility>

#include "panoptic/base/memory.h"
#include "panoptic/data/motion.h"
#include "panoptic/error.h"
#include "panoptic/fusion/reference_labels.h"
#include "panoptic/map/frame_images.h"
#include "panoptic/mapping/mapper_parts.h"

namespace panoptic {
namespace {

constexpr double kArm_m = 2;  // see map.pose_tolerance_m

// How far a point before the camera moves, or farther.
double shift_m(const Pose& before, const Pose& after) {
  const PoseDifference moved = difference(before, after);
  return moved.distance_m + kArm_m * moved.angle_rad;
}

// A registry without objects that goes on where another one is.
ObjectRegistry emptied(const ObjectRegistry& now) {
  RegistryState state;
  state.merged = now.merged();
  state.next_id = now.next_id();
  state.refused = now.refused();
  return {now.first_thing(), std::move(state)};
}

// Which objects of a log were seen side by side, and how often.
class SeenTogether {
 public:
  SeenTogether(const FrameLog& log, const ObjectRegistry& objects) {
    for (std::size_t n = 0; n < log.size(); ++n) {
      const auto labels = log.labels(n, LoggedPixels::kLeftOut);
      if (!labels) continue;
      std::set<PanopticId> seen;
      for (const PanopticId id : labels->ids) {
        if (number(id) >= objects.first_thing() && id != LoggedLabels::kNoPlace) seen.insert(objects.survivor(id));
      }
      for (const PanopticId a : seen) {
        for (const PanopticId b : seen) ++frames_[a][b];
      }
    }
  }

  // In more than that share of the frames of the one that was seen less.
  bool more_than(double share, PanopticId a, PanopticId b) const {
    const std::uint64_t together = count(a, b);
    return static_cast<double>(together) > share * static_cast<double>(std::min(count(a, a), count(b, b)));
  }
  void merge(PanopticId from, PanopticId into) {
    for (const auto& [other, frames] : frames_[from]) {
      frames_[into][other == from ? into : other] += frames;
      if (other != from) frames_[other][into] += frames;
    }
  }

 private:
  std::uint64_t count(PanopticId a, PanopticId b) const {
    const auto of = frames_.find(a);
    if (of == frames_.end()) return 0;
    const auto at = of->second.find(b);
    return at == of->second.end() ? 0 : at->second;
  }

  std::map<PanopticId, std::map<PanopticId, std::uint64_t>> frames_;
};

// Gives segments the objects that the log names, in place of Eq. 3-5. Where one comes up for the first time, Eq. 4 is asked once
// more: with wrong poses it may have been taken for a new one, and is an object that the map has. Such two were hardly ever seen
// side by side.
class LoggedAssociation {
 public:
  LoggedAssociation(const Options& options, const FrameLog& log, const PanopticMap& before)
      : before_(before.objects),
        together_(log, before.objects),
        apart_share_(double{options.objects.together_share}),
        tracker_(options.tracker, before.labels) {}

  void set_ids(std::vector<PanopticId> ids) { ids_ = std::move(ids); }

  Association associate(const FrameToLabel& to_label, PanopticMap& map) {
    const auto& [frame, segmentation, registered] = to_label;
    const std::vector<Segment>& segments = segmentation.segments;
    reference_labels(map.voxels, frame, registered, reference_);  // Eq. 2
    tracker_.compare(registered, segments.size(), reference_);
    std::vector<LabelSlot> slots;
    for (const PanopticId id : ids_) {
      slots.push_back(known_slot(id, map));
      if (slots.back() != LabelSlot::kNoVote) tracker_.take(slots.back());
    }
    for (const std::size_t s : tracker_.by_area()) {
      if (slots[s] == LabelSlot::kNoVote && ids_[s] != LoggedLabels::kNoPlace) slots[s] = first_seen(s, frame.index, map.objects);
      if (map.objects.find(slots[s]) != nullptr) map.objects.observe(slots[s], segments[s], frame.index);
    }
    const auto& labels = tracker_.label(registered, segments, slots, map.objects);
    return {labels, tracker_.segment_ids(), tracker_.segment_areas_px()};
  }

 private:
  // kNoVote: there was no place for it, or it was not seen before.
  static LabelSlot known_slot(PanopticId id, const PanopticMap& map) {
    if (number(id) < map.labels.first_thing()) return static_cast<LabelSlot>(number(id));
    const Object* object = id == LoggedLabels::kNoPlace ? nullptr : map.objects.find(map.objects.survivor(id));
    return object == nullptr ? LabelSlot::kNoVote : object->slot;
  }

  LabelSlot first_seen(std::size_t segment, std::int64_t frame, ObjectRegistry& objects) {
    const PanopticId id = objects.survivor(ids_[segment]);
    if (const Object* object = objects.find(id)) return object->slot;  // a larger segment of this frame is of it, too
    const LabelSlot match = tracker_.best_match(segment);
    const Object* known = objects.find(match);
    if (known != nullptr && !together_.more_than(apart_share_, id, known->id)) {
      tracker_.take(match);
      together_.merge(id, known->id);
      objects.merge_absent(id, match, frame);
      return match;
    }
    const Object* was = before_.find(id);
    return objects.recreate(id, frame, was == nullptr ? PartHistory() : was->parts).value_or(LabelSlot::kNoVote);
  }

  const ObjectRegistry& before_;
  SeenTogether together_;
  double apart_share_;
  LabelTracker tracker_;
  std::vector<PanopticId> ids_;
  std::vector<LabelSlot> reference_;
};

// The frame of an entry, but for its pose, number and time: its copy, if there is one.
ReadResult read_logged(const FrameLog::Entry& entry, const ReadFrame& read) {
  if (!entry.images && !read) return {std::nullopt, {entry.frame, "the log has no copy of it, and nothing reads the recording"}};
  if (!entry.images) return read(entry.frame);
  std::optional<Frame> frame = unpack_images(*entry.images->packed());
  if (!frame) return {std::nullopt, {entry.frame, "its images in the log are damaged"}};
  if (Outcome outcome = check(*frame); !outcome.used) return {std::nullopt, {entry.frame, outcome.reason}};
  return {std::move(frame), {}};
}

// The frames of a log, read one ahead.
class LoggedFrames {
 public:
  LoggedFrames(const FrameLog& log, const ReadFrame& read) : log_(log), read_(read) { begin(); }

  // The next one, with the pose and the time of the log. REQUIRES that there is one.
  Frame next() {
    const FrameLog::Entry& entry = log_.entries()[next_++];
    ReadResult result = ahead_.get();
    begin();
    if (!result.frame) throw Error(fmt::format("frame {} cannot be read again: {}", entry.frame, result.skipped.reason));
    result.frame->index = entry.frame;
    result.frame->time_s = entry.time_s;
    result.frame->world_from_camera = entry.world_from_camera;
    return std::move(*result.frame);
  }

 private:
  void begin() {
    if (next_ == log_.size()) return;
    ahead_ = std::async(std::launch::async, [this, n = next_] { return read_logged(log_.entries()[n], read_); });
  }

  const FrameLog& log_;
  const ReadFrame& read_;
  std::size_t next_ = 0;
  std::future<ReadResult> ahead_;
};

}  // namespace

// Throws Error: poses that are none, or a log that does not tell of every frame.
FrameLog MapperParts::corrected_log(std::span<const PoseUpdate> poses, Correction& correction) const {
  if (options_.map.log != "reference" && !keeps_copies()) {
    throw Error(fmt::format("the map cannot follow corrected poses: it was made with map.log = {}", options_.map.log));
  }
  if (log_.size() != frames_.used()) {
    throw Error(
        fmt::format("the map cannot follow corrected poses: its log tells of {} of the {} frames used; raise "
                    "map.log_limit_mb ({})",
                    log_.size(), frames_.used(), options_.map.log_limit_mb));
  }
  if (log_.has_doubles()) throw Error("the map cannot follow corrected poses: two of its frames have the same number");
  FrameLog log = log_;
  for (const PoseUpdate& update : poses) {
    if (!is_finite(update.world_from_camera) || !is_rigid(update.world_from_camera)) {
      throw Error(fmt::format("the corrected pose of frame {} is no rigid motion", update.frame));
    }
    const auto n = log.find(update.frame);
    if (!n && correction.unknown++ == 0) correction.first_unknown = update.frame;
    if (n) log.set_pose(*n, update.world_from_camera);
  }
  for (std::size_t n = 0; n < log.size(); ++n) {
    const Pose& before = log_.entries()[n].world_from_camera;
    const Pose& after = log.entries()[n].world_from_camera;
    if (before.matrix() == after.matrix()) continue;
    if (shift_m(before, after) > double{options_.map.pose_tolerance_m}) {
      ++correction.frames;
    } else {
      log.set_pose(n, before);
    }
  }
  return log;
}

MapAnew MapperParts::begin_anew(std::span<const PoseUpdate> poses) const {
  MapAnew anew;
  anew.log = corrected_log(poses, anew.correction);
  anew.correction.blocks = map_.voxels.block_count();
  anew.epoch = map_.voxels.epoch();
  return anew;
}

void MapperParts::fuse(MapAnew& anew, const ReadFrame& read) const {
  const FrameLog& log = anew.log;
  LoggedAssociation logged(options_, log, map_);
  const auto associate = [&](const FrameToLabel& to_label, PanopticMap& map) { return logged.associate(to_label, map); };
  anew.parts = std::make_unique<MapperParts>(options_, map_.labels, ReplacedStages{associate, {}});
  MapperParts& fresh = *anew.parts;
  fresh.tasks_.clear();
  fresh.log_ = FrameLog();
  fresh.map_.objects = emptied(map_.objects);
  fresh.map_.voxels.restore_epochs(anew.epoch, {});  // so that all of it has changed for whoever looks
  LoggedFrames frames(log, read);
  for (std::size_t n = 0; n < log.size(); ++n) {
    const Stopwatch waiting;
    const Frame frame = frames.next();
    anew.correction.wait_ms += 1000 * waiting.seconds();
    std::optional<LoggedLabels> labels = log.labels(n);
    if (labels) logged.set_ids(std::move(labels->ids));
    const Outcome outcome = labels ? fresh.add(frame, labels->segmentation) : fresh.add_geometry(frame);
    if (!outcome.used) throw Error(fmt::format("frame {} cannot be fused again: {}", frame.index, outcome.reason));
    if ((n + 1) % static_cast<std::size_t>(options_.objects.every_frames) == 0) fresh.find_gone();
  }
  fresh.replaced_ = {};
  anew.correction.blocks = fresh.map_.voxels.block_count();
  anew.correction.blocks_refused = anew.correction.blocks;
}

void MapperParts::take_over(MapAnew& anew) {
  MapperParts& fresh = *anew.parts;
  std::swap(map_, fresh.map_);
  std::swap(maintenance_, fresh.maintenance_);
  std::swap(regularizer_, fresh.regularizer_);
  std::swap(moving_tracks_, fresh.moving_tracks_);
  std::swap(presence_, fresh.presence_);
  std::swap(mesher_, fresh.mesher_);
  association_ = {};
  up_sum_ = fresh.up_sum_;
  log_ = std::move(anew.log);
  retrace();
  ++times_anew_;
}

// Poses of the log are exact, and as they are now.
void MapperParts::retrace() {
  std::vector<TimedPose> trajectory;
  for (const FrameLog::Entry& entry : log_.entries()) trajectory.push_back({entry.time_s, entry.world_from_camera, entry.frame});
  frames_.retrace(trajectory);
}

Correction MapperParts::fuse_anew(std::span<const PoseUpdate> poses, const ReadFrame& read) {
  const Stopwatch stopwatch;
  MapAnew anew = begin_anew(poses);
  if (anew.correction.frames == 0) return anew.correction;
  fuse(anew, read);
  take_over(anew);
  anew.parts.reset();
  give_back_free_memory();
  anew.correction.ms = 1000 * stopwatch.seconds();
  anew.correction.pause_ms = anew.correction.ms;
  return anew.correction;
}

void MapperParts::settle() {
  if (finished_) {
    finish();
  } else {
    timed("maintain", [&] { maintain(); });
    regularize();
  }
}

Correction MapperParts::update_poses(std::span<const PoseUpdate> poses, const ReadFrame& read) {
  const Stopwatch stopwatch;
  Correction correction = fuse_anew(poses, read);
  if (correction.frames > 0) settle();
  correction.ms = 1000 * stopwatch.seconds();
  correction.pause_ms = correction.ms;
  profile_.add("correct", stopwatch.seconds());
  return correction;
}

}  // namespace panoptic
