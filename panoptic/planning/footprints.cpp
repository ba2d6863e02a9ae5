// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/footprints.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>

#include "panoptic/base/flat_grid.h"

namespace panoptic {
namespace {

constexpr double kMostEmpty = 0.1;    // of a footprint: rounded corners and arms that stick out leave no more
constexpr double kLeastShare = 0.05;  // of the largest piece: less is wrongly labelled voxels

using Points = std::vector<const LabelledPoint*>;

// A thing from above, place by place of the floor.
struct ThingColumns {
  FlatGrid grid;
  CellSet surface;  // has some of the thing's own surface
  CellSet empty;    // has none, and at half of the heights from its lowest to its highest point or more, empty space was seen
};

double area_of(const Points& points) {
  double area_m2 = 0;
  for (const LabelledPoint* p : points) area_m2 += p->area_m2;
  return area_m2;
}

void set_heights(const Points& points, ThingFootprint& print) {
  print.low_m = points.front()->at.z();
  print.high_m = print.low_m;
  for (const LabelledPoint* p : points) {
    print.low_m = std::min(print.low_m, p->at.z());
    print.high_m = std::max(print.high_m, p->at.z());
  }
}

// The direction of a thing's upright faces, if most of them stand along two directions at a right angle, as those of a box do.
// Four times the angle is the same for all of them.
std::optional<Vec2d> box_direction(const Points& points) {
  constexpr double kMost = 0.5;
  std::complex<double> sum = 0;
  double total = 0;
  for (const LabelledPoint* p : points) {
    if (std::abs(p->normal.z()) > 0.5) continue;
    sum += p->area_m2 * std::polar(1.0, 4 * std::atan2(p->normal.y(), p->normal.x()));
    total += p->area_m2;
  }
  if (total <= 0 || std::abs(sum) < kMost * total) return std::nullopt;
  const double angle = std::arg(sum) / 4;
  return Vec2d(std::cos(angle), std::sin(angle));
}

Polygon box_along(const Polygon& hull, const Vec2d& axis) {
  Eigen::AlignedBox2d turned;
  for (const Vec2d& p : hull) turned.extend(Vec2d(axis.dot(p), quarter_turn(axis).dot(p)));
  const Vec2d center = axis * turned.center().x() + quarter_turn(axis) * turned.center().y();
  return corners({center, axis, turned.sizes()});
}

Polygon hull_of(const Points& points) {
  std::vector<Vec2d> from_above;
  for (const LabelledPoint* p : points) from_above.emplace_back(p->at.head<2>());
  return convex_hull(std::move(from_above));
}

FlatGrid grid_around(const Points& points, double voxel_m) {
  Eigen::AlignedBox2d area;
  for (const LabelledPoint* p : points) area.extend(p->at.head<2>());
  return grid_over(area, 2 * voxel_m, 2);
}

CellSet cells_with(const FlatGrid& grid, const Points& points) {
  CellSet cells(grid.size(), 0);
  for (const LabelledPoint* p : points) {
    if (const auto cell = grid.cell_at(p->at.head<2>())) cells[*cell] = 1;
  }
  return cells;
}

// The points by connected part of the cells that hold them, those with most surface first.
std::vector<Points> pieces_of(const Points& points, double voxel_m) {
  const FlatGrid grid = grid_around(points, voxel_m);
  const CellParts part_at = connected_parts(grid, cells_with(grid, points));
  std::vector<Points> pieces(static_cast<std::size_t>(*std::max_element(part_at.begin(), part_at.end())));
  for (const LabelledPoint* p : points) {
    pieces[static_cast<std::size_t>(part_at[grid.cell_at(p->at.head<2>()).value_or(0)] - 1)].push_back(p);
  }
  std::stable_sort(pieces.begin(), pieces.end(), [](const Points& a, const Points& b) { return area_of(a) > area_of(b); });
  return pieces;
}

// Looked up in the area of the hull alone: nothing outside it becomes part of a footprint but corners of a box.
ThingColumns columns_of(const Points& points, const Polygon& within, double voxel_m, const SeenEmpty& seen_empty) {
  ThingFootprint heights;
  set_heights(points, heights);
  ThingColumns columns;
  Eigen::AlignedBox2d area;
  for (const Vec2d& corner : within) area.extend(corner);
  columns.grid = grid_over(area, 2 * voxel_m, 2);
  columns.surface = cells_with(columns.grid, points);
  columns.empty.assign(columns.grid.size(), 0);
  CellSet inside(columns.grid.size(), 0);
  add_polygon(columns.grid, within, inside);
  for (std::size_t cell = 0; cell < columns.grid.size(); ++cell) {
    if (inside[cell] == 0 || columns.surface[cell] != 0) continue;
    const Vec2d at = columns.grid.middle(cell);
    int seen = 0;
    int all = 0;
    for (double z = heights.low_m + voxel_m; z <= heights.high_m; z += 4 * voxel_m) {
      all += 1;
      seen += seen_empty({at.x(), at.y(), z}) ? 1 : 0;
    }
    columns.empty[cell] = all > 0 && 2 * seen >= all ? 1 : 0;
  }
  return columns;
}

double empty_share(const ThingColumns& columns, const Polygon& polygon) {
  CellSet inside(columns.grid.size(), 0);
  add_polygon(columns.grid, polygon, inside);
  double cells = 0;
  double empty = 0;
  for (std::size_t cell = 0; cell < columns.grid.size(); ++cell) {
    cells += inside[cell];
    empty += inside[cell] != 0 ? columns.empty[cell] : 0;
  }
  return cells > 0 ? empty / cells : 0;
}

// A box along the upright faces, else the hull, else nothing: what is seen to be empty is no furniture.
std::optional<Polygon> filled_shape(const Points& points, double voxel_m, const SeenEmpty& seen_empty) {
  const Polygon hull = hull_of(points);
  const auto direction = box_direction(points);
  const Polygon box = direction ? box_along(hull, *direction) : hull;
  const ThingColumns columns = columns_of(points, box, voxel_m, seen_empty);
  if (direction && empty_share(columns, box) <= kMostEmpty) return box;
  if (empty_share(columns, hull) <= kMostEmpty) return simplified(hull, voxel_m / 2);
  return std::nullopt;
}

// The hull without what was seen to be empty.
Polygon remaining_outline(const Points& points, double voxel_m, const SeenEmpty& seen_empty) {
  const Polygon hull = hull_of(points);
  const ThingColumns columns = columns_of(points, hull, voxel_m, seen_empty);
  CellSet cells(columns.grid.size(), 0);
  add_polygon(columns.grid, hull, cells);
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    cells[cell] = columns.surface[cell] != 0 || (cells[cell] != 0 && columns.empty[cell] == 0) ? 1 : 0;
  }
  return simplified(largest_outline(columns.grid, cells),
                    1.5 * voxel_m);  // three quarters of a cell: steps become slopes, arms of a cell stay
}

// Takes piece after piece, the largest first, as long as the shape around them was not seen to be empty: parts of a thing that
// hide each other's connection stay together, wrongly labelled surface elsewhere in the room does not count.
ThingFootprint footprint_of(const Points& points, double voxel_m, const SeenEmpty& seen_empty) {
  const std::vector<Points> pieces = pieces_of(points, voxel_m);
  const double least_m2 = kLeastShare * area_of(pieces.front());
  ThingFootprint print;
  Points kept = pieces.front();
  std::optional<Polygon> shape = filled_shape(kept, voxel_m, seen_empty);
  for (std::size_t i = 1; shape && i < pieces.size() && area_of(pieces[i]) >= least_m2; ++i) {
    Points with = kept;
    with.insert(with.end(), pieces[i].begin(), pieces[i].end());
    auto larger = filled_shape(with, voxel_m, seen_empty);
    if (!larger) continue;
    kept = std::move(with);
    shape = std::move(larger);
  }
  print.polygon = shape ? *std::move(shape) : remaining_outline(kept, voxel_m, seen_empty);
  set_heights(kept, print);
  return print;
}

}  // namespace

std::vector<ThingFootprint> footprints(const LabelledSurface& surface, const SeenEmpty& seen_empty) {
  constexpr std::size_t kFewest = 20;
  std::vector<ThingFootprint> all;
  for (const auto& [id, points] : surface.of_object) {
    if (points.size() < kFewest) continue;
    Points own;
    for (const LabelledPoint& p : points) own.push_back(&p);
    ThingFootprint print = footprint_of(own, surface.voxel_m, seen_empty);
    print.object = id;
    print.class_id = surface.class_of.at(id);
    if (signed_area(print.polygon) > 0) all.push_back(std::move(print));
  }
  return all;
}

}  // namespace panoptic
