// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/grid_lines.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "panoptic/error.h"

namespace panoptic {
namespace {

using Axes = std::array<int, 3>;

std::int32_t along(const GridPoint& p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }
GridPoint reordered(const GridPoint& p, const Axes& axes) { return {along(p, axes[0]), along(p, axes[1]), along(p, axes[2])}; }

BitGrid dilated(BitGrid grid, int axis, std::int32_t radius) {
  grid.dilate(axis, radius);
  return grid;
}

BitGrid common(BitGrid grid, const BitGrid& other) {
  grid.intersect(other);
  return grid;
}

// Between a pass along an axis and passes along the other two, in either order, values are needed within reach of a point along
// that axis where there is also a point within reach along the others.
struct Between {
  BitGrid x;
  BitGrid y;
  BitGrid z;
};

Between places_between(const BitGrid& points, std::int32_t radius) {
  const BitGrid x = dilated(points, 0, radius);
  const BitGrid y = dilated(points, 1, radius);
  const BitGrid z = dilated(points, 2, radius);
  return {common(x, dilated(z, 1, radius)), common(y, dilated(x, 2, radius)), common(z, dilated(x, 1, radius))};
}

// The axis that would need the most places comes second, the one that needs the fewest last: its places are all kept at once.
Axes order_of_axes(Between& between) {
  const std::array<std::size_t, 3> counts = {between.x.number_points(), between.y.number_points(), between.z.number_points()};
  Axes axes = {0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(),
                   [&](int a, int b) { return counts[static_cast<std::size_t>(a)] > counts[static_cast<std::size_t>(b)]; });
  std::swap(axes[0], axes[1]);
  return axes;
}

BitGrid grid_of(std::span<const GridPoint> points, const GridBox& box, const Axes& axes) {
  const GridPoint o = box.origin;
  BitGrid grid({reordered(o, axes), reordered(box.size, axes)});
  for (const GridPoint& p : points) grid.set(reordered({p.x - o.x, p.y - o.y, p.z - o.z}, axes));
  return grid;
}

void add_line(std::span<const LinePlace> ins, std::span<const LinePlace> outs, std::int32_t radius, GridLines& lines) {
  std::size_t out = 0;
  for (std::size_t first = 0; first < ins.size();) {
    std::size_t past = first + 1;
    while (past < ins.size() && ins[past].at - ins[past - 1].at <= 2 * radius) ++past;
    const std::int32_t start = ins[first].at;
    const std::int32_t end = ins[past - 1].at;
    for (; first < past; ++first) lines.ins.push_back({ins[first].row, ins[first].at - start});
    for (; out < outs.size() && outs[out].at <= end + radius; ++out) lines.outs.push_back({outs[out].row, outs[out].at - start});
    lines.stretches.push_back({static_cast<std::uint32_t>(lines.ins.size()), static_cast<std::uint32_t>(lines.outs.size())});
    lines.longest = std::max(lines.longest, static_cast<std::size_t>(end - start) + 1);
  }
  PANOPTIC_ASSERT(out == outs.size());
}

// The points of rows that lie above each other, sorted into columns.
class Columns {
 public:
  explicit Columns(std::int32_t count) : ends_(static_cast<std::size_t>(count) + 1, 0) {}

  // row_at(t) gives y and z of the row at place t of all columns; name(t, k) gives the row of values of the k-th point there.
  template <typename RowAt, typename Name>
  void sort(const BitGrid& grid, std::int32_t length, const RowAt& row_at, const Name& name) {
    for (std::int32_t t = 0; t < length; ++t) {
      const auto [y, z] = row_at(t);
      grid.for_each_in_row(y, z, [&](std::int32_t x) { ends_[static_cast<std::size_t>(x) + 1]++; });
    }
    std::partial_sum(ends_.begin(), ends_.end(), ends_.begin());
    places_.resize(ends_.back());
    for (std::int32_t t = 0; t < length; ++t) {
      const auto [y, z] = row_at(t);
      std::uint32_t k = 0;
      grid.for_each_in_row(y, z, [&](std::int32_t x) { places_[ends_[static_cast<std::size_t>(x)]++] = {name(t, k++), t}; });
    }
  }
  std::span<const LinePlace> column(std::size_t x) const {
    const std::size_t first = x == 0 ? 0 : ends_[x - 1];
    return {places_.data() + first, ends_[x] - first};
  }

