// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/free_places.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "panoptic/labels.h"
#include "panoptic/sim/floor_plan.h"

namespace panoptic {
namespace {

constexpr double kGap_m = 0.03;
constexpr double kDoorway_m = 0.7;  // stays free around a doorway and what shuts it
constexpr double kFromWay_m = 0.34;
constexpr double kApart_m = 0.15;  // between the old place and the new one
constexpr int kTries = 60;
constexpr ClassId kDoorClass{8};

}  // namespace

Eigen::AlignedBox3d box_of(const ThingBox& thing) {
  const Eigen::AlignedBox2d base = bounds(thing.base);
  return {Vec3d(base.min().x(), base.min().y(), thing.bottom_m), Vec3d(base.max().x(), base.max().y(), thing.top_m)};
}

FreePlaces::FreePlaces(const Home& home, const std::vector<Pose>& path) : home_(home), taken_(thing_boxes(home.scene)) {
  constexpr std::size_t kStride = 5;
  for (std::size_t i = 0; i < path.size(); i += kStride) way_.emplace_back(path[i].translation().head<2>());
  for (const Doorway& doorway : home.doorways) {
    const Eigen::Vector2d half = Eigen::Vector2d::Constant(doorway.width_m / 2 + 0.3);
    doors_.push_back({doorway.center, half, Eigen::Vector2d::UnitX()});
  }
  std::vector<std::uint16_t> doors;
  for (const SceneObject& object : home.scene.objects) {
    if (object.class_id == kDoorClass) doors.push_back(object.instance);
  }
  for (const ThingBox& thing : taken_) {
    if (std::find(doors.begin(), doors.end(), thing.instance) != doors.end()) doors_.push_back(grown(thing.base, kDoorway_m));
  }
}

bool FreePlaces::is_free(const ThingBox& place, const ThingBox& old_place) const {
  const FloorRect wide = grown(place.base, kGap_m);
  if (overlap(grown(place.base, kApart_m), old_place.base)) return false;
  for (const FloorRect& door : doors_) {
    if (overlap(wide, door)) return false;
  }
  for (const ThingBox& other : taken_) {
    const bool is_apart = other.top_m <= place.bottom_m + 1e-3 || other.bottom_m >= place.top_m - 1e-3;
    if (!is_apart && overlap(wide, other.base)) return false;
  }
  return std::all_of(way_.begin(), way_.end(),
                     [&](const Eigen::Vector2d& foot) { return distance_m(place.base, foot) > kFromWay_m; });
}

std::optional<ThingBox> FreePlaces::find(const ThingBox& thing, Random& random) const {
  const auto room =
      std::find_if(home_.rooms.begin(), home_.rooms.end(), [&](const Room& r) { return r.floor.contains(thing.base.center); });
  if (room == home_.rooms.end()) return std::nullopt;
  constexpr std::array<Side, 4> kSides = {Side::kWest, Side::kEast, Side::kSouth, Side::kNorth};
  for (int i = 0; i < kTries; ++i) {
    const WallFace face = wall_face(room->floor, kSides[random.index(kSides.size())]);
    const bool at_wall = i % 2 == 0;
    ThingBox place = thing;
    place.base.axis = face.along;  // what faces -y stands with its back to this wall
    const double margin_m = place.base.half_m.x() + kGap_m;
    const double low_m = place.base.half_m.y() + kGap_m;
    const double depth_m = std::abs(face.inward.dot(room->floor.sizes()));
    if (face.length_m < 2 * margin_m || depth_m < 2 * low_m) continue;
    const double along_m = random.uniform(margin_m, face.length_m - margin_m);
    place.base.center = face.at(along_m, at_wall ? low_m : random.uniform(low_m, depth_m - low_m));
    if (is_free(place, thing)) return place;
  }
  return std::nullopt;
}

}  // namespace panoptic
