// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mesh.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "panoptic/base/polygon.h"
#include "panoptic/data/speaker.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

using Eigen::Matrix3d;

// The vertices and triangles of one panoptic id.
struct Part {
  std::vector<std::uint32_t> vertices;
  std::vector<std::uint32_t> triangles;
};

// Sums over a surface; each triangle counts as the uniform sheet that it is, not as its corners.
struct Moments {
  double area = 0;
  Vec3d first = Vec3d::Zero();          // sum of area * position
  Matrix3d second = Matrix3d::Zero();   // sum of area * position * position^T
  Matrix3d normals = Matrix3d::Zero();  // sum of area * normal * normal^T
};

std::array<Vec3d, 3> corners_of(const Mesh& mesh, std::uint32_t triangle) {
  const auto corner = [&](std::size_t i) -> Vec3d { return mesh.vertices[mesh.triangles[triangle][i]].position.cast<double>(); };
  return {corner(0), corner(1), corner(2)};
}

double area_of(const std::array<Vec3d, 3>& c) { return 0.5 * (c[1] - c[0]).cross(c[2] - c[0]).norm(); }

// Positions relative to `origin`, so that far from the world's origin nothing cancels.
Moments moments_of(const Mesh& mesh, const Part& part, const Vec3d& origin) {
  Moments sum;
  for (const std::uint32_t triangle : part.triangles) {
    std::array<Vec3d, 3> c = corners_of(mesh, triangle);
    for (Vec3d& corner : c) corner -= origin;
    const Vec3d twice_area_normal = (c[1] - c[0]).cross(c[2] - c[0]);
    const double area = 0.5 * twice_area_normal.norm();
    if (area <= 0) continue;
    const Vec3d total = c[0] + c[1] + c[2];
    sum.area += area;
    sum.first += area / 3 * total;
    sum.normals += twice_area_normal * twice_area_normal.transpose() / (4 * area);
    sum.second += area / 12 * total * total.transpose();
    for (const Vec3d& corner : c) sum.second += area / 12 * corner * corner.transpose();
  }
  return sum;
}

// The points that lie furthest in directions spread evenly over the sphere: nearly the corners of the convex hull.
std::vector<Vec3d> outermost(const std::vector<Vec3d>& points) {
  constexpr std::size_t kDirections = 192;  // half a sphere, both ends of each
  if (points.size() <= 2 * kDirections) return points;
  std::vector<std::size_t> picked;
  for (std::size_t k = 0; k < kDirections; ++k) {
    const double z = (static_cast<double>(k) + 0.5) / kDirections;
    const double turn = 2.399963229728653 * static_cast<double>(k);  // the golden angle
    const double r = std::sqrt(1 - z * z);
    const Vec3d direction(r * std::cos(turn), r * std::sin(turn), z);
    std::size_t lowest = 0;
    std::size_t highest = 0;
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double along = direction.dot(points[i]);
      if (along < low) low = along, lowest = i;
      if (along > high) high = along, highest = i;
    }
    picked.push_back(lowest);
    picked.push_back(highest);
  }
  std::sort(picked.begin(), picked.end());
  picked.erase(std::unique(picked.begin(), picked.end()), picked.end());
  std::vector<Vec3d> result;
  for (const std::size_t i : picked) result.push_back(points[i]);
  return result;
}

std::pair<Vec3d, Vec3d> extent(const std::vector<Vec3d>& points, const Matrix3d& axes) {
  Vec3d low = Vec3d::Constant(std::numeric_limits<double>::infinity());
  Vec3d high = -low;
  for (const Vec3d& point : points) {
    const Vec3d along = axes.transpose() * point;
    low = low.cwiseMin(along);
    high = high.cwiseMax(along);
  }
  return {low, high};
}

// Half the surface of a box: what "small" means here, because the volume of a flat object is nothing however it is turned.
double half_surface(const Vec3d& size) { return size.x() * size.y() + size.y() * size.z() + size.z() * size.x(); }

// The turn about the first axis that makes the box smallest: it has a side flush with an edge of the outline.
Matrix3d turned_about_first(const std::vector<Vec3d>& points, const Matrix3d& axes) {
  std::vector<Vec2d> outline;
  for (const Vec3d& point : points) outline.emplace_back(axes.col(1).dot(point), axes.col(2).dot(point));
  outline = convex_hull(std::move(outline));
  const auto [low, high] = extent(points, axes);
  Matrix3d best = axes;
  double smallest = half_surface(high - low);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2d edge = outline[(i + 1) % outline.size()] - outline[i];
    if (edge.norm() <= 0) continue;
    const Vec2d along = edge.normalized();
    Vec2d inner = Vec2d::Constant(std::numeric_limits<double>::infinity());
    Vec2d outer = -inner;
    for (const Vec2d& point : outline) {
      const Vec2d turned(along.dot(point), cross(along, point));
      inner = inner.cwiseMin(turned);
      outer = outer.cwiseMax(turned);
    }
    const Vec2d side = outer - inner;
    const double surface = half_surface({high.x() - low.x(), side.x(), side.y()});
    if (surface >= smallest) continue;
    smallest = surface;
    best.col(1) = axes.col(1) * along.x() + axes.col(2) * along.y();
    best.col(2) = axes.col(0).cross(best.col(1));
  }
  return best;
}

