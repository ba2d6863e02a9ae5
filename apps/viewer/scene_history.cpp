// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/scene_history.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "panoptic/base/files.h"
#include "panoptic/base/json_value.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/objects/moving_tracks.h"

namespace panoptic {
namespace {

constexpr double kLongest_s = 1e12;
constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMostId = std::numeric_limits<std::uint32_t>::max();
constexpr std::uintmax_t kMostTrackBytes = std::uintmax_t{256} << 20;  // MovingTracks::kMostBoxes and some

// Takes the times that are known of, one by one.
class TimeRange {
 public:
  void take(double time_s) {
    first_s_ = std::min(first_s_, time_s);
    last_s_ = std::max(last_s_, time_s);
  }
  void put_into(SceneHistory& history) const {
    if (first_s_ > last_s_) return;
    history.start_s = first_s_;
    history.end_s = last_s_;
  }

 private:
  double first_s_ = std::numeric_limits<double>::infinity();
  double last_s_ = -std::numeric_limits<double>::infinity();
};

void take_times(const SceneHistory& history, TimeRange& range) {
  for (const ObjectSpan& span : history.spans) {
    range.take(span.first_s);
    if (span.gone_s) range.take(*span.gone_s);
  }
  for (const MovingTrack& track : history.tracks) {
    range.take(track.boxes.front().time_s);
    range.take(track.boxes.back().time_s);
  }
}

double time_in(const JsonValue& value) { return value.number(-kLongest_s, kLongest_s); }

// kUnknown for null, and where there is none.
PanopticId id_in(const JsonValue& entry, std::string_view key) {
  const auto value = entry.find(key);
  return !value || value->is_null() ? PanopticId::kUnknown : static_cast<PanopticId>(value->integer(0, kMostId));
}

// Nothing in the file of an early version.
std::optional<ObjectSpan> span_in(const JsonValue& entry) {
  const auto first = entry.find("first_time");
  if (!first) return std::nullopt;
  ObjectSpan span{.id = id_in(entry, "id"), .first_s = time_in(*first), .gone_s = {}};
  span.class_id = static_cast<ClassId>(entry.at("class_id").integer(0, std::numeric_limits<std::uint16_t>::max()));
  span.box.min_m = entry.at("box").at("min_m").point();
  span.box.max_m = entry.at("box").at("max_m").point();
  span.box.center_m = (span.box.min_m + span.box.max_m) / 2;
  if (const JsonValue gone = entry.at("gone_time"); !gone.is_null()) span.gone_s = time_in(gone);
  span.appeared = entry.at("appeared").boolean();
  span.moved_from = id_in(entry, "moved_from");
  span.moved_to = id_in(entry, "moved_to");
  return span;
}

MovingTrack track_in(const JsonValue& entry, const LabelSet& labels) {
  MovingTrack track;
  track.id = static_cast<std::uint32_t>(entry.at("id").integer(0, kMostId));
  if (const JsonValue name = entry.at("class"); !name.is_null()) {
    const LabelClass* label = labels.find(name.text());
    if (label == nullptr) name.wrong("a class of report.json");
    track.class_id = label->id;
  }
  for (const JsonValue& frame : entry.at("frames").elements()) {
    const JsonValue box = frame.at("box");
    TrackedBox& tracked = track.boxes.emplace_back();
    tracked.frame = frame.at("frame").integer(std::numeric_limits<std::int64_t>::min(), kMost);
    tracked.time_s = time_in(frame.at("time_s"));
    tracked.min_m = box.at("min_m").point();
    tracked.max_m = box.at("max_m").point();
    const std::size_t n = track.boxes.size();
    if (n > 1 && track.boxes[n - 2].time_s > tracked.time_s) frame.wrong("later than the one before it");
  }
  if (track.boxes.empty()) entry.at("frames").wrong("a frame and more");
  return track;
}

}  // namespace

bool SceneHistory::is_still() const {
  return tracks.empty() &&
         std::all_of(spans.begin(), spans.end(), [&](const ObjectSpan& span) { return span.first_s <= start_s && !span.gone_s; });
}

SceneHistory read_run_history(const std::filesystem::path& folder, const LabelSet& labels) {
  SceneHistory history;
  TimeRange range;
  const std::filesystem::path objects = folder / "objects.json";
  const Json json = read_json_file(objects);
  for (const JsonValue& entry : JsonValue(json, objects.string()).at("objects").elements()) {
    const auto span = span_in(entry);
    if (!span) continue;
    history.spans.push_back(*span);
    range.take(time_in(entry.at("last_time")));
  }
  std::ranges::sort(history.spans, {}, &ObjectSpan::id);
  const std::filesystem::path moving = folder / "moving.json";
  if (is_there(moving)) {
    const Json tracks = read_json_file(moving, kMostTrackBytes);
    const JsonValue file(tracks, moving.string());
    for (const JsonValue& entry : file.at("tracks").elements()) history.tracks.push_back(track_in(entry, labels));
    history.forgotten_boxes = static_cast<std::uint64_t>(file.at("forgotten_boxes").integer(0, kMost));
    std::ranges::sort(history.tracks, {}, &MovingTrack::id);
  }
  take_times(history, range);
  range.put_into(history);
  return history;
}

SceneHistory history_of(const SavedMap& saved, const std::vector<FrameRecord>& frames) {
  SceneHistory history;
  history.spans = object_spans(saved.map, frames);
  if (!saved.notes.states.empty()) {
    MovingState moving = saved_state(saved).moving;
    history.forgotten_boxes = moving.forgotten;
    history.tracks = MovingTracks(std::move(moving)).tracks();
  }
  TimeRange range;
  for (const FrameRecord& frame : frames) {
    if (frame.unused_because.empty()) range.take(frame.time_s);
  }
  take_times(history, range);
  range.put_into(history);
  return history;
}

}  // namespace panoptic
