// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/table_tops.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "panoptic/base/flat_grid.h"

namespace panoptic {
namespace {

constexpr double kLevelNormal = 0.94;         // 20 degrees: things slide off what is steeper
constexpr double kSmallestTop_m2 = 0.05;      // a plate
constexpr double kSmallestRectangle_m = 0.1;  // a cup
constexpr std::size_t kMostRectangles = 5;
constexpr double kCutOutShare = 0.1;  // of the hull of a top without a corner cut out

// The plane: the highest level with at least half as much surface as the largest one. Shelves and struts are lower.
std::optional<double> top_height(const std::vector<LabelledPoint>& points, double voxel_m) {
  constexpr double kBin_m = 0.01;
  std::map<int, double> area_at;
  for (const LabelledPoint& p : points) {
    if (p.normal.z() >= kLevelNormal) area_at[static_cast<int>(std::floor(p.at.z() / kBin_m))] += p.area_m2;
  }
  const int reach = std::max(1, static_cast<int>(std::lround(voxel_m / 2 / kBin_m)));
  std::map<int, double> around;
  double most_m2 = 0;
  for (const auto& [bin, own] : area_at) {
    for (int b = bin - reach; b <= bin + reach; ++b) {
      if (const auto at = area_at.find(b); at != area_at.end()) around[bin] += at->second;
    }
    most_m2 = std::max(most_m2, around[bin]);
  }
  if (most_m2 < kSmallestTop_m2 / 2) return std::nullopt;
  auto top = around.rbegin();
  while (top->second < most_m2 / 2) ++top;
  // Downhill on the far side of the level: its middle is where most surface is.
  for (auto lower = top; lower != around.rend() && top->first - lower->first <= 2 * reach; ++lower) {
    if (lower->second > top->second) top = lower;
  }
  double sum = 0;
  double weight = 0;
  for (const LabelledPoint& p : points) {
    if (p.normal.z() < kLevelNormal || std::abs(p.at.z() - (top->first + 0.5) * kBin_m) > voxel_m) continue;
    sum += p.area_m2 * p.at.z();
    weight += p.area_m2;
  }
  return weight > 0 ? std::optional(sum / weight) : std::nullopt;
}

// The top's own surface. Its rim lies within a voxel of the plane, whatever the normals there: they turn at the edge.
std::vector<Vec2d> points_of_top(const std::vector<LabelledPoint>& points, double height_m, double voxel_m) {
  std::vector<Vec2d> top;
  for (const LabelledPoint& p : points) {
    if (std::abs(p.at.z() - height_m) <= voxel_m) top.emplace_back(p.at.head<2>());
  }
  return top;
}

// How much of the hull is no top: one sees through the plane there, from above it to below.
double empty_share(const Polygon& hull, double height_m, double voxel_m, const SeenEmpty& seen_empty) {
  Eigen::AlignedBox2d area;
  for (const Vec2d& corner : hull) area.extend(corner);
  const FlatGrid grid = grid_over(area, 2 * voxel_m, 0);
  CellSet inside(grid.size(), 0);
  add_polygon(grid, hull, inside);
  double cells = 0;
  double empty = 0;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    if (inside[cell] == 0) continue;
    const Vec2d at = grid.middle(cell);
    const bool is_empty = seen_empty({at.x(), at.y(), height_m + voxel_m}) &&
                          seen_empty({at.x(), at.y(), height_m - 2 * voxel_m}) && seen_empty({at.x(), at.y(), height_m});
    cells += 1;
    empty += is_empty ? 1 : 0;
  }
  return cells > 0 ? empty / cells : 0;
}

// The largest connected part of the cells around the points.
Polygon outline_of(const std::vector<Vec2d>& points, double voxel_m) {
  Eigen::AlignedBox2d area;
  for (const Vec2d& p : points) area.extend(p);
  const FlatGrid grid = grid_over(area, 1.5 * voxel_m, 2);
  CellSet cells(grid.size(), 0);
  for (const Vec2d& p : points) cells[grid.cell_at(p).value_or(0)] = 1;
  return simplified(largest_outline(grid, cells), 1.5 * voxel_m);
}

// Places on the top that other things stand on or hang over, up to the height of a bottle.
std::vector<Vec2d> taken_places(const LabelledSurface& surface, PanopticId table, const Polygon& polygon, double height_m) {
  constexpr double kBottle_m = 0.35;
  Eigen::AlignedBox2d area;
  for (const Vec2d& corner : polygon) area.extend(corner);
  std::vector<Vec2d> taken;
  for (const auto& [id, points] : surface.of_object) {
    if (id == table) continue;
    for (const LabelledPoint& p : points) {
      const Vec2d at = p.at.head<2>();
      if (p.at.z() > height_m + surface.voxel_m / 2 && p.at.z() < height_m + kBottle_m && area.contains(at)) taken.push_back(at);
    }
  }
  return taken;
}

std::vector<Vec3d> at_height(const Polygon& polygon, double height_m) {
  std::vector<Vec3d> raised;
  for (const Vec2d& corner : polygon) raised.emplace_back(corner.x(), corner.y(), height_m);
  return raised;
}

struct CellRectangle {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  int cells() const { return width * height; }
};

// The largest rectangle of cells that are all in the set, with sides of at least `least` cells: for each row the heights of the
// columns that end there, and for each column the widest stretch that is at least as high.
CellRectangle largest_rectangle(const FlatGrid& grid, const CellSet& set, int least) {
  std::vector<int> column(static_cast<std::size_t>(grid.width), 0);
  CellRectangle best;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      int& rows = column[static_cast<std::size_t>(x)];
      rows = set[grid.number(x, y)] != 0 ? rows + 1 : 0;
    }
    for (int x = 0; x < grid.width; ++x) {
      int rows = column[static_cast<std::size_t>(x)];
      for (int end = x; end < grid.width && rows >= least; ++end) {
        rows = std::min(rows, column[static_cast<std::size_t>(end)]);
        const CellRectangle found{x, y - rows + 1, end - x + 1, rows};
        if (rows >= least && found.width >= least && found.cells() > best.cells()) best = found;
      }
    }
  }
  return best;
}

}  // namespace

