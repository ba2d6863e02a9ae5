// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/visits.h"

#include <fmt/format.h>

#include <algorithm>

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
                      .tracked = mapped.is_tracked,
                      .world_from_recording = Pose::Identity()});
  }
  next.tracked = is_tracked;
  visits.push_back(std::move(next));
  return visits;
}

std::size_t remember_visits(const Mapper& mapper, const std::vector<FrameRecord>& records, const Dataset& dataset,
                            RunTracker& tracker) {
  const std::vector<FrameLog::Entry>& log = mapper.parts().log().entries();
  const auto used = static_cast<std::size_t>(
      std::count_if(records.begin(), records.end(), [](const FrameRecord& r) { return r.unused_because.empty(); }));
  if (log.empty() || log.size() < used) {
    throw Error(
        fmt::format("the map has a log of {} of its {} frames (map.log, map.log_limit_mb); places are recognised by them and "
                    "corrected with them: map the earlier recordings anew",
                    log.size(), used));
  }
  std::vector<Pose> path;
  for (const FrameLog::Entry& entry : log) path.push_back(entry.world_from_camera);
  FrameFinder finder(dataset);
  finder.note(records, {});
  const std::vector<std::size_t> places = keyframes_along(path);
  for (const std::size_t i : places) {
    ReadResult read = finder.read(log[i].frame);
    if (read.frame) {
      read.frame->world_from_camera = path[i];
      if (Outcome outcome = check(*read.frame); !outcome.used) read = {std::nullopt, {log[i].frame, outcome.reason}};
    }
    if (!read.frame) {
      throw Error(fmt::format("frame {} of the earlier visits cannot be read again ({}): put their recordings back as they were",
                              log[i].frame, read.skipped.reason));
    }
    tracker.remember(*read.frame);
  }
  return places.size();
}

}  // namespace panoptic
