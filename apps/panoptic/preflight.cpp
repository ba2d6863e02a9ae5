// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The check that comes before a run: a number that a user gave is checked before it is believed.
#include <fmt/format.h>

#include <cstdio>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/io/doctor.h"
#include "panoptic/io/recording_list.h"
#include "panoptic/parallel.h"
#include "panoptic/sim/open_again.h"
#include "panoptic/source.h"

namespace panoptic {
namespace {

void tell_notes(const RecordingNotes& notes) {
  for (const std::string& line : notes.assumed) fmt::print("assumed   {}\n", line);
  for (const std::string& line : notes.left_out) fmt::print("left out  {}\n", line);
  std::fflush(stdout);
}

void refuse(const std::string& recording, const Check& check) {
  throw Error(fmt::format("{}: {}: {}; --no-preflight takes it as it is", recording, check.evidence, check.remedy));
}

constexpr DoctorOptions kPreflightWithoutPoses{.frames = kPreflight.frames, .pairs = 0, .steps = 0};

// Leaves out what is about poses.
DoctorReport without_poses(DoctorReport report) {
  std::erase_if(report.checks,
                [](const Check& c) { return c.name == "rotations" || c.name == "poses" || c.name == "steps" || c.name == "up"; });
  return report;
}

// The recording with its own poses, to compare with those that are tracked; nullptr if it has none that can be read.
std::unique_ptr<Dataset> open_given(const Arguments& arguments) {
  try {
    return open_dataset(arguments.dataset, arguments.calibration, arguments.pair_tolerance_s);
  } catch (const NoPoses&) {
    return nullptr;
  } catch (const Error& e) {
    tell(fmt::format("note: the recording's own poses are not compared with: {}\n", e.what()));
    return nullptr;
  }
}

// The list of all visits, the earlier ones as they were mapped, the last one with or without its poses.
std::unique_ptr<Dataset> open_visits(const Arguments& arguments, bool with_poses) {
  const std::size_t visits = read_recording_list(arguments.dataset).size();
  return open_recording_list(arguments.dataset, {}, {}, [&, opened = std::size_t{0}](const ListedRecording& r) mutable {
    return open_again(r.recording, r.calibration, r.pair_tolerance_s, ++opened == visits ? !with_poses : r.tracked);
  });
}

void check_sample(const Arguments& arguments, const DoctorReport& report) {
  for (const Check& check : report.checks) {
    if (check.verdict == Verdict::kImpossible) refuse(arguments.dataset, check);
  }
  for (const Check& check : report.checks) {
    if (check.verdict != Verdict::kFailed) continue;
    tell(fmt::format("warning: {}: {}: {} (panoptic doctor {} looks closer)\n", check.name, check.evidence, check.remedy,
                     arguments.dataset));
  }
}

// A further visit, whose camera is to be found in the map of the earlier ones.
OpenedRecording open_visit_to_track(const Arguments& arguments) {
  const ListedRecording visit = read_recording_list(arguments.dataset).back();
  OpenedRecording opened{open_visits(arguments, false), nullptr, true, visit.recording.starts_with("sim:")};
  tell_notes(opened.dataset->notes());
  if (!arguments.no_preflight) check_sample(arguments, without_poses(diagnose(*opened.dataset, kPreflightWithoutPoses)));
  if (opened.frames_have_poses) return opened;
  Arguments alone = arguments;
  alone.dataset = visit.recording;
  alone.calibration = visit.calibration;
  alone.pair_tolerance_s = visit.pair_tolerance_s;
  if (open_given(alone)) opened.given = open_visits(arguments, true);
  return opened;
}

}  // namespace

std::unique_ptr<Dataset> open_checked(const Arguments& arguments) {
  auto dataset = open_dataset(arguments.dataset, arguments.calibration, arguments.pair_tolerance_s);
  tell_notes(dataset->notes());
  // The numbers of a simulated home are the simulator's own.
  if (arguments.no_preflight || arguments.dataset.starts_with("sim:")) return dataset;
  check_sample(arguments, diagnose(*dataset, kPreflight));
  return dataset;
}

OpenedRecording open_to_map(const Arguments& arguments) {
  if (arguments.track && !arguments.earlier_map.empty()) return open_visit_to_track(arguments);
  if (!arguments.track) {
    try {
      return {open_checked(arguments), nullptr, false, true};
    } catch (const NoPoses&) {
      if (arguments.resume || !arguments.pose_updates.empty()) throw;
    }
  }
  if (arguments.dataset.starts_with("sim:")) return {open_checked(arguments), nullptr, true, true};
  auto dataset = open_without_poses(arguments.dataset, arguments.calibration, arguments.pair_tolerance_s);
  if (!arguments.track) fmt::print("poses     none: the camera is tracked\n");
  tell_notes(dataset->notes());
  if (!arguments.no_preflight) check_sample(arguments, without_poses(diagnose(*dataset, kPreflightWithoutPoses)));
  return {std::move(dataset), open_given(arguments), true, false};
}

}  // namespace panoptic
