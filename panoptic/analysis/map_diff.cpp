// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map_pairs.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "panoptic/analysis/object_matching.h"
#include "panoptic/analysis/seen_space.h"
#include "panoptic/analysis/surface_drift.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

// Points of an object's surface that the other map is asked about.
constexpr std::size_t kMostPoints = 96;

// The surface voxels of some objects, their centres in metres.
using Surfaces = std::map<PanopticId, std::vector<Vec3d>>;

Surfaces surfaces_of(const VoxelMap& map, const std::map<LabelSlot, PanopticId>& ids) {
  Surfaces surfaces;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    visit_surface(map.block(slot), map.index_of(slot), map.voxel_size_m(), [&](LabelSlot label, const VoxelIndex& voxel) {
      const auto id = ids.find(label);
      if (id != ids.end()) surfaces[id->second].push_back(center_m(voxel, map.voxel_size_m()));
    });
  }
  return surfaces;
}

// Standard deviations along the principal axes, ascending.
Vec3d spread_of(const std::vector<Vec3d>& points) {
  Vec3d mean = Vec3d::Zero();
  for (const Vec3d& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vec3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  covariance /= static_cast<double>(points.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
}

// The other map's view of an object's place.
struct PlaceSight {
  double free = 0;
  double surface = 0;  // shares of its points
};

PlaceSight look_at_place(const std::vector<Vec3d>& points, const SeenSpace& other) {
  const std::size_t count = std::min(points.size(), kMostPoints);
  std::vector<Occupancy> sights(count);
  parallel_for(count, [&](std::size_t i) { sights[i] = other.at(points[i * points.size() / count]); });
  const auto share = [&](Occupancy sight) {
    return static_cast<double>(std::count(sights.begin(), sights.end(), sight)) / static_cast<double>(count);
  };
  return {share(Occupancy::kFree), share(Occupancy::kSurface)};
}

// An object that has no counterpart in place.
struct Single {
  FoundObject object;
  Vec3d spread;
  PlaceSight sight;

  bool seen() const { return sight.free + sight.surface >= kLeastSeenShare; }
  bool place_empty() const { return seen() && sight.free >= sight.surface; }
  bool place_taken() const { return seen() && sight.free < sight.surface; }
};

// Both maps with what is asked of them.
struct Side {
  const SavedMap& saved;
  std::vector<FoundObject> objects;
  SeenSpace space;

  explicit Side(const MapWithFrames& map)
      : saved(map.saved),
        objects(MapQuery(map.saved.map).objects()),
        space(map.saved.map, map.frames, option_of(map.saved, "depth.max_m").value_or(double{DepthOptions{}.max_m})) {}

  const FoundObject* find(PanopticId id) const {
    const auto found = std::find_if(objects.begin(), objects.end(), [&](const FoundObject& o) { return o.id == id; });
    return found == objects.end() ? nullptr : &*found;
  }
};

// Those of the side that are not matched, and large enough; the others are counted.
std::vector<Single> singles_of(const Side& side, const std::set<PanopticId>& matched, const SeenSpace& other,
                               std::size_t& too_small) {
  std::map<LabelSlot, PanopticId> ids;
  for (const FoundObject& object : side.objects) {
    if (matched.contains(object.id)) continue;
    if (object.voxels < kLeastComparedVoxels) {
      ++too_small;
    } else {
      ids[object.slot] = object.id;
    }
  }
  std::vector<Single> singles;
  for (const auto& [id, points] : surfaces_of(side.saved.map.voxels, ids)) {
    singles.push_back({*side.find(id), spread_of(points), look_at_place(points, other)});
  }
  return singles;
}

bool similar(const Single& a, const Single& b, double voxel_size_m) {
  if (a.object.class_id != b.object.class_id || a.object.class_id == ClassId::kUnknown) return false;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double x = a.spread[axis] + voxel_size_m / 2;
    const double y = b.spread[axis] + voxel_size_m / 2;
    if (x > kSimilarSpread * y || y > kSimilarSpread * x) return false;
  }
  return true;
}

// Pairs objects that vanished with objects that came, the nearest first: things are moved within a room rather than through the
// house.
void pair_moved(std::vector<Single>& gone, std::vector<Single>& come, double voxel_size_m, MapDiff& diff) {
  std::vector<std::tuple<double, PanopticId, PanopticId>> candidates;
  for (const Single& a : gone) {
    for (const Single& b : come) {
      if (!a.place_empty() || b.place_taken() || !similar(a, b, voxel_size_m)) continue;
      candidates.emplace_back((b.object.box.center_m - a.object.box.center_m).norm(), a.object.id, b.object.id);
    }
  }
  std::sort(candidates.begin(), candidates.end());
  for (const auto& [moved_m, id_a, id_b] : candidates) {
    const auto is = [](PanopticId id) { return [id](const Single& s) { return s.object.id == id; }; };
    const auto a = std::find_if(gone.begin(), gone.end(), is(id_a));
    const auto b = std::find_if(come.begin(), come.end(), is(id_b));
    if (a == gone.end() || b == come.end()) continue;
    diff.changes.push_back({ChangeKind::kMoved, a->object, b->object, a->sight.free, moved_m});
    gone.erase(a);
    come.erase(b);
  }
}

void add_pairs(const std::vector<ObjectMatch>& matches, const Side& a, const Side& b, MapDiff& diff) {
  for (const ObjectMatch& match : matches) {
    const FoundObject* before = a.find(match.a);
    const FoundObject* after = b.find(match.b);
    const bool other_class = before != nullptr && after != nullptr && before->class_id != after->class_id;
    if (other_class) {
      diff.changes.push_back({ChangeKind::kOtherLabel, *before, *after, 0, 0});
    } else if (match.kind != MatchKind::kPartOfA) {
      ++diff.unchanged;
    }
  }
}

ChangeKind kind_of(const Single& single, ChangeKind if_empty, ChangeKind if_unseen) {
  if (!single.seen()) return if_unseen;
  return single.place_empty() ? if_empty : ChangeKind::kOtherLabel;
}

std::string note_of_guess(const std::string& name) {
  return fmt::format(
      "{} has no free space: what it saw to be empty is guessed, in a cone of {} degrees around where cameras looked", name,
      SeenSpace::kViewCone_deg);
}

std::string note_of_drift(const SurfaceShift& shift) {
  return fmt::format(
      "the surfaces of the two maps lie {:.1f} cm apart (median), more than a voxel: poses drifted, or the worlds are not one; "
      "what "
      "vanished or appeared may be where it was (--align, or correct the poses)",
      100 * shift.median_m);
}

// Ascending by kind, then by ids.
void sort_changes(std::vector<ObjectChange>& changes) {
  const auto id = [](const std::optional<FoundObject>& o) { return o ? o->id : PanopticId::kUnknown; };
  std::vector<std::tuple<ChangeKind, PanopticId, PanopticId, std::size_t>> order;
  for (const ObjectChange& c : changes) order.emplace_back(c.kind, id(c.before), id(c.after), order.size());
  std::sort(order.begin(), order.end());
  std::vector<ObjectChange> sorted;
  for (const auto& entry : order) sorted.push_back(changes[std::get<3>(entry)]);
  changes = std::move(sorted);
}

}  // namespace

