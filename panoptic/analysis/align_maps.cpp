// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/analysis/map_alignment.h"
#include "panoptic/analysis/object_matching.h"
#include "panoptic/error.h"
#include "panoptic/map/surface_sampler.h"
#include "panoptic/map_pairs.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr double kHorizontal = 0.94;  // the cosine of 20 degrees
constexpr double kSpacing_m = 0.08;   // of points of the surface
// The share of walls and furniture that both saw. In one place 98 % and more agree, less what was moved meanwhile; in two homes
// laid over each other as well as it goes, up to 60 % (docs/maps.md), and more where they overlap little: so objects are asked,
// too.
constexpr double kLeastAgreement = 0.8;
constexpr std::size_t kLeastObjects = 3;
constexpr double kLeastCommon_m2 = 2;   // of walls and furniture
constexpr double kLeastHold = 0.02;     // a sixtieth of what a ball seen from all sides has
constexpr double kMostOfSecond = 0.85;  // of the best pose's common surface: two poses that are alike good say nothing
constexpr double kOther_m = 0.5;        // poses farther apart than that, or ...
constexpr double kOtherTurn = 0.15;     // ... than 9 degrees, are different ones

struct Side {
  const SavedMap& saved;
  Eigen::Quaterniond level_from_map;  // turns up to +z
  std::vector<PlacedNormal> surface;  // level
  std::vector<PlacedNormal> steep;    // those of it that are not horizontal: floors and ceilings fit anywhere
  std::vector<Landmark> landmarks;    // level

  Vec3d to_map(const Vec3d& level) const { return level_from_map.conjugate() * level; }
};

// Upwards in the map: how cameras were held tells it roughly, floors, table tops and ceilings exactly.
Vec3d level_up(const Vec3d& roughly, const std::vector<PlacedNormal>& surface) {
  Vec3d up = roughly;
  for (const double cosine : {0.6, 0.8, 0.94, 0.985, 0.985}) {
    Vec3d sum = Vec3d::Zero();
    for (const PlacedNormal& p : surface) {
      const double along = p.normal.dot(up);
      if (std::abs(along) > cosine) sum += along > 0 ? p.normal : Vec3d(-p.normal);
    }
    if (sum.norm() > 0) up = sum.normalized();
  }
  return up;
}

Side side_of(const SavedMap& saved, const std::string& name) {
  if (saved.map.free_space.empty()) {
    throw Error(fmt::format(
        "{} has no free space (an older file, voxels below 1.5 cm, or map.free_space was off), so nothing would speak "
        "against a wrong alignment; map it anew with free space",
        name));
  }
  std::vector<PlacedNormal> surface = surface_points(saved.map.voxels, kSpacing_m);
  if (surface.empty()) throw Error(fmt::format("{} has no surface, so it cannot be aligned", name));
  const Vec3d up = level_up(up_of(saved), surface);
  Side side{saved, Eigen::Quaterniond::FromTwoVectors(up, Vec3d::UnitZ()), std::move(surface), {}, {}};
  for (PlacedNormal& p : side.surface) {
    p = {side.level_from_map * p.at, side.level_from_map * p.normal};
    if (std::abs(p.normal.z()) < kHorizontal) side.steep.push_back(p);
  }
  const MapQuery query(saved.map);
  for (const FoundObject& object : query.objects()) {
    if (object.class_id == ClassId::kUnknown || object.voxels < kLeastComparedVoxels) continue;
    side.landmarks.push_back({object.class_id, side.level_from_map * object.box.center_m});
  }
  return side;
}

enum class Sight : std::uint8_t { kUnseen, kContradicted, kSeen };

// The map's view of a point of the other one's surface.
Sight sight_of(const PanopticMap& map, SurfaceSampler& sampler, const PlacedNormal& point) {
  constexpr double kOnSurface_voxels = 2;
  NearSurface near;
  if (sampler.at(point.at, near)) {
    const double off = double{near.distance_m} / map.voxels.voxel_size_m();
    if (std::abs(off) <= kOnSurface_voxels && near.normal.cast<double>().dot(point.normal) > 0.5) return Sight::kSeen;
    return off > kOnSurface_voxels ? Sight::kContradicted : Sight::kUnseen;
  }
  const std::optional<CellIndex> cell = map.free_space.cell_around(point.at);
  return cell && map.free_space.at(*cell) == Space::kFree ? Sight::kContradicted : Sight::kUnseen;
}

