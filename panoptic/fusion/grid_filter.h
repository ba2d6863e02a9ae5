// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Sums over the points of a sparse voxel grid, weighted by a Gaussian of their distance: k2 of the paper (Eq. 16). Exact but for
// the truncation at 4 sigma along each axis, because a Gaussian is the product of three along the axes.
//
// Passing along one axis after the other needs values between the points. Only those between points are kept, and the axis that
// would need the most of them is taken in the middle: for a wall that is about one place more per point.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/fusion/bit_grid.h"
#include "panoptic/fusion/ranges.h"

namespace panoptic {

// How many labels are worked together; the loops are compiled for these two.
enum class RowWidth : std::uint8_t { k8 = 8, k16 = 16 };

// What a filter reads: a row of values per voxel, rows `stride` apart, and a factor per voxel.
struct ScaledRows {
  const float* values;
  std::size_t stride;
  const float* scale;

  const float* row(std::size_t i) const { return values + i * stride; }
};

// Scratch of GridFilter::apply, kept between calls.
struct GridScratch {
  std::vector<float> first;  // after the first pass
  std::vector<float> second;
};

class GridFilter {
 public:
  // `points` in the order of (z, y, x), none twice; sigma in voxels.
  GridFilter(std::span<const GridPoint> points, float sigma);

  std::size_t size() const { return counts_[0]; }

  // Row i of `out`, which has `width` values, becomes the sum over j of exp(-|i - j|^2 / (2 sigma^2)) * scale[j] * row j of
  // `in`, j = i included.
  void apply(const ScaledRows& in, float* out, RowWidth width, GridScratch& scratch, const Ranges& ranges) const;

  std::size_t memory_bytes() const;
  // Places between the passes; scratch takes a row for each.
  std::size_t places_between() const { return counts_[1] + counts_[2]; }

  static constexpr float kTruncation = 4;  // sigmas

  // Places along one axis, line after line; a line ends where nothing is within reach.
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  struct Place {
    std::uint32_t in;   // the value that enters here, or kNone
    std::uint32_t out;  // the sum that leaves here, or kNone
  };

 private:
  static constexpr std::size_t kPiecePlaces = 16384;

  struct Piece {  // some lines that are worked together
    std::vector<Place> places;
    std::vector<std::uint32_t> line_ends;
  };
  struct Pass {
    std::vector<Piece> pieces;
    std::size_t longest = 0;  // of all lines
  };

  void add_line(const BitGrid& in, const BitGrid& out, int axis, GridPoint p, Pass& pass) const;
  Pass make_pass(const BitGrid& in, const BitGrid& out, int axis) const;
  void run(const Pass& pass, const ScaledRows& in, float* out, RowWidth width, const Ranges& ranges) const;

  std::vector<float> taps_;  // 0 .. radius
  Pass passes_[3];
  std::size_t counts_[3] = {};  // points, and places after the first and the second pass
};

}  // namespace panoptic
