// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/grid_filter.h"

#include <algorithm>
#include <cmath>

#include "panoptic/base/clones.h"
#include "panoptic/base/error.h"
#include "panoptic/fusion/lanes.h"

namespace panoptic {
namespace {

constexpr std::uint32_t kNone = GridFilter::kNone;

// The places where values are needed between a pass along `axis` and passes along the other two, in either order: those within
// reach of a point along the axis which are also within reach of a point along the others.
BitGrid places_along(const BitGrid& points, int axis, std::int32_t radius) {
  BitGrid along = points;
  along.dilate(axis, radius);
  BitGrid across = points;
  for (int other = 0; other < 3; ++other) {
    if (other != axis) across.dilate(other, radius);
  }
  along.intersect(across);
  return along;
}

}  // namespace

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

// Lines of one pass, the buffer that one of them is laid out in, and where the sums go.
struct LineWork {
  std::span<const GridFilter::Place> places;
  std::span<const std::uint32_t> line_ends;  // counted from the first of `places`
  std::span<const float> taps;
  ScaledRows in;
  float* line;  // room for the longest line with a radius at either end
  float* out;
};

void filter_lines_8(const LineWork& work);
void filter_lines_16(const LineWork& work);

// Values of a line without gaps, a radius of zeros at either end.
template <std::size_t Width>
[[gnu::always_inline]] inline void lay_out(std::span<const GridFilter::Place> places, const ScaledRows& in, float* to) {
  LaneRow<Width> row{};
  for (const GridFilter::Place place : places) {
    if (place.in == kNone) {
      row.clear();
    } else {
      row.load(in.row(place.in));
      if (in.scale != nullptr) row.scale(in.scale[place.in]);
    }
    row.store(to);
    to += Width;
  }
}

template <std::size_t Width>
[[gnu::always_inline]] inline void filter_lines(const LineWork& work) {
  const std::size_t radius = work.taps.size() - 1;
  const float* taps = work.taps.data();
  std::size_t first = 0;
  for (const std::uint32_t end : work.line_ends) {
    const auto places = work.places.subspan(first, end - first);
    lay_out<Width>(places, work.in, work.line + radius * Width);
    float* tail = work.line + (radius + places.size()) * Width;
    for (std::size_t c = 0; c < radius * Width; ++c) tail[c] = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (places[i].out == kNone) continue;
      const float* here = work.line + (radius + i) * Width;
      LaneRow<Width> sum{};
      sum.load(here);
      sum.scale(taps[0]);
      for (std::size_t k = 1; k <= radius; ++k) sum.add(taps[k], here - k * Width, here + k * Width);
      sum.store(work.out + places[i].out * Width);
    }
    first = end;
  }
}

PANOPTIC_CLONES void filter_lines_8(const LineWork& work) { filter_lines<8>(work); }
PANOPTIC_CLONES void filter_lines_16(const LineWork& work) { filter_lines<16>(work); }

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
  counts_[0] = grid.number_points();
  PANOPTIC_ASSERT(counts_[0] == points.size());
  // The axis that would need the most places between comes second: there it needs none of its own.
  BitGrid between[3] = {places_along(grid, 0, radius), places_along(grid, 1, radius), places_along(grid, 2, radius)};
  std::size_t counts[3];
  for (std::size_t a = 0; a < 3; ++a) counts[a] = between[a].number_points();
  const auto middle = static_cast<int>(std::max_element(counts, counts + 3) - counts);
  const int first = middle == 0 ? 1 : 0;
  const int last = 3 - middle - first;
  counts_[1] = counts[first];
  counts_[2] = counts[last];
  passes_[0] = make_pass(grid, between[first], first);
  passes_[1] = make_pass(between[first], between[last], middle);
  passes_[2] = make_pass(between[last], grid, last);
}