struct Judgement {
  std::size_t seen = 0;  // points of both surfaces that are surface in the other map
  std::size_t contradicted = 0;

  double agreement() const { return seen > 0 ? static_cast<double>(seen) / static_cast<double>(seen + contradicted) : 0; }
  double common_m2() const { return static_cast<double>(seen) / 2 * kSpacing_m * kSpacing_m; }  // if all points were asked
  double worth() const { return static_cast<double>(seen) - static_cast<double>(contradicted); }
};

void judge_side(const Side& seeing, const std::vector<PlacedNormal>& points, const Pose& seeing_from_points, Judgement& sum) {
  SurfaceSampler sampler(seeing.saved.map.voxels);
  for (const PlacedNormal& p : points) {
    const PlacedNormal there{seeing.to_map(seeing_from_points * p.at), seeing.to_map(seeing_from_points.linear() * p.normal)};
    const Sight sight = sight_of(seeing.saved.map, sampler, there);
    sum.seen += sight == Sight::kSeen ? 1 : 0;
    sum.contradicted += sight == Sight::kContradicted ? 1 : 0;
  }
}

Judgement judge(const Side& a, const Side& b, const Pose& a_from_b, std::size_t points) {
  Judgement sum;
  judge_side(a, some_of(b.steep, points), a_from_b, sum);
  judge_side(b, some_of(a.steep, points), a_from_b.inverse(), sum);
  return sum;
}

struct Candidate {
  SurfaceFit fit;
  Judgement judgement;
};

// Fits all poses from coarse to fine; the best first.
std::vector<Candidate> fitted_all(const Side& a, const FitTarget& target, const Side& b, const std::vector<Pose>& starts,
                                  const std::vector<double>& radii_m, std::size_t points) {
  constexpr int kSteps = 6;
  const std::vector<PlacedNormal> some = some_of(b.surface, points);
  std::vector<Candidate> candidates(starts.size());
  parallel_for(starts.size(), [&](std::size_t i) {
    SurfaceFit fit{starts[i], 0};
    for (const double radius_m : radii_m) fit = fitted(target, radius_m, some, fit.a_from_b, kSteps);
    candidates[i] = {fit, judge(a, b, fit.a_from_b, points)};
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& x, const Candidate& y) { return x.judgement.worth() > y.judgement.worth(); });
  return candidates;
}

bool are_alike(const Pose& x, const Pose& y, const Vec3d& at) {
  const double turn = Eigen::AngleAxisd(x.linear().transpose() * y.linear()).angle();
  return turn < kOtherTurn && (x * at - y * at).norm() < kOther_m;
}

// The best of those that are alike.
std::vector<Pose> different_poses(const std::vector<Candidate>& candidates, const Vec3d& middle_of_b, std::size_t most) {
  std::vector<Pose> poses;
  for (const Candidate& candidate : candidates) {
    const Pose& pose = candidate.fit.a_from_b;
    const bool is_known = std::any_of(poses.begin(), poses.end(), [&](const Pose& p) { return are_alike(p, pose, middle_of_b); });
    if (!is_known && poses.size() < most) poses.push_back(pose);
  }
  return poses;
}

Vec3d middle_of(const std::vector<PlacedNormal>& points) {
  Vec3d middle = Vec3d::Zero();
  for (const PlacedNormal& p : points) middle += p.at / static_cast<double>(points.size());
  return middle;
}

