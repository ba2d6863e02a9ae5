// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/average_precision.h"

#include <algorithm>

namespace panoptic {

std::optional<double> average_precision(const RankedMatches& matches) {
  if (!matches.has_truth) return std::nullopt;
  if (!matches.has_prediction || (matches.trues.empty() && matches.falses.empty())) return 0;
  std::vector<double> trues = matches.trues;
  std::vector<double> falses = matches.falses;
  std::sort(trues.begin(), trues.end());
  std::sort(falses.begin(), falses.end());
  std::vector<double> scores = trues;
  scores.insert(scores.end(), falses.begin(), falses.end());
  std::sort(scores.begin(), scores.end());
  scores.erase(std::unique(scores.begin(), scores.end()), scores.end());

  const auto recallable = static_cast<double>(trues.size() + matches.missed);
  std::vector<double> precision;
  std::vector<double> recall;
  for (const double score : scores) {
    const auto tp = static_cast<double>(trues.end() - std::lower_bound(trues.begin(), trues.end(), score));
    const auto fp = static_cast<double>(falses.end() - std::lower_bound(falses.begin(), falses.end(), score));
    precision.push_back(tp / (tp + fp));
    recall.push_back(tp / recallable);
  }
  precision.push_back(1);
  recall.push_back(0);
  // The neighbours of the first point are itself and the second, of the last one the last but one and 0.
  double ap = 0;
  for (std::size_t k = 0; k < recall.size(); ++k) {
    const double before = recall[k == 0 ? 0 : k - 1];
    const double after = k + 1 < recall.size() ? recall[k + 1] : 0;
    ap += precision[k] * (before - after) / 2;
  }
  return ap;
}

}  // namespace panoptic
