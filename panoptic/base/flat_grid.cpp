// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/flat_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace panoptic {
namespace {

constexpr std::array<std::array<int, 2>, 4> kStepsInPlane = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

template <typename Visit>
void visit_beside(const FlatGrid& grid, std::size_t cell, const Visit& visit) {
  const int x = static_cast<int>(cell % static_cast<std::size_t>(grid.width));
  const int y = static_cast<int>(cell / static_cast<std::size_t>(grid.width));
  for (const auto& [dx, dy] : kStepsInPlane) {
    if (grid.holds(x + dx, y + dy)) visit(grid.number(x + dx, y + dy));
  }
}

// The cells that carry the same number as `start` and hang together with it.
std::vector<std::size_t> flood(const FlatGrid& grid, const CellParts& parts, std::size_t start, CellSet& seen) {
  std::vector<std::size_t> cells = {start};
  seen[start] = 1;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    visit_beside(grid, cells[i], [&](std::size_t next) {
      if (seen[next] != 0 || parts[next] != parts[start]) return;
      seen[next] = 1;
      cells.push_back(next);
    });
  }
  return cells;
}

std::vector<std::size_t> largest_piece(const FlatGrid& grid, const CellParts& parts, int part) {
  CellSet seen(grid.size(), 0);
  std::vector<std::size_t> largest;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    if (parts[cell] != part || seen[cell] != 0) continue;
    std::vector<std::size_t> piece = flood(grid, parts, cell, seen);
    if (piece.size() > largest.size()) largest = std::move(piece);
  }
  return largest;
}

// Squared distances, in cells, from a row's entries: the lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012).
void transform_line(std::vector<double>& line) {
  const int n = static_cast<int>(line.size());
  std::vector<int> at;
  std::vector<double> from;
  const auto meet = [&](int p, int q) {
    return (line[static_cast<std::size_t>(q)] + q * q - line[static_cast<std::size_t>(p)] - p * p) / (2.0 * (q - p));
  };
  for (int q = 0; q < n; ++q) {
    if (!std::isfinite(line[static_cast<std::size_t>(q)])) continue;
    while (!at.empty() && at.size() > 1 && meet(at.back(), q) <= from.back()) at.pop_back(), from.pop_back();
    from.push_back(at.empty() ? -std::numeric_limits<double>::infinity() : meet(at.back(), q));
    at.push_back(q);
  }
  if (at.empty()) return;
  std::vector<double> result(line.size());
  std::size_t k = 0;
  for (int q = 0; q < n; ++q) {
    while (k + 1 < at.size() && from[k + 1] < q) ++k;
    result[static_cast<std::size_t>(q)] = (q - at[k]) * (q - at[k]) + line[static_cast<std::size_t>(at[k])];
  }
  line = std::move(result);
}

}  // namespace

std::optional<std::size_t> FlatGrid::cell_at(const Vec2d& point) const {
  const Vec2d at = ((point - origin) / cell_m).array().floor();
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < width && at.y() < height)) return std::nullopt;
  return number(static_cast<int>(at.x()), static_cast<int>(at.y()));
}

Vec2d FlatGrid::middle(std::size_t cell) const {
  const auto columns = static_cast<std::size_t>(width);
  return origin + Vec2d(static_cast<double>(cell % columns) + 0.5, static_cast<double>(cell / columns) + 0.5) * cell_m;
}

FlatGrid grid_over(const Eigen::AlignedBox2d& area, double cell_m, int margin) {
  constexpr double kMostCells = 16e6;
  FlatGrid grid;
  const Vec2d size_m = area.isEmpty() ? Vec2d(Vec2d::Zero()) : Vec2d(area.sizes());
  grid.cell_m = std::max(cell_m, std::sqrt(size_m.prod() / kMostCells));
  grid.cell_m = std::max(grid.cell_m, size_m.maxCoeff() / 1e6);
  const Vec2d low = area.isEmpty() ? Vec2d(Vec2d::Zero()) : Vec2d(area.min());
  grid.origin = low - Vec2d::Constant(margin * grid.cell_m);
  grid.width = static_cast<int>(size_m.x() / grid.cell_m) + 1 + 2 * margin;
  grid.height = static_cast<int>(size_m.y() / grid.cell_m) + 1 + 2 * margin;
  return grid;
}

void add_polygon(const FlatGrid& grid, const Polygon& polygon, CellSet& set) {
  Eigen::AlignedBox2d around;
  for (const Vec2d& corner : polygon) around.extend(corner);
  if (around.isEmpty()) return;
  const auto clamped = [&](const Vec2d& point, int axis, int most) {
    return static_cast<int>(std::clamp(std::floor((point[axis] - grid.origin[axis]) / grid.cell_m), 0.0, most - 1.0));
  };
  for (int y = clamped(around.min(), 1, grid.height); y <= clamped(around.max(), 1, grid.height); ++y) {
    for (int x = clamped(around.min(), 0, grid.width); x <= clamped(around.max(), 0, grid.width); ++x) {
      const std::size_t cell = grid.number(x, y);
      if (contains(polygon, grid.middle(cell))) set[cell] = 1;
    }
  }
}

