// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/play_source.h"

#include <fmt/format.h>

#include <utility>

#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapping/rebuild_file.h"
#include "panoptic/planning/distance_picture.h"
#include "panoptic/planning/ground.h"
#include "panoptic/sim/open_again.h"

namespace panoptic {
namespace {

constexpr int kJpegQuality = 88;

Json rows_of(const Pose& pose) {
  Json rows = Json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) rows.push_back(pose.matrix()(row, column));
  }
  return rows;
}

std::optional<Vec3d> up_in(const SavedMap& saved) {
  if (note_or_empty(saved, run_note::kUp).empty()) return std::nullopt;
  return up_of(saved);
}

}  // namespace

PlaySource::PlaySource(std::string map_file, std::string why_not)
    : map_file_(std::move(map_file)), why_not_(std::move(why_not)) {}

PlaySource PlaySource::of_growing_map() {
  PlaySource source("", kNotWhileMapping);
  source.grows_ = true;
  return source;
}

template <typename T, typename Make>
const T& PlaySource::once(Once<T>& thing, const Make& make) {
  if (map_file_.empty()) throw Error(why_not_);
  if (thing.made) return *thing.made;
  if (!thing.why_not.empty()) throw Error(thing.why_not);
  try {
    return thing.made.emplace(make());
  } catch (const Error& e) {
    thing.why_not = e.what();
    throw;
  }
}

const ScenePlan& PlaySource::plan() {
  return once(plan_, [&] {
    const SavedMap saved = load_map(map_file_);
    return scene_plan(saved.map, {}, up_in(saved));
  });
}

const PlaySource::Distances& PlaySource::measured() {
  return once(distances_, [&] {
    const SavedMap saved = load_map(map_file_);
    DistanceField field(up_frame(saved.map, up_in(saved)), {.cell_m = plan_cell_m(saved.map.voxels)});
    field.update(saved.map);
    DistanceField::Values values = field.values();
    if (values.distance_m.empty()) throw Error("distances: this map has no surface");
    return Distances{std::move(values), Pose(field.grid_from_world().inverse()), field.cell_m(), field.cap_m()};
  });
}

std::string PlaySource::distances() {
  const Distances& d = measured();
  const Vec3d low = d.values.origin_m - Vec3d::Constant(d.cell_m / 2);
  const Vec3d high = low + d.values.size.cast<double>() * d.cell_m;
  Json heights = Json::array();
  for (int level = 0; level < d.values.size.z(); ++level) heights.push_back(d.values.origin_m.z() + level * d.cell_m);
  return Json{{"world_from_grid", rows_of(d.world_from_grid)},
              {"low_m", {low.x(), low.y()}},
              {"high_m", {high.x(), high.y()}},
              {"heights_m", std::move(heights)},
              {"cap_m", d.cap_m},
              {"line_m", kSliceLine_m}}
      .dump();
}

std::string PlaySource::slice(std::size_t place) {
  const Distances& d = measured();
  if (place >= static_cast<std::size_t>(d.values.size.z())) {
    throw Error(fmt::format("there is no slice {}: the distances have {}", place, d.values.size.z()));
  }
  const std::vector<std::uint8_t> bytes = distance_slice_png(d.values, d.cap_m, static_cast<int>(place));
  return {bytes.begin(), bytes.end()};
}

PlaySource::Recording PlaySource::opened(const std::string& map_file) {
  const MappedRecording mapped = mapped_recording(map_file);
  auto dataset = open_again(mapped.recording, mapped.calibration, mapped.pair_tolerance_s, mapped.is_tracked);
  FrameFinder finder(*dataset);
  Recording found{std::move(dataset), std::move(finder), {}};
  const std::vector<FrameRecord> records = load_frames(map_file);
  found.finder.note(records, mapped.range);
  for (const FrameRecord& frame : records) {
    if (frame.unused_because.empty() && frame.world_from_camera.has_value()) found.frames.push_back(frame);
  }
  if (found.frames.empty()) throw Error("the map names no frame of its recording");
  return found;
}

const PlaySource::Recording& PlaySource::recording() {
  return once(recording_, [&] {
    try {
      return opened(map_file_);
    } catch (const Error& e) {
      throw Error(fmt::format("the camera view needs the recording of the map: {}", e.what()));
    }
  });
}

std::string PlaySource::frames() {
  Json numbers = Json::array();
  for (const FrameRecord& frame : recording().frames) numbers.push_back(frame.frame);
  return Json{{"frames", std::move(numbers)}}.dump();
}

const Frame& PlaySource::read(std::size_t place) {
  const Recording& from = recording();
  if (place >= from.frames.size()) {
    throw Error(fmt::format("there is no frame {}: the map was made of {}", place, from.frames.size()));
  }
  if (read_place_ == place) return frame_;
  const FrameRecord& record = from.frames[place];
  ReadResult result = from.finder.read(record.frame);
  if (!result.frame) throw Error(fmt::format("frame {} cannot be shown: {}", record.frame, result.skipped.reason));
  frame_ = kept(std::move(*result.frame));
  read_place_ = place;
  return frame_;
}

std::string PlaySource::frame(std::size_t place) {
  const Frame& frame = read(place);
  const FrameRecord& record = recording_.made->frames[place];
  const Camera& c = frame.color_camera;
  const Pose world_from_color = *record.world_from_camera * frame.color_from_depth.inverse();
  return Json{{"frame", record.frame},
              {"world_from_camera", rows_of(world_from_color)},
              {"camera", {{"width", c.width}, {"height", c.height}, {"fx", c.fx}, {"fy", c.fy}, {"cx", c.cx}, {"cy", c.cy}}}}
      .dump();
}

std::string PlaySource::picture(std::size_t place) {
  const std::vector<std::uint8_t> bytes = encode_jpeg(read(place).color, kJpegQuality);
  return {bytes.begin(), bytes.end()};
}

}  // namespace panoptic
