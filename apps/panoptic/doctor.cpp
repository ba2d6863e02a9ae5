// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/doctor.h"

#include <fmt/format.h>

#include "apps/panoptic/commands.h"
#include "panoptic/base/parallel.h"
#include "panoptic/io/dataset.h"

namespace panoptic {

int doctor(const Arguments& arguments) {
  set_thread_count(arguments.threads);
  const auto dataset = open_dataset(arguments.dataset, arguments.calibration);
  const DoctorReport report = diagnose(*dataset);
  fmt::print("{}\n{}", dataset->description(), to_text(report));
  return report.worst() == Verdict::kFailed ? kWorldIsWrong : kDone;
}

}  // namespace panoptic
