// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/doors.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "panoptic/planning/wall_gaps.h"

namespace panoptic {
namespace {

constexpr double kUsualHeight_m = 2.0;  // of a door, where the wall above was not seen
constexpr double kThickest_m = 0.5;     // wall between the two sides of one opening
constexpr double kParallel = 0.97;      // cosine of 14 degrees

// One side of an opening, or both.
struct FoundGap {
  Vec2d center = Vec2d::Zero();
  Vec2d along = Vec2d::UnitX();
  double width_m = 0;
  double height_m = 0;
  double wall_m = 0;
  bool is_merged = false;
};

std::vector<FoundGap> gaps_of_all(const WalledFloor& home) {
  std::vector<FoundGap> found;
  for (const WallPlane& plane : home.planes) {
    for (const WallGap& gap : find_wall_gaps(plane, home.floor)) {
      const double middle_m = (gap.width.low_m + gap.width.high_m) / 2;
      found.push_back({plane.at(middle_m), plane.tangent(), gap.width.length_m(), gap.height_m, 0, false});
    }
  }
  return found;
}

bool are_sides_of_one(const FoundGap& a, const FoundGap& b) {
  const Vec2d between = b.center - a.center;
  const double along_m = std::abs(a.along.dot(between));
  return std::abs(a.along.dot(b.along)) > kParallel && along_m < std::max(a.width_m, b.width_m) / 2 &&
         std::abs(cross(a.along, between)) < kThickest_m;
}

// The mean of the sides; a gap is seen from each room.
std::vector<FoundGap> merged(std::vector<FoundGap> gaps) {
  std::vector<FoundGap> result;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (gaps[i].is_merged) continue;
    FoundGap sum = gaps[i];
    int sides = 1;
    for (std::size_t j = i + 1; j < gaps.size(); ++j) {
      if (gaps[j].is_merged || !are_sides_of_one(gaps[i], gaps[j])) continue;
      gaps[j].is_merged = true;
      sum.center += gaps[j].center;
      sum.width_m += gaps[j].width_m;
      sum.height_m = std::max(sum.height_m, gaps[j].height_m);
      sum.wall_m = std::max(sum.wall_m, std::abs(cross(gaps[i].along, gaps[j].center - gaps[i].center)));
      ++sides;
    }
    sum.center /= sides;
    sum.width_m /= sides;
    result.push_back(sum);
  }
  return result;
}

Opening open_gap(const FoundGap& gap) {
  Opening opening;
  opening.center = {gap.center.x(), gap.center.y(), 0};
  opening.along = {gap.along.x(), gap.along.y(), 0};
  opening.width_m = gap.width_m;
  opening.height_m = gap.height_m > 0 ? gap.height_m : kUsualHeight_m;
  opening.wall_m = gap.wall_m;
  return opening;
}

// A door's leaf from above.
struct Leaf {
  PanopticId object = PanopticId::kUnknown;
  Vec2d center = Vec2d::Zero();
  Vec2d along = Vec2d::UnitX();
  double width_m = 0;
  double top_m = 0;

  Vec2d end(int side) const { return center + along * (side * width_m / 2); }
};

double at_share(std::vector<double> values, double share) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

std::optional<Leaf> leaf_of(PanopticId id, const std::vector<LabelledPoint>& points) {
  constexpr std::size_t kFewest = 50;
  constexpr double kNarrowest_m = 0.4;
  constexpr double kLowest_m = 1.2;
  std::vector<Vec2d> upright;
  std::vector<double> heights;
  Vec2d mean = Vec2d::Zero();
  for (const LabelledPoint& p : points) {
    if (std::abs(p.normal.z()) > 0.5) continue;
    upright.emplace_back(p.at.head<2>());
    heights.push_back(p.at.z());
    mean += upright.back();
  }
  if (upright.size() < kFewest) return std::nullopt;
  mean /= static_cast<double>(upright.size());
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Vec2d& p : upright) covariance += (p - mean) * (p - mean).transpose();
  Leaf leaf;
  leaf.object = id;
  leaf.along = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvectors().col(1);
  std::vector<double> along_m;
  for (const Vec2d& p : upright) along_m.push_back(leaf.along.dot(p - mean));
  const double low_m = at_share(along_m, 0.01);
  const double high_m = at_share(along_m, 0.99);
  leaf.width_m = high_m - low_m;
  leaf.center = mean + leaf.along * (low_m + high_m) / 2;
  leaf.top_m = at_share(heights, 0.98);
  const bool is_one = leaf.width_m > kNarrowest_m && leaf.top_m > kLowest_m;
  return is_one ? std::optional(leaf) : std::nullopt;
}

