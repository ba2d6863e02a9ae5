// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "panoptic/predict/model.h"

namespace panoptic {

// Which output of a network that detects is what.
struct MaskRcnnOutputs {
  std::size_t boxes = static_cast<std::size_t>(-1);
  std::size_t labels = static_cast<std::size_t>(-1);
  std::optional<std::size_t> scores;  // absent: the fifth number of a box
  std::size_t masks = static_cast<std::size_t>(-1);
  std::optional<std::size_t> distribution;  // of classes, with the background
};

struct MaskShape {
  int width = 0;
  int height = 0;
  int per_detection = 1;  // or one for each class
  bool in_boxes = false;  // else over the whole input
};

MaskShape mask_shape_of(const Tensor& masks, int detections, const InputFormat& input);

}  // namespace panoptic
