// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Sums over the points of a sparse voxel grid, weighted by a Gaussian of their distance: k2 of the paper (Eq. 16). Exact but for
// the truncation at 3.5 sigma along each axis, because a Gaussian is the product of three along the axes.
//
// Passing along x, then y, then z needs values between the points. Only those between points are kept: after x the places within
// reach of a point along x that a point can still be reached from along y and z, after y likewise.
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
  std::vector<float> after_x;
  std::vector<float> after_y;
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
  // Points after each pass; scratch takes a row for each of the first two.
  std::size_t count_after_x() const { return counts_[1]; }
  std::size_t count_after_y() const { return counts_[2]; }

  static constexpr float kTruncation = 3.5F;  // sigmas

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
  std::size_t counts_[3] = {};  // points, and after x and after y
};

}  // namespace panoptic
