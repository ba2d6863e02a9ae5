// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/visits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "apps/panoptic/commands.h"
#include "panoptic/base/files.h"
#include "panoptic/io/recording_list.h"
#include "panoptic/mapping/visits.h"
#include "panoptic/simulation.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

void require_single(const Arguments& arguments) {
  if (is_recording_list(arguments.dataset)) {
    throw UsageError(fmt::format("--in takes one further recording, and {} is a list; give them one by one", arguments.dataset));
  }
  if (arguments.predictions.empty() && !options_from(arguments).predictions.empty()) {
    throw UsageError("--in takes the predictions of the further recording from --predictions, not from the options");
  }
}

ListedRecording next_visit(const Arguments& arguments) {
  return {.name = arguments.dataset,
          .recording = absolute_recording(arguments.dataset),
          .calibration = absolute_recording(arguments.calibration),
          .pair_tolerance_s = arguments.pair_tolerance_s,
          .predictions = absolute_recording(arguments.predictions),
          .world_from_recording = Pose::Identity()};
}

bool has_no_poses(const Arguments& arguments) {
  if (arguments.dataset.starts_with("sim:")) return false;
  try {
    open_dataset(arguments.dataset, arguments.calibration, arguments.pair_tolerance_s);
  } catch (const NoPoses&) {
    return true;
  }
  return false;
}

}  // namespace

Arguments with_earlier_visits(const Arguments& arguments) {
  require_single(arguments);
  if (is_there(arguments.map) && is_there(arguments.earlier_map) && fs::equivalent(arguments.map, arguments.earlier_map)) {
    throw UsageError("--in and --map name one file; the saved map stays as it is, and --map names a new one");
  }
  if (is_there(arguments.map) && !arguments.resume) {
    throw Error(fmt::format("{} is there already: go on with it (--resume), choose another name or remove it", arguments.map));
  }
  const std::string list = arguments.map + ".visits.toml";
  if (arguments.resume && is_there(list) && read_recording_list(list).back().tracked) {
    throw Error(
        fmt::format("{}: a visit whose camera is tracked cannot be resumed, for the file does not hold the tracker's memory; "
                    "remove it and {}, and run without --resume",
                    arguments.map, list));
  }
  const bool is_found_out = !arguments.track && !arguments.resume && has_no_poses(arguments);
  const std::string text =
      "# The visits that a map was made of; the last one was added to " + absolute_recording(arguments.earlier_map) + "\n" +
      to_toml(with_next_visit(arguments.earlier_map, next_visit(arguments), arguments.track || is_found_out));
  const bool is_written = is_there(list);
  if (is_written && read_file(list) != text) {
    throw Error(
        fmt::format("{} is there and says that {} is of other visits: run with what it was made with, or choose another "
                    "name for the map",
                    list, arguments.map));
  }
  if (is_there(arguments.map) && !is_written) {
    throw Error(
        fmt::format("{} is gone, and with it which recordings {} is of; choose another name for the map", list, arguments.map));
  }
  if (!is_written) write_file(list, text);
  if (is_found_out) fmt::print("poses     none: the camera is looked for in {}\n", arguments.earlier_map);
  Arguments all = arguments;
  all.track = arguments.track || is_found_out;
  all.dataset = list;
  all.calibration.clear();
  all.pair_tolerance_s.reset();
  all.predictions.clear();
  return all;
}

std::optional<EarlierMap> earlier_map(const Arguments& arguments, const RunSummary& summary) {
  if (arguments.earlier_map.empty()) return std::nullopt;
  EarlierMap earlier{arguments.earlier_map, 0};
  for (std::size_t i = 0; i + 1 < summary.recordings.size(); ++i) earlier.positions += summary.recordings[i].frames;
  return earlier;
}

EarlierFrames earlier_frames(const Arguments& arguments, const RunSummary& summary, const Checkpoints* checkpoints) {
  EarlierFrames frames;
  const auto earlier = earlier_map(arguments, summary);
  if (!earlier) return frames;
  const std::vector<FrameRecord>& records = checkpoints->resumed_frames();
  for (std::size_t i = 0; i < std::min(earlier->positions, records.size()); ++i) {
    if (!records[i].unused_because.empty()) continue;
    ++frames.used;
    frames.labelled += records[i].labelled ? 1 : 0;
    frames.last_s = records[i].time_s;
  }
  return frames;
}

void tell_places(const Checkpoints& checkpoints, const Mapper& mapper, const Dataset& dataset, RunTracker& tracker) {
  const std::size_t places = remember_visits(mapper, checkpoints.resumed_frames(), dataset, tracker);
  fmt::print("places    {} keyframes of the earlier visits, at which the camera is looked for\n", places);
  std::fflush(stdout);
}

void tell_found(const std::string& map, const TrackingReport& tracking) {
  std::size_t lost = 0;
  for (const TrackingSpan& span : tracking.spans) {
    if (span.state != TrackingState::kLost) {
      fmt::print("found     in {} by frame {}, after {} frames that are not in the map\n", map, span.first_frame, lost);
      return;
    }
    lost += span.frames;
  }
}

Error never_found(const Arguments& arguments, const TrackingReport& tracking) {
  const std::string reason = tracking.spans.empty() ? "no frame could be read" : tracking.spans.front().reason;
  return Error(fmt::format(
      "{}: the camera of its last recording was not found in {}, {} frames are lost ({}), and {} holds the earlier map "
      "alone; begin where the earlier recordings looked",
      arguments.dataset, arguments.earlier_map, tracking.lost, reason, arguments.output));
}

void tell_changes(const std::string& map, const EarlierFrames& earlier) {
  constexpr double kMilli = 1000;
  if (earlier.used == 0) return;
  fmt::print("changes   panoptic query '{}' --changes-since {:.3f}\n", map, std::ceil(kMilli * earlier.last_s) / kMilli);
}

}  // namespace panoptic
