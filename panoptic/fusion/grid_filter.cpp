// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/grid_filter.h"

#include <cmath>
#include <cstring>

#include "panoptic/base/clones.h"
#include "panoptic/base/error.h"

namespace panoptic {
namespace {

// One line laid out without gaps, a radius of zeros at either end.
template <int kWidth>
[[gnu::always_inline]] inline void convolve_place(const float* here, const float* taps, std::ptrdiff_t radius, float* out) {
  float sum[kWidth];
  for (int c = 0; c < kWidth; ++c) sum[c] = taps[0] * here[c];
  for (std::ptrdiff_t k = 1; k <= radius; ++k) {
    const float* before = here - k * kWidth;
    const float* after = here + k * kWidth;
    for (int c = 0; c < kWidth; ++c) sum[c] += taps[k] * (before[c] + after[c]);
  }
  for (int c = 0; c < kWidth; ++c) out[c] = sum[c];
}

}  // namespace

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

void convolve_8(const float* line, std::span<const std::uint32_t> outs, std::span<const float> taps, float* out);
void convolve_16(const float* line, std::span<const std::uint32_t> outs, std::span<const float> taps, float* out);

// `outs`: two numbers per sum, the place in the line and the row that it goes to.
PANOPTIC_CLONES
void convolve_8(const float* line, std::span<const std::uint32_t> outs, std::span<const float> taps, float* out) {
  const auto radius = static_cast<std::ptrdiff_t>(taps.size()) - 1;
  for (std::size_t i = 0; i < outs.size(); i += 2) {
    convolve_place<8>(line + std::size_t{outs[i]} * 8, taps.data(), radius, out + std::size_t{outs[i + 1]} * 8);
  }
}

PANOPTIC_CLONES
void convolve_16(const float* line, std::span<const std::uint32_t> outs, std::span<const float> taps, float* out) {
  const auto radius = static_cast<std::ptrdiff_t>(taps.size()) - 1;
  for (std::size_t i = 0; i < outs.size(); i += 2) {
    convolve_place<16>(line + std::size_t{outs[i]} * 16, taps.data(), radius, out + std::size_t{outs[i + 1]} * 16);
  }
}

}  // namespace kernels

GridFilter::GridFilter(std::span<const GridPoint> points, float sigma) {
  const auto radius = static_cast<std::int32_t>(std::ceil(kTruncation * sigma));
  for (std::int32_t k = 0; k <= radius; ++k) {
    const double share = static_cast<double>(k) / sigma;
    taps_.push_back(static_cast<float>(std::exp(-0.5 * share * share)));
  }
  const GridBox box = box_around(points);
  BitGrid grid(box);
  for (const GridPoint& p : points) grid.set({p.x - box.origin.x, p.y - box.origin.y, p.z - box.origin.z});
  BitGrid near_x = grid;
  near_x.dilate(0, radius);
  BitGrid near_z = grid;
  near_z.dilate(2, radius);
  BitGrid after_x = near_z;
  after_x.dilate(1, radius);
  after_x.intersect(near_x);
  BitGrid after_y = near_x;
  after_y.dilate(1, radius);
  after_y.intersect(near_z);
  counts_[0] = grid.number_points();
  counts_[1] = after_x.number_points();
  counts_[2] = after_y.number_points();
  PANOPTIC_ASSERT(counts_[0] == points.size());
  passes_[0] = make_pass(grid, after_x, 0);
  passes_[1] = make_pass(after_x, after_y, 1);
  passes_[2] = make_pass(after_y, grid, 2);
}

