// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <utility>
#include <vector>

#include "panoptic/base/version.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/run_outputs.h"

namespace panoptic {
namespace {

std::vector<FrameRecord> frames_of(const Mapper& mapper) {
  std::vector<FrameRecord> frames;
  for (const TimedPose& pose : mapper.frames().trajectory()) {
    const auto position = static_cast<std::int64_t>(frames.size());
    frames.push_back(
        {.position = position, .frame = pose.frame, .time_s = pose.time_s, .world_from_camera = pose.world_from_camera});
  }
  return frames;
}

}  // namespace

void save_map(const std::filesystem::path& path, const Mapper& mapper, const Options& options) {
  MapUpdate update = whole_map(mapper.map());
  update.frames = frames_of(mapper);
  update.log = log_since(mapper.parts().log(), 0);
  update.notes = notes_of(mapper.parts().state());
  update.notes.texts[run_note::kOptions] = options_text(options);
  update.notes.texts[run_note::kProgram] = fmt::format("panoptic {}", version());
  update.notes.texts[run_note::kUp] = up_text(mapper.up());
  update.notes.texts[run_note::kPositions] = std::to_string(update.frames.size());
  update.notes.texts[run_note::kComplete] = "1";
  save_map(path, MapHeader{options.map, mapper.map().labels}, update);
}

}  // namespace panoptic
