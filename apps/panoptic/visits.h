// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `run --in`: a run that goes on from the saved map of earlier visits.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "apps/panoptic/arguments.h"
#include "panoptic/error.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/run_tracker.h"
#include "panoptic/run_outputs.h"
#include "panoptic/source.h"
#include "panoptic/tracked_run.h"

namespace panoptic {

// The arguments of a run of all visits, the earlier map's and the one that the arguments name, whose camera is tracked if it has
// no poses. Writes their list beside the map file. Throws Error.
Arguments with_earlier_visits(const Arguments& arguments);

// The map that the run begins with; nothing without --in.
std::optional<EarlierMap> earlier_map(const Arguments& arguments, const RunSummary& summary);

// The frames of the earlier visits that were used.
struct EarlierFrames {
  std::uint64_t used = 0;
  std::uint64_t labelled = 0;
  double last_s = 0;  // time of the last one
};
EarlierFrames earlier_frames(const Arguments& arguments, const RunSummary& summary, const Checkpoints* checkpoints);

// For runs that track the camera. The first makes the places of the earlier visits known to the tracker and tells how many; it
// throws Error as remember_visits does. The second tells when the camera was found there, the third is the complaint if it never
// was.
void tell_places(const Checkpoints& checkpoints, const Mapper& mapper, const Dataset& dataset, RunTracker& tracker);
void tell_found(const std::string& map, const TrackingReport& tracking);
Error never_found(const Arguments& arguments, const TrackingReport& tracking);

// Prints where to ask what has changed since then.
void tell_changes(const std::string& map, const EarlierFrames& earlier);

}  // namespace panoptic