// Landmarks of one map that lie where the other has one of their class, counted in the map with fewer: parts of one thing do not
// count as several.
std::size_t common_objects(const Side& a, const Side& b, const Pose& a_from_b) {
  constexpr double kSame_m = 0.3;
  const auto are_one = [&](const Landmark& mine, const Landmark& theirs) {
    return mine.class_id == theirs.class_id && (mine.at - a_from_b * theirs.at).norm() < kSame_m;
  };
  const auto of_a = std::count_if(a.landmarks.begin(), a.landmarks.end(), [&](const Landmark& mine) {
    return std::any_of(b.landmarks.begin(), b.landmarks.end(), [&](const Landmark& l) { return are_one(mine, l); });
  });
  const auto of_b = std::count_if(b.landmarks.begin(), b.landmarks.end(), [&](const Landmark& theirs) {
    return std::any_of(a.landmarks.begin(), a.landmarks.end(), [&](const Landmark& l) { return are_one(l, theirs); });
  });
  return static_cast<std::size_t>(std::min(of_a, of_b));
}

// Why the best pose is not to be believed; empty if it is.
std::string doubt_about(const std::vector<Candidate>& best, std::size_t objects) {
  if (best.empty()) return "they have no two objects of the same classes at the same distance";
  const Candidate& first = best.front();
  if (first.judgement.agreement() < kLeastAgreement) {
    return fmt::format("where most objects would agree, only {:.0f} % of walls and furniture do ({:.0f} % are needed)",
                       100 * first.judgement.agreement(), 100 * kLeastAgreement);
  }
  if (objects < kLeastObjects) {
    return fmt::format("they have {} objects in common where walls fit best; {} are needed", objects, kLeastObjects);
  }
  if (first.judgement.common_m2() < kLeastCommon_m2) {
    return fmt::format("they have {:.1f} m2 of walls and furniture in common; {} are needed", first.judgement.common_m2(),
                       kLeastCommon_m2);
  }
  if (first.fit.least_hold < kLeastHold) return "the surface that they have in common lets one slide along the other";
  if (best.size() > 1 && best[1].judgement.worth() > kMostOfSecond * first.judgement.worth()) {
    return "they fit together in two ways that are alike good";
  }
  return "";
}

}  // namespace

MapAlignment align_maps(const MapWithFrames& map_a, const MapWithFrames& map_b, const std::string& name_a,
                        const std::string& name_b) {
  require_comparable(map_a.saved.header(), map_b.saved.header(), name_a, name_b);
  constexpr std::size_t kGuesses = 150;
  constexpr std::size_t kBest = 8;
  constexpr std::size_t kFewPoints = 400;
  constexpr std::size_t kManyPoints = 4000;
  const Side a = side_of(map_a.saved, name_a);
  const Side b = side_of(map_b.saved, name_b);
  const FitTarget target(a.surface);
  const Vec3d middle = middle_of(b.surface);
  const auto guesses =
      fitted_all(a, target, b, poses_by_constellations(a.landmarks, b.landmarks, kGuesses), {0.6, 0.3}, kFewPoints);
  const auto better = fitted_all(a, target, b, different_poses(guesses, middle, kBest), {0.3, 0.15, 0.1}, kManyPoints);
  auto best = fitted_all(a, target, b, different_poses(better, middle, 2), {0.1}, kManyPoints);
  if (best.size() > 1 && are_alike(best[0].fit.a_from_b, best[1].fit.a_from_b, middle)) best.pop_back();
  for (Candidate& c : best) c.judgement = judge(a, b, c.fit.a_from_b, std::max(a.steep.size(), b.steep.size()));
  const std::size_t objects = best.empty() ? 0 : common_objects(a, b, best.front().fit.a_from_b);
  if (const std::string doubt = doubt_about(best, objects); !doubt.empty()) {
    throw Error(fmt::format("{} cannot be aligned with {}: {}; are they of one place?", name_b, name_a, doubt));
  }
  MapAlignment result;
  const Pose& level = best.front().fit.a_from_b;
  result.a_from_b = Pose(a.level_from_map.conjugate()) * level * Pose(b.level_from_map);
  result.agreement = best.front().judgement.agreement();
  result.common_m2 = best.front().judgement.common_m2();
  result.objects = objects;
  return result;
}

}  // namespace panoptic
