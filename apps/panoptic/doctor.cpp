// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "apps/panoptic/commands.h"
#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/simulation.h"

namespace panoptic {

int doctor(const Arguments& arguments) {
  set_thread_count(arguments.threads);
  const auto dataset = open_dataset(arguments.dataset, arguments.calibration);
  const DoctorReport report = diagnose(*dataset);
  fmt::print("{}\n{}", dataset->description(), to_text(report));
  const auto failed = std::count_if(report.checks.begin(), report.checks.end(),
                                    [](const Check& check) { return check.verdict == Verdict::kFailed; });
  if (failed == 0) return kDone;
  std::fflush(stdout);  // the checks stand above the line that counts them
  throw Error(fmt::format("{} {} failed", failed, failed == 1 ? "check" : "checks"));
}

}  // namespace panoptic