struct Fit {
  Matrix3d axes = Matrix3d::Identity();
  double surface = std::numeric_limits<double>::infinity();
};

// Turns about each axis in turn for as long as the box gets smaller.
Fit tightened(const std::vector<Vec3d>& points, Matrix3d axes) {
  constexpr int kMaxTurns = 12;
  constexpr double kWorthIt = 1 - 1e-6;
  Fit fit;
  int since_better = 0;
  for (int turn = 0; turn < kMaxTurns && since_better < 3; ++turn) {
    axes = turned_about_first(points, axes);
    const auto [low, high] = extent(points, axes);
    const double surface = half_surface(high - low);
    since_better = surface < fit.surface * kWorthIt ? 0 : since_better + 1;
    if (surface < fit.surface) fit = {axes, surface};
    axes = (Matrix3d() << axes.col(1), axes.col(2), axes.col(0)).finished();
  }
  return fit;
}

Matrix3d principal_axes(const Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(symmetric);
  Matrix3d axes = solver.eigenvectors();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

// Longest edge first; signs such that the same object gives the same axes however the search ran.
OrientedBox box_along(const std::vector<Vec3d>& points, const Matrix3d& axes) {
  const auto [low, high] = extent(points, axes);
  const Vec3d size = high - low;
  std::array<int, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return size[a] > size[b]; });
  OrientedBox box;
  box.center_m = axes * (0.5 * (low + high));
  for (int i = 0; i < 3; ++i) {
    box.size_m[i] = size[order[static_cast<std::size_t>(i)]];
    Vec3d axis = axes.col(order[static_cast<std::size_t>(i)]).normalized();
    int largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    box.axes.col(i) = axis[largest] < 0 ? Vec3d(-axis) : axis;
  }
  box.axes.col(2) = box.axes.col(0).cross(box.axes.col(1));
  return box;
}

OrientedBox smallest_box(const std::vector<Vec3d>& points, const Matrix3d& covariance, const Matrix3d& normals) {
  const std::vector<Vec3d> outer = outermost(points);
  Fit best;
  // Three starts: a cube or a square table has no principal axes, but it has normals; a blob has neither.
  for (const Matrix3d& start : {principal_axes(covariance), principal_axes(normals), Matrix3d(Matrix3d::Identity())}) {
    const Fit fit = tightened(outer, start);
    if (fit.surface < best.surface) best = fit;
  }
  return box_along(points, best.axes);
}

ClassId most_frequent_class(const Mesh& mesh, const Part& part) {
  std::map<ClassId, std::size_t> votes;
  for (const std::uint32_t v : part.vertices) votes[mesh.vertices[v].class_id]++;
  return std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
}

ObjectShape shape_of(const Mesh& mesh, PanopticId id, const Part& part) {
  ObjectShape shape{.id = id, .class_id = most_frequent_class(mesh, part), .vertices = part.vertices.size()};
  Vec3d mean = Vec3d::Zero();
  for (const std::uint32_t v : part.vertices) mean += mesh.vertices[v].position.cast<double>();
  mean /= static_cast<double>(part.vertices.size());
  std::vector<Vec3d> points;
  Matrix3d covariance = Matrix3d::Zero();
  for (const std::uint32_t v : part.vertices) {
    const Vec3d point = mesh.vertices[v].position.cast<double>() - mean;
    points.push_back(point);
    covariance += point * point.transpose();
  }
  const Moments surface = moments_of(mesh, part, mean);
  shape.area_m2 = surface.area;
  shape.centroid_m = mean;
  if (surface.area > 0) {
    const Vec3d offset = surface.first / surface.area;
    shape.centroid_m += offset;
    covariance = surface.second / surface.area - offset * offset.transpose();
  }
  const auto [low, high] = extent(points, Matrix3d::Identity());
  shape.min_m = low + mean;
  shape.max_m = high + mean;
  shape.oriented_box = smallest_box(points, covariance, surface.normals);
  shape.oriented_box.center_m += mean;
  return shape;
}

}  // namespace

std::vector<ObjectShape> object_shapes(const Mesh& mesh) {
  std::map<PanopticId, Part> parts;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) parts[mesh.vertices[v].panoptic_id].vertices.push_back(v);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const std::array<PanopticId, 3> ids = {mesh.vertices[a].panoptic_id, mesh.vertices[b].panoptic_id,
                                           mesh.vertices[c].panoptic_id};
    parts[ids[speaker(ids[0], ids[1], ids[2])]].triangles.push_back(t);
  }
  parts.erase(PanopticId::kUnknown);
  std::vector<std::pair<PanopticId, const Part*>> listed;
  for (const auto& [id, part] : parts) listed.emplace_back(id, &part);
  std::vector<ObjectShape> shapes(listed.size());
  parallel_for(listed.size(), [&](std::size_t i) { shapes[i] = shape_of(mesh, listed[i].first, *listed[i].second); });
  return shapes;
}

std::map<ClassId, double> class_areas_m2(const Mesh& mesh) {
  std::map<ClassId, double> areas;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const std::array<ClassId, 3> ids = {mesh.vertices[a].class_id, mesh.vertices[b].class_id, mesh.vertices[c].class_id};
    areas[ids[speaker(ids[0], ids[1], ids[2])]] += area_of(corners_of(mesh, t));
  }
  return areas;
}

}  // namespace panoptic
