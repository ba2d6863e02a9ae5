// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/evidence_sheet.h"
#include "panoptic/base/image_io.h"

namespace panoptic {

int explain(const Arguments& arguments) {
  const Evidence evidence = read_evidence(arguments.explained, PanopticId{arguments.object_id});
  fmt::print("{}", to_text(evidence));
  if (arguments.png.empty()) return kDone;
  std::fflush(stdout);  // the words stand, whatever becomes of the picture
  write_png(arguments.png, draw_evidence(arguments.explained, evidence));
  fmt::print("\nlook at   {}\n", arguments.png);
  return kDone;
}

}  // namespace panoptic