std::vector<Polygon> free_rectangles(const Polygon& polygon, const std::vector<Vec2d>& taken, double cell_m, double least_m) {
  const FlatBox box = smallest_box(convex_hull(polygon));
  if (box.size_m.x() <= 0) return {};
  const Vec2d across = quarter_turn(box.axis);
  const auto to_box = [&](const Vec2d& p) { return Vec2d(box.axis.dot(p - box.center), across.dot(p - box.center)); };
  const auto from_box = [&](const Vec2d& p) { return Vec2d(box.center + box.axis * p.x() + across * p.y()); };
  const FlatGrid grid = grid_over(Eigen::AlignedBox2d(-box.size_m / 2, box.size_m / 2), cell_m, 0);
  Polygon turned;
  for (const Vec2d& corner : polygon) turned.push_back(to_box(corner));
  CellSet open(grid.size(), 0);
  add_polygon(grid, turned, open);
  for (const Vec2d& place : taken) {
    if (const auto cell = grid.cell_at(to_box(place))) open[*cell] = 0;
  }
  std::vector<Polygon> rectangles;
  const int least = std::max(1, static_cast<int>(std::ceil(least_m / grid.cell_m)));
  while (rectangles.size() < kMostRectangles) {
    const CellRectangle r = largest_rectangle(grid, open, least);
    if (r.cells() == 0) break;
    const auto corner = [&](int x, int y) { return from_box(grid.origin + Vec2d(x, y) * grid.cell_m); };
    rectangles.push_back(
        {corner(r.x, r.y), corner(r.x + r.width, r.y), corner(r.x + r.width, r.y + r.height), corner(r.x, r.y + r.height)});
    for (int y = r.y; y < r.y + r.height; ++y) {
      for (int x = r.x; x < r.x + r.width; ++x) open[grid.number(x, y)] = 0;
    }
  }
  return rectangles;
}

std::vector<TableTop> find_table_tops(const LabelledSurface& surface, const LabelSet& labels, const SeenEmpty& seen_empty) {
  std::vector<TableTop> tops;
  for (const auto& [id, points] : surface.of_object) {
    if (!labels.is_support(surface.class_of.at(id))) continue;
    const auto height_m = top_height(points, surface.voxel_m);
    if (!height_m) continue;
    const std::vector<Vec2d> seen = points_of_top(points, *height_m, surface.voxel_m);
    const Polygon hull = simplified(convex_hull(seen), surface.voxel_m / 2);
    const bool is_convex = empty_share(hull, *height_m, surface.voxel_m, seen_empty) < kCutOutShare;
    const Polygon polygon = is_convex ? hull : outline_of(seen, surface.voxel_m);
    if (signed_area(polygon) < kSmallestTop_m2) continue;
    TableTop top;
    top.polygon = at_height(polygon, *height_m);
    const auto taken = taken_places(surface, id, polygon, *height_m);
    for (const Polygon& rectangle : free_rectangles(polygon, taken, surface.voxel_m, kSmallestRectangle_m)) {
      top.free_rectangles.push_back(at_height(rectangle, *height_m));
    }
    top.height_m = *height_m;
    top.area_m2 = signed_area(polygon);
    top.object = id;
    tops.push_back(std::move(top));
  }
  return tops;
}

}  // namespace panoptic
