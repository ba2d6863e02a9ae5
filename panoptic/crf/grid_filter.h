// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Sums over the points of a sparse voxel grid, weighted by a Gaussian of their distance: k2 of the paper (Eq. 16). Exact but for
// the truncation at 4 sigma along each axis, because a Gaussian is the product of three along the axes.
//
// Passing along one axis after the other needs values between the points: 2 to 7 places per point of a slanted surface. Only
// those that lie between points are kept, and the axis that would need the most of them is taken in the middle, where it needs
// none of its own. The first two passes are done slice by slice, so that what lies between them never leaves the cache.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "panoptic/base/ranges.h"
#include "panoptic/crf/bit_grid.h"
#include "panoptic/crf/float_rows.h"

namespace panoptic {

// The number of labels that are worked together; the loops are compiled for these.
enum class RowWidth : std::uint8_t { k8 = 8, k16 = 16, k24 = 24, k32 = 32 };

// The input of a filter: a row of values per voxel, rows `stride` apart, and a factor per voxel.
struct ScaledRows {
  const float* values;
  std::size_t stride;
  const float* scale;

  const float* row(std::size_t i) const { return values + i * stride; }
};

// Rows in the order in which lines need them, and where on the line they lie.
struct LinePlace {
  std::uint32_t row;
  std::int32_t at;  // from the first value of the stretch
};

// Stretches of lines along one axis. A stretch is input values with gaps of at most two radii, and the output sums within a
// radius of them.
struct GridLines {
  struct Stretch {
    std::uint32_t ins_end;
    std::uint32_t outs_end;
  };
  std::vector<Stretch> stretches;
  std::vector<LinePlace> ins;
  std::vector<LinePlace> outs;
  std::size_t longest = 0;  // in places, from the first to the last value of a stretch

  std::size_t memory_bytes() const {
    return stretches.capacity() * sizeof(Stretch) + (ins.capacity() + outs.capacity()) * sizeof(LinePlace);
  }
};

// Lines of the last pass: the output is row k of some points.
struct LastLines {
  GridLines lines;
  std::vector<std::uint32_t> points;
};

// Scratch of GridFilter::apply, kept between calls.
struct GridScratch {
  FloatRows rows;  // before the last pass
};

class GridFilter {
 public:
  // `points` in the order of (z, y, x), none twice; sigma in voxels.
  GridFilter(std::span<const GridPoint> points, float sigma, const Ranges& ranges = {});

  std::size_t size() const { return size_; }
  // The distance along an axis up to which two points are in each other's sums.
  std::int32_t reach() const { return reach_; }

  // Takes some points and their sums, rows of `width` values one after the other, as soon as they are there. Called on any
  // thread.
  using Take = std::function<void(std::span<const std::uint32_t> points, const float* sums)>;

  // The sum of point i is that over j of exp(-|i - j|^2 / (2 sigma^2)) * scale[j] * row j of `in`, j = i included. When the first
  // ones are taken `in` has been read to its end: take may write there.
  void apply(const ScaledRows& in, RowWidth width, GridScratch& scratch, const Ranges& ranges, const Take& take) const;

  std::size_t memory_bytes() const;
  // Places between the passes.
  std::size_t places_between() const { return places_first_ + places_middle_; }

  static constexpr float kTruncation = 4;  // sigmas

 private:
  struct Slice {
    GridLines first;
    GridLines middle;
    std::size_t places = 0;  // between the two
  };

  std::size_t size_;
  std::int32_t reach_;
  std::vector<float> taps_;  // from some places beyond the radius on one side, where they are 0, to as many on the other
  std::vector<Slice> slices_;
  std::vector<LastLines> last_;
  std::size_t places_first_ = 0;
  std::size_t places_middle_ = 0;
};

}  // namespace panoptic
