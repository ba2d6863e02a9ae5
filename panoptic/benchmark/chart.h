// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Charts for reports.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/image.h"

namespace panoptic {

enum class ChartKind : std::uint8_t { kBars, kLines };

struct Series {
  std::string name;
  std::vector<double> values;  // one per category; NaN = nothing to draw there
};

struct Chart {
  ChartKind kind = ChartKind::kBars;
  std::string title;
  std::string x_axis;
  std::string y_axis;
  std::vector<std::string> categories;  // along x, evenly spaced
  std::vector<Series> series;           // at most 8 colours, then they repeat
};

// The chart on white with axes from 0 to a round number above the largest value, and a legend. REQUIRES as many values in
// every series as there are categories.
Image<Rgb> draw(const Chart& chart);

}  // namespace panoptic
