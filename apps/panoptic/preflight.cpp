// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The check that comes before a run: a number that a user gave is checked before it is believed.
#include <fmt/format.h>

#include <cstdio>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/io/doctor.h"
#include "panoptic/parallel.h"
#include "panoptic/simulation.h"

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

}  // namespace

std::unique_ptr<Dataset> open_checked(const Arguments& arguments) {
  auto dataset = open_dataset(arguments.dataset, arguments.calibration, arguments.pair_tolerance_s);
  tell_notes(dataset->notes());
  // The numbers of a simulated home are the simulator's own.
  if (arguments.no_preflight || arguments.dataset.starts_with("sim:")) return dataset;
  const DoctorReport report = diagnose(*dataset, kPreflight);
  for (const Check& check : report.checks) {
    if (check.verdict == Verdict::kImpossible) refuse(arguments.dataset, check);
  }
  for (const Check& check : report.checks) {
    if (check.verdict != Verdict::kFailed) continue;
    tell(fmt::format("warning: {}: {}: {} (panoptic doctor {} looks closer)\n", check.name, check.evidence, check.remedy,
                     arguments.dataset));
  }
  return dataset;
}

}  // namespace panoptic