Vec2d flat(const Vec3d& v) { return v.head<2>(); }

double distance_from_jambs(const Opening& opening, const Leaf& leaf) {
  double nearest_m = 1e9;
  for (const int jamb : {-1, 1}) {
    for (const int end : {-1, 1}) {
      const Vec2d at = flat(opening.center) + jamb * opening.width_m / 2 * flat(opening.along);
      nearest_m = std::min(nearest_m, (leaf.end(end) - at).norm());
    }
  }
  return nearest_m;
}

// Gives the leaf to the opening at whose jamb it hangs; false if there is none.
bool hang(const Leaf& leaf, std::vector<Opening>& openings) {
  constexpr double kHinge_m = 0.3;
  Opening* best = nullptr;
  double nearest_m = kHinge_m;
  for (Opening& opening : openings) {
    const double distance_m = distance_from_jambs(opening, leaf);
    if (distance_m < nearest_m) nearest_m = distance_m, best = &opening;
  }
  if (best == nullptr) return false;
  best->leaf = leaf.object;
  best->leaf_line = {leaf.end(-1), leaf.end(1)};
  const Vec2d from_center = leaf.center - flat(best->center);
  const bool lies_in_it = std::abs(flat(best->along).dot(leaf.along)) > kParallel && from_center.norm() < best->width_m / 2;
  best->is_open = !lies_in_it;
  return true;
}

// The wall that a closed leaf lies in: parallel, no farther from the leaf than a wall is thick, and solid beside it.
const WallPlane* wall_around(const Leaf& leaf, const WalledFloor& home) {
  constexpr double kDeepest_m = 0.25;
  constexpr double kBeside_m = 0.3;
  const WallPlane* best = nullptr;
  double nearest_m = kDeepest_m;
  for (const WallPlane& plane : home.planes) {
    const double distance_m = std::abs(plane.before_m(leaf.center));
    if (std::abs(plane.tangent().dot(leaf.along)) < kParallel || distance_m >= nearest_m) continue;
    const double along_m = plane.along_m(leaf.center);
    const bool is_beside = std::any_of(plane.solid.begin(), plane.solid.end(), [&](const Stretch& solid) {
      const double gap_m = std::max(solid.low_m - along_m, along_m - solid.high_m) - leaf.width_m / 2;
      return std::abs(gap_m) < kBeside_m;
    });
    if (is_beside) nearest_m = distance_m, best = &plane;
  }
  return best;
}

Opening closed_door(const Leaf& leaf, const WallPlane& wall) {
  Opening opening;
  opening.center = {leaf.center.x(), leaf.center.y(), 0};
  opening.along = {wall.tangent().x(), wall.tangent().y(), 0};
  opening.width_m = leaf.width_m;
  opening.height_m = leaf.top_m;
  opening.is_open = false;
  opening.leaf = leaf.object;
  opening.leaf_line = {leaf.end(-1), leaf.end(1)};
  return opening;
}

}  // namespace

std::vector<Opening> find_doors(const LabelledSurface& surface, const LabelSet& labels, const WalledFloor& home) {
  std::vector<Opening> openings;
  for (const FoundGap& gap : merged(gaps_of_all(home))) openings.push_back(open_gap(gap));
  for (const auto& [id, points] : surface.of_object) {
    if (!is_door_class(labels.name_of(surface.class_of.at(id)))) continue;
    const auto leaf = leaf_of(id, points);
    if (!leaf || hang(*leaf, openings)) continue;
    if (const WallPlane* wall = wall_around(*leaf, home)) openings.push_back(closed_door(*leaf, *wall));
  }
  return openings;
}

Polygon threshold_of(const Opening& opening, double beyond_m) {
  const Vec2d size_m(opening.width_m + 2 * beyond_m, opening.wall_m + 2 * beyond_m);
  return corners({flat(opening.center), flat(opening.along), size_m});
}

}  // namespace panoptic
