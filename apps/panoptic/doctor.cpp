// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/doctor.h"

#include <fmt/format.h>

#include <cstdio>

#include "apps/panoptic/commands.h"
#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/simulation.h"

namespace panoptic {

int doctor(const Arguments& arguments) {
  set_thread_count(arguments.threads);
  const auto dataset = open_dataset(arguments.dataset, arguments.calibration, arguments.pair_tolerance_s);
  const DoctorReport report = diagnose(*dataset);
  if (arguments.as_json) {
    Json json = {{"recording", arguments.dataset}, {"description", dataset->description()}};
    json.update(to_json(report));
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("{}\n{}", dataset->description(), to_text(report));
  }
  const std::size_t failed = report.count(Verdict::kFailed);
  if (failed == 0) return kDone;
  std::fflush(stdout);  // the checks stand above the line that counts them
  throw Error(fmt::format("{} {} failed", failed, failed == 1 ? "check" : "checks"));
}

}  // namespace panoptic
