// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/visits.h"

#include <fmt/format.h>

#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/image_names.h"
#include "panoptic/mapping/rebuild_file.h"

namespace panoptic {

std::vector<ListedRecording> with_next_visit(const std::filesystem::path& map, ListedRecording next) {
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

}  // namespace panoptic