// Appends the line that runs through `p` along an axis.
void GridFilter::add_line(const BitGrid& in, const BitGrid& out, int axis, GridPoint p, Pass& pass) const {
  const auto radius = static_cast<std::int32_t>(taps_.size()) - 1;
  const GridPoint size = in.box().size;
  const std::int32_t length = axis == 0 ? size.x : axis == 1 ? size.y : size.z;
  std::int32_t& t = axis == 0 ? p.x : axis == 1 ? p.y : p.z;
  if (pass.pieces.empty() || pass.pieces.back().places.size() >= kPiecePlaces) pass.pieces.emplace_back();
  Piece& piece = pass.pieces.back();
  std::size_t first = piece.places.size();
  const auto end_line = [&] {
    piece.line_ends.push_back(static_cast<std::uint32_t>(piece.places.size()));
    pass.longest = std::max(pass.longest, piece.places.size() - first);
    first = piece.places.size();
  };
  std::int32_t last = -1;
  for (t = 0; t < length; ++t) {
    const bool enters = in.contains(p);
    const bool leaves = out.contains(p);
    if (!enters && !leaves) continue;
    if (last >= 0 && t - last > radius)
      end_line();
    else if (last >= 0)
      piece.places.insert(piece.places.end(), t - last - 1, Place{kNone, kNone});
    piece.places.push_back({enters ? in.rank(p) : kNone, leaves ? out.rank(p) : kNone});
    last = t;
  }
  if (last >= 0) end_line();
}

GridFilter::Pass GridFilter::make_pass(const BitGrid& in, const BitGrid& out, int axis) const {
  Pass pass;
  const GridPoint size = in.box().size;
  if (axis == 0) {
    for (std::int32_t z = 0; z < size.z; ++z) {
      for (std::int32_t y = 0; y < size.y; ++y) add_line(in, out, axis, {0, y, z}, pass);
    }
    return pass;
  }
  const std::int32_t slices = axis == 1 ? size.z : size.y;
  for (std::int32_t slice = 0; slice < slices; ++slice) {
    for (std::int32_t x = 0; x < size.x; ++x) {
      add_line(in, out, axis, axis == 1 ? GridPoint{x, 0, slice} : GridPoint{x, slice, 0}, pass);
    }
  }
  return pass;
}

void GridFilter::run(const Pass& pass, const ScaledRows& in, float* out, RowWidth row_width, const Ranges& ranges) const {
  const std::size_t room = (pass.longest + 2 * taps_.size()) * static_cast<std::size_t>(row_width);
  const auto filter_lines = row_width == RowWidth::k8 ? kernels::filter_lines_8 : kernels::filter_lines_16;
  ranges.run(pass.pieces.size(), 1, [&](std::size_t begin, std::size_t) {
    const Piece& piece = pass.pieces[begin];
    std::vector<float> line(room, 0.0F);
    filter_lines({piece.places, piece.line_ends, taps_, in, line.data(), out});
  });
}

void GridFilter::apply(const ScaledRows& in, float* out, RowWidth row_width, GridScratch& scratch, const Ranges& ranges) const {
  const auto width = static_cast<std::size_t>(row_width);
  // They only grow: narrower rows leave the rest unused, wider ones later need not be cleared again.
  scratch.first.resize(std::max(scratch.first.size(), counts_[1] * width));
  scratch.second.resize(std::max(scratch.second.size(), counts_[2] * width));
  run(passes_[0], in, scratch.first.data(), row_width, ranges);
  run(passes_[1], {scratch.first.data(), width, nullptr}, scratch.second.data(), row_width, ranges);
  run(passes_[2], {scratch.second.data(), width, nullptr}, out, row_width, ranges);
}

std::size_t GridFilter::memory_bytes() const {
  std::size_t bytes = 0;
  for (const Pass& pass : passes_) {
    for (const Piece& piece : pass.pieces) {
      bytes += piece.places.capacity() * sizeof(Place) + piece.line_ends.capacity() * sizeof(piece.line_ends[0]);
    }
  }
  return bytes;
}

}  // namespace panoptic
