// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/visits.h"

#include <fmt/format.h>

#include "apps/panoptic/commands.h"
#include "panoptic/base/files.h"
#include "panoptic/io/recording_list.h"

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

}  // namespace

Arguments with_earlier_visits(const Arguments& arguments) {
  require_single(arguments);
  const std::string list = arguments.map + ".visits.toml";
  const bool is_resumed = is_there(arguments.map);
  if (is_resumed && !arguments.resume) {
    throw Error(fmt::format("{} is there already: go on with it (--resume), choose another name or remove it", arguments.map));
  }
  if (is_resumed && !is_there(list)) {
    throw Error(
        fmt::format("{} is gone, and with it which recordings {} is of; choose another file for the map", list, arguments.map));
  }
  if (!is_resumed) {
    write_file(list, "# The visits that " + fs::path(arguments.map).filename().string() + " was made of.\n" +
                         to_toml(with_next_visit(arguments.earlier_map, next_visit(arguments))));
  }
  Arguments all = arguments;
  all.dataset = list;
  all.calibration.clear();
  all.pair_tolerance_s.reset();
  all.predictions.clear();
  return all;
}

}  // namespace panoptic