 private:
  std::vector<std::uint32_t> ends_;  // by column, once sorted
  std::vector<LinePlace> places_;
};

// At z + y * size, the number of places in rows with a lower y, or the same y and a lower z.
std::vector<std::uint32_t> number_middle(const BitGrid& grid) {
  const GridPoint size = grid.box().size;
  std::vector<std::uint32_t> before;
  before.reserve(static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z));
  std::uint32_t count = 0;
  for (std::int32_t y = 0; y < size.y; ++y) {
    for (std::int32_t z = 0; z < size.z; ++z) {
      before.push_back(count);
      count += grid.count_row(y, z);
    }
  }
  return before;
}

void add_columns(const Columns& ins, const Columns& outs, std::int32_t count, std::int32_t radius, GridLines& lines) {
  for (std::size_t x = 0; x < static_cast<std::size_t>(count); ++x) add_line(ins.column(x), outs.column(x), radius, lines);
}

}  // namespace

GridPlaces find_places(std::span<const GridPoint> points, std::int32_t radius) {
  constexpr Axes kAsTheyAre = {0, 1, 2};
  const GridBox box = box_around(points);
  BitGrid grid = grid_of(points, box, kAsTheyAre);
  Between between = places_between(grid, radius);
  const Axes axes = order_of_axes(between);
  if (axes != kAsTheyAre) {
    grid = grid_of(points, box, axes);
    between = places_between(grid, radius);
    between.x.number_points();
    between.z.number_points();
  }
  const std::size_t count = grid.number_points();
  PANOPTIC_ASSERT(count == points.size());
  GridPlaces places{std::move(grid), std::move(between.x), std::move(between.z), std::vector<std::uint32_t>(count), {}};
  places.middle_rows = number_middle(places.after_middle);
  for (std::size_t i = 0; i < count; ++i) {
    const GridPoint& p = points[i];
    const GridPoint within{p.x - box.origin.x, p.y - box.origin.y, p.z - box.origin.z};
    places.voxel_of[places.points.rank(reordered(within, axes))] = static_cast<std::uint32_t>(i);
  }
  return places;
}

GridLines first_lines(const GridPlaces& places, std::int32_t z, std::int32_t radius) {
  GridLines lines;
  std::vector<LinePlace> ins;
  std::vector<LinePlace> outs;
  std::uint32_t out = 0;
  for (std::int32_t y = 0; y < places.points.box().size.y; ++y) {
    ins.clear();
    outs.clear();
    std::uint32_t in = places.points.rank({0, y, z});
    places.points.for_each_in_row(y, z, [&](std::int32_t x) { ins.push_back({places.voxel_of[in++], x}); });
    places.after_first.for_each_in_row(y, z, [&](std::int32_t x) { outs.push_back({out++, x}); });
    add_line(ins, outs, radius, lines);
  }
  return lines;
}

GridLines middle_lines(const GridPlaces& places, std::int32_t z, std::int32_t radius) {
  const GridPoint size = places.points.box().size;
  const auto row_at = [&](std::int32_t t) { return std::pair(t, z); };
  const std::uint32_t before = places.after_first.rank({0, 0, z});
  Columns ins(size.x);
  Columns outs(size.x);
  ins.sort(places.after_first, size.y, row_at, [&](std::int32_t y, std::uint32_t k) {
    return places.after_first.rank({0, y, z}) - before + k;
  });
  outs.sort(places.after_middle, size.y, row_at, [&](std::int32_t y, std::uint32_t k) { return places.middle_row(y, z) + k; });
  GridLines lines;
  add_columns(ins, outs, size.x, radius, lines);
  return lines;
}

LastLines last_lines(const GridPlaces& places, std::int32_t y, std::int32_t radius) {
  const GridPoint size = places.points.box().size;
  const auto row_at = [&](std::int32_t t) { return std::pair(y, t); };
  Columns ins(size.x);
  Columns outs(size.x);
  ins.sort(places.after_middle, size.z, row_at, [&](std::int32_t z, std::uint32_t k) { return places.middle_row(y, z) + k; });
  outs.sort(places.points, size.z, row_at, [&](std::int32_t z, std::uint32_t k) {
    return places.voxel_of[places.points.rank({0, y, z}) + k];
  });
  LastLines last;
  add_columns(ins, outs, size.x, radius, last.lines);
  for (LinePlace& out : last.lines.outs) {
    last.points.push_back(out.row);
    out.row = static_cast<std::uint32_t>(last.points.size() - 1);
  }
  return last;
}

}  // namespace panoptic
