// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "panoptic/predict/model.h"

namespace panoptic {

inline constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);  // in the roles of Mask R-CNN's outputs

// The masks of a network that detects.
struct MaskShape {
  int width = 0;
  int height = 0;
  int per_detection = 1;  // or one for each class
  bool in_boxes = false;  // else over the whole input
};

MaskShape mask_shape_of(const Tensor& masks, int detections, const InputFormat& input);

}  // namespace panoptic
