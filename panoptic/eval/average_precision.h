// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The area under ScanNet's precision-recall curve.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace panoptic {

// The findings of one class at one threshold over all scenes.
struct RankedMatches {
  std::vector<double> trues;   // confidence of every match
  std::vector<double> falses;  // confidence of every false prediction
  std::size_t missed = 0;      // true instances without a match
  bool has_truth = false;
  bool has_prediction = false;
};

// Precision and recall at every distinct confidence, lowest first, then the artificial point (1, 0); each precision weighs half
// the recall between its neighbours. Nothing without truth; 0 with truth and without predictions or anything to rank.
std::optional<double> average_precision(const RankedMatches& matches);

}  // namespace panoptic
