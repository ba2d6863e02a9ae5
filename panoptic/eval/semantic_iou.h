// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// ScanNet's semantic label benchmark in 3D: intersection over union per class, over the vertices of all scenes.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "panoptic/base/json_value.h"
#include "panoptic/evaluation.h"

namespace panoptic {

class SemanticIou {
 public:
  // Adds a scene, one label per vertex each. Truth outside the 20 classes is left out; a prediction outside them is a miss of
  // the true class. REQUIRES spans of equal size.
  void add(std::span<const ClassId> truth, std::span<const ClassId> prediction);

  SemanticScores scores() const;

  // The counts for another process, and their addition. Throws Error unless they are sound (saved_counts.cpp).
  Json saved() const;
  void add_saved(const JsonValue& saved);

 private:
  static constexpr std::size_t kColumns = kBenchmarkClassCount + 1;  // the last one: predicted outside the 20
  std::array<std::array<std::uint64_t, kColumns>, kBenchmarkClassCount> confusion_{};
};

}  // namespace panoptic
