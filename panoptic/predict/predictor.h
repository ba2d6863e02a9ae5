// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// From a frame to what is in it: the other interface that users implement.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "panoptic/data/frame.h"
#include "panoptic/data/labels.h"
#include "panoptic/data/segmentation.h"

namespace panoptic {

// A predictor taken apart, for running its networks side by side: the first two may be called at once, each by one thread at a
// time. join(semantic(color), instances(color)) is what predict gives for a frame with that colour image (Eq. 1). Good as long as
// the predictor lives.
struct PredictorHalves {
  std::function<Image<ClassId>(const Image<Rgb>& color)> semantic;
  std::function<std::vector<Instance>(const Image<Rgb>& color)> instances;
  std::function<Segmentation(const Image<ClassId>& semantic, const std::vector<Instance>& instances)> join;
};

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

  // Nothing where predict is one piece. While halves are at work, predict is not to be called.
  virtual std::optional<PredictorHalves> halves() { return std::nullopt; }
};

}  // namespace panoptic
