// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// From a frame to what is in it: the other interface that users implement.
#pragma once

#include "panoptic/data/frame.h"
#include "panoptic/data/labels.h"
#include "panoptic/data/segmentation.h"

namespace panoptic {

class Predictor {
 public:
  Predictor() = default;
  Predictor(const Predictor&) = delete;
  Predictor& operator=(const Predictor&) = delete;
  virtual ~Predictor() = default;

  // The classes that segments refer to.
  virtual const LabelSet& labels() const = 0;

  // Panoptic labels at the size of the frame's colour image (Eq. 1), or an empty segmentation where this frame has none.
  // Not thread-safe: one call at a time. Throws Error if the engine or a file fails.
  virtual Segmentation predict(const Frame& frame) = 0;
};

}  // namespace panoptic
