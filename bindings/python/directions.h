// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include "bindings/python/arrays.h"

namespace panoptic::python {

// Three numbers that point somewhere, as a vector of unit length. Throws Error.
inline Vec3d direction_from(const py::handle& object, const char* what) {
  const Vec3d given = point_from(object, what);
  const double length = given.stableNorm();
  if (!(length > 1e-9 && length < 1e9)) throw Error(fmt::format("{} is {:g} long: it must be a direction", what, length));
  return given / length;
}

}  // namespace panoptic::python