CellSet shrunk(const FlatGrid& grid, const CellSet& set, double radius_m) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<double> squared(grid.size());
  for (std::size_t cell = 0; cell < grid.size(); ++cell) squared[cell] = set[cell] != 0 ? kFar : 0;
  std::vector<double> line;
  for (int y = 0; y < grid.height; ++y) {
    const auto row = squared.begin() + static_cast<std::ptrdiff_t>(grid.number(0, y));
    line.assign(row, row + grid.width);
    transform_line(line);
    std::copy(line.begin(), line.end(), row);
  }
  line.resize(static_cast<std::size_t>(grid.height));
  for (int x = 0; x < grid.width; ++x) {
    for (int y = 0; y < grid.height; ++y) line[static_cast<std::size_t>(y)] = squared[grid.number(x, y)];
    transform_line(line);
    for (int y = 0; y < grid.height; ++y) squared[grid.number(x, y)] = line[static_cast<std::size_t>(y)];
  }
  const double far = radius_m / grid.cell_m;
  CellSet result(grid.size(), 0);
  for (std::size_t cell = 0; cell < grid.size(); ++cell) result[cell] = squared[cell] > far * far ? 1 : 0;
  return result;
}

CellParts connected_parts(const FlatGrid& grid, const CellSet& set) {
  CellParts in_set(set.begin(), set.end());
  CellParts parts(grid.size(), 0);
  CellSet seen(grid.size(), 0);
  int count = 0;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    if (set[cell] == 0 || seen[cell] != 0) continue;
    ++count;
    for (const std::size_t member : flood(grid, in_set, cell, seen)) parts[member] = count;
  }
  return parts;
}

void grow_within(const FlatGrid& grid, const CellSet& set, CellParts& parts) {
  std::vector<std::size_t> front;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    if (parts[cell] != 0) front.push_back(cell);
  }
  for (std::size_t i = 0; i < front.size(); ++i) {
    visit_beside(grid, front[i], [&](std::size_t next) {
      if (set[next] == 0 || parts[next] != 0) return;
      parts[next] = parts[front[i]];
      front.push_back(next);
    });
  }
}

Polygon outline(const FlatGrid& grid, const CellParts& parts, int part) {
  const std::vector<std::size_t> piece = largest_piece(grid, parts, part);
  if (piece.empty()) return {};
  CellSet in_piece(grid.size(), 0);
  for (const std::size_t cell : piece) in_piece[cell] = 1;
  const std::size_t start = *std::min_element(piece.begin(), piece.end());
  const auto is_in = [&](int x, int y) { return grid.holds(x, y) && in_piece[grid.number(x, y)] != 0; };
  // A walk along the cells' edges with the piece on the left, from the lower left corner of the lowest, leftmost cell.
  const std::array<int, 2> begin = {static_cast<int>(start % static_cast<std::size_t>(grid.width)),
                                    static_cast<int>(start / static_cast<std::size_t>(grid.width))};
  std::array<int, 2> at = begin;
  std::size_t heading = 0;
  Polygon corners;
  do {
    at = {at[0] + kStepsInPlane[heading][0], at[1] + kStepsInPlane[heading][1]};
    // The cells ahead of the corner, to the left and to the right of the heading.
    const auto& [dx, dy] = kStepsInPlane[heading];
    const int left_x = at[0] + (dx - dy - 1) / 2;
    const int left_y = at[1] + (dx + dy - 1) / 2;
    const int right_x = at[0] + (dx + dy - 1) / 2;
    const int right_y = at[1] + (dy - dx - 1) / 2;
    const std::size_t before = heading;
    if (!is_in(left_x, left_y)) {
      heading = (heading + 1) % 4;
    } else if (is_in(right_x, right_y)) {
      heading = (heading + 3) % 4;
    }
    if (heading != before) corners.push_back(grid.origin + Vec2d(at[0], at[1]) * grid.cell_m);
  } while (at != begin || heading != 0);
  return corners;
}

Polygon largest_outline(const FlatGrid& grid, const CellSet& set) {
  const CellParts parts = connected_parts(grid, set);
  Polygon largest;
  for (int part = 1; part <= *std::max_element(parts.begin(), parts.end()); ++part) {
    Polygon candidate = outline(grid, parts, part);
    if (signed_area(candidate) > signed_area(largest)) largest = std::move(candidate);
  }
  return largest;
}

}  // namespace panoptic
