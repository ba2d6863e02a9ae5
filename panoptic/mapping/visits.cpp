// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/visits.h"

#include <fmt/format.h>

#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/image_names.h"
#include "panoptic/mapping/frame_finder.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/rebuild_file.h"

namespace panoptic {

std::vector<ListedRecording> with_next_visit(const std::filesystem::path& map, ListedRecording next, bool is_tracked) {
  const MappedRecording mapped = mapped_recording(map);
  if (!mapped.complete) {
    throw Error(fmt::format("{} was not mapped to the end of its recording: finish that run first", map.string()));
  }
  if (mapped.is_part) {
    throw Error(
        fmt::format("{} was made of a part of its recording, and the frames behind that part would come in between; "
                    "map the whole recording",
                    map.string()));
  }
  if (mapped.is_tracked && !is_tracked) {
    throw Error(
        fmt::format("{}: its camera was tracked, so it has a world of its own, and the poses of the recording are in another; "
                    "find the camera in it as well (--track)",
                    map.string()));
  }
  if (ending_of(mapped.recording) == ".toml" && !is_there(mapped.recording)) {
    throw Error(fmt::format("{} was made of the recordings that {} names, and that is gone; put it back", map.string(),
                            mapped.recording));
  }
  std::vector<ListedRecording> visits;
  if (is_recording_list(mapped.recording)) {
    visits = read_recording_list(mapped.recording);
  } else {
    visits.push_back({.name = mapped.recording,
                      .recording = mapped.recording,
                      .calibration = mapped.calibration,
                      .pair_tolerance_s = mapped.pair_tolerance_s,
                      .predictions = "",
                      .world_from_recording = Pose::Identity()});
  }
  visits.push_back(std::move(next));
  return visits;
}

RememberedPlaces remember_visits(const Mapper& mapper, const std::vector<FrameRecord>& records, const Dataset& dataset,
                                 RunTracker& tracker) {
  const std::vector<FrameLog::Entry>& log = mapper.parts().log().entries();
  if (log.empty()) {
    throw Error(
        "the map has no log of its frames (map.log), by which its places are recognised: map the earlier recordings anew");
  }
  std::vector<Pose> path;
  for (const FrameLog::Entry& entry : log) path.push_back(entry.world_from_camera);
  FrameFinder finder(dataset);
  finder.note(records, {});
  RememberedPlaces places;
  for (const std::size_t i : keyframes_along(path)) {
    ReadResult read = finder.read(log[i].frame);
    if (read.frame) {
      read.frame->world_from_camera = path[i];
      if (Outcome outcome = check(*read.frame); !outcome.used) read = {std::nullopt, {log[i].frame, outcome.reason}};
    }
    if (read.frame) {
      tracker.remember(*read.frame);
      ++places.frames;
    } else {
      if (places.unreadable++ == 0) places.reason = fmt::format("frame {}: {}", log[i].frame, read.skipped.reason);
    }
  }
  if (places.frames == 0) {
    throw Error(fmt::format("no frame of the earlier visits can be read again ({}): put their recordings back", places.reason));
  }
  return places;
}

}  // namespace panoptic
