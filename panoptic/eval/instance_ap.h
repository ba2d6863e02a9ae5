// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// ScanNet's instance benchmark in 3D: average precision over the scenes, as its public evaluator counts it.
#pragma once

#include <cstddef>
#include <vector>

#include "panoptic/base/json_value.h"
#include "panoptic/evaluation.h"

namespace panoptic {

constexpr std::size_t kMinRegionVertices = 100;  // smaller instances count neither as truth nor as prediction

// Class-agnostic: truth is the instances of the 18 thing classes (wall and floor are not kept), predictions are all masks
// whatever their label.
class InstanceAp {
 public:
  // Adds a scene. An instance of the truth is all vertices that share class and instance number, number 0 included, if the
  // class is one of the 18 things; all else is void. Predictions of other classes or with less than 100 vertices are left out.
  // If several predictions cover one instance, the first is its match. REQUIRES mask vertices below the number of labels.
  void add(const VertexLabels& truth, const std::vector<InstanceMask>& predictions);

  InstanceScores scores() const;

  // The counts for another process, and their addition. Throws Error unless they are sound (saved_counts.cpp).
  Json saved() const;
  void add_saved(const JsonValue& saved);

  // One scene, prepared for counting.
  struct Overlap {
    std::size_t other = 0;  // index of the prediction or of the true instance
    std::size_t vertices = 0;
  };
  struct TrueInstance {
    std::size_t category = 0;
    std::size_t vertices = 0;
    std::vector<Overlap> predictions;  // of the same category, in their order
  };
  struct Prediction {
    std::size_t category = 0;
    std::size_t vertices = 0;
    std::size_t on_void = 0;
    double confidence = 0;
    std::vector<Overlap> truths;  // of the same category
  };
  struct Scene {
    std::vector<TrueInstance> truths;  // ascending by class and instance
    std::vector<Prediction> predictions;
  };

 private:
  std::vector<Scene> by_class_;
  std::vector<Scene> agnostic_;  // category 0 for everything
};

}  // namespace panoptic