GridFilter::Pass GridFilter::make_pass(const BitGrid& in, const BitGrid& out, int axis) const {
  Pass pass;
  const GridPoint size = in.box().size;
  const auto radius = static_cast<std::int32_t>(taps_.size()) - 1;
  const std::int32_t length = axis == 0 ? size.x : axis == 1 ? size.y : size.z;
  const auto add_line = [&](GridPoint p) {
    std::int32_t& t = axis == 0 ? p.x : axis == 1 ? p.y : p.z;
    std::int32_t last = -1;
    for (t = 0; t < length; ++t) {
      const bool enters = in.contains(p);
      const bool leaves = out.contains(p);
      if (!enters && !leaves) continue;
      if (last >= 0 && t - last > radius) pass.line_ends.push_back(static_cast<std::uint32_t>(pass.places.size()));
      if (last >= 0 && t - last <= radius) pass.places.insert(pass.places.end(), t - last - 1, Place{kNone, kNone});
      pass.places.push_back({enters ? in.rank(p) : kNone, leaves ? out.rank(p) : kNone});
      last = t;
    }
    if (last >= 0) pass.line_ends.push_back(static_cast<std::uint32_t>(pass.places.size()));
  };
  const std::int32_t rows = axis == 2 ? size.y : size.z;  // lines lie in slices across another axis
  for (std::int32_t slice = 0; slice < rows; ++slice) {
    if (axis == 0) {
      for (std::int32_t y = 0; y < size.y; ++y) add_line({0, y, slice});
    } else {
      for (std::int32_t x = 0; x < size.x; ++x) add_line(axis == 1 ? GridPoint{x, 0, slice} : GridPoint{x, slice, 0});
    }
  }
  return pass;
}

void GridFilter::run(const Pass& pass, const ScaledRows& in, float* out, RowWidth row_width, const Ranges& ranges) const {
  const auto width = static_cast<std::size_t>(row_width);
  const std::size_t radius = taps_.size() - 1;
  ranges.run(pass.line_ends.size(), 256, [&](std::size_t begin, std::size_t end) {
    std::vector<float> line;
    std::vector<std::uint32_t> outs;
    std::size_t first = begin == 0 ? 0 : pass.line_ends[begin - 1];
    for (std::size_t l = begin; l < end; ++l) {
      const std::size_t length = pass.line_ends[l] - first;
      line.resize(std::max(line.size(), (length + 2 * radius) * width));
      outs.clear();
      std::memset(line.data(), 0, radius * width * sizeof(float));
      for (std::size_t i = 0; i < length; ++i) {
        const Place place = pass.places[first + i];
        float* to = line.data() + (radius + i) * width;
        if (place.in == kNone) {
          for (std::size_t c = 0; c < width; ++c) to[c] = 0;
        } else {
          const float factor = in.scale == nullptr ? 1.0F : in.scale[place.in];
          const float* from = in.row(place.in);
          for (std::size_t c = 0; c < width; ++c) to[c] = factor * from[c];
        }
        if (place.out == kNone) continue;
        outs.push_back(static_cast<std::uint32_t>(radius + i));
        outs.push_back(place.out);
      }
      std::memset(line.data() + (radius + length) * width, 0, radius * width * sizeof(float));
      (row_width == RowWidth::k8 ? kernels::convolve_8 : kernels::convolve_16)(line.data(), outs, taps_, out);
      first = pass.line_ends[l];
    }
  });
}

void GridFilter::apply(const ScaledRows& in, float* out, RowWidth row_width, GridScratch& scratch, const Ranges& ranges) const {
  const auto width = static_cast<std::size_t>(row_width);
  scratch.after_x.resize(counts_[1] * width);
  scratch.after_y.resize(counts_[2] * width);
  run(passes_[0], in, scratch.after_x.data(), row_width, ranges);
  run(passes_[1], {scratch.after_x.data(), width, nullptr}, scratch.after_y.data(), row_width, ranges);
  run(passes_[2], {scratch.after_y.data(), width, nullptr}, out, row_width, ranges);
}

std::size_t GridFilter::memory_bytes() const {
  std::size_t bytes = 0;
  for (const Pass& pass : passes_) {
    bytes += pass.places.capacity() * sizeof(Place) + pass.line_ends.capacity() * sizeof(pass.line_ends[0]);
  }
  return bytes;
}

}  // namespace panoptic