std::string_view name_of(ChangeKind kind) {
  constexpr std::string_view kNames[] = {"vanished", "appeared", "moved", "other_label", "not_seen_in_b", "not_seen_in_a"};
  return kNames[static_cast<std::size_t>(kind)];
}

MapDiff diff_maps(const MapWithFrames& a, const MapWithFrames& b, const std::string& name_a, const std::string& name_b) {
  require_comparable(a.saved.header(), b.saved.header(), name_a, name_b);
  const Side before(a);
  const Side after(b);
  const std::vector<ObjectMatch> matches = match_objects(a.saved, b.saved);
  std::set<PanopticId> matched_a;
  std::set<PanopticId> matched_b;
  for (const ObjectMatch& match : matches) {
    matched_a.insert(match.a);
    matched_b.insert(match.b);
  }
  MapDiff diff;
  if (before.space.is_guessed()) diff.notes.push_back(note_of_guess(name_a));
  if (after.space.is_guessed()) diff.notes.push_back(note_of_guess(name_b));
  add_pairs(matches, before, after, diff);
  std::vector<Single> gone = singles_of(before, matched_a, after.space, diff.too_small);
  std::vector<Single> come = singles_of(after, matched_b, before.space, diff.too_small);
  pair_moved(gone, come, a.saved.map.voxels.voxel_size_m(), diff);
  for (const Single& s : gone) {
    diff.changes.push_back({kind_of(s, ChangeKind::kVanished, ChangeKind::kNotSeenInB), s.object, std::nullopt, s.sight.free, 0});
  }
  for (const Single& s : come) {
    diff.changes.push_back({kind_of(s, ChangeKind::kAppeared, ChangeKind::kNotSeenInA), std::nullopt, s.object, s.sight.free, 0});
  }
  sort_changes(diff.changes);
  diff.shift = shift_between(a.saved.map.voxels, b.saved.map.voxels);
  constexpr double kLeastCommon = 0.2;  // what two places have in common by chance says nothing
  const bool is_drift = diff.shift.common >= kLeastCommon && diff.shift.median_m > double{a.saved.map.voxels.voxel_size_m()};
  if (is_drift) diff.notes.push_back(note_of_drift(diff.shift));
  return diff;
}

}  // namespace panoptic
