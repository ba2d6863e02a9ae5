// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "bindings/python/arrays.h"
#include "bindings/python/bind.h"
#include "panoptic/frame.h"

namespace panoptic::python {

// The arrays of a frame, as Python hands them over. None: not given.
struct FrameArrays {
  py::object depth;
  py::object color;
  py::object k;
  py::object pose;
  py::object color_k;
  py::object color_from_depth;
  py::object depth_scale;
  py::object index = py::none();
  py::object time_s = py::none();
  py::object depth_weight = py::none();

  bool any() const { return !depth.is_none() || !color.is_none() || !k.is_none() || !pose.is_none() || !depth_weight.is_none(); }
};

// A frame that reads the arrays where they lie.
struct LentFrame {
  explicit LentFrame(const FrameArrays& arrays);  // throws Error: one is missing, or none that can be used

  Lent lent;
  Frame frame;
};

}  // namespace panoptic::python
