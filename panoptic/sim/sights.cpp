// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "panoptic/sim/floor_plan.h"
#include "panoptic/sim/walk.h"

namespace panoptic {
namespace {

constexpr double kPatch_m = 0.9;
constexpr double kWallWeight = 0.3;
constexpr double kFloorWeight = 0.25;

// The room that a spot lies in or, in a wall, next to.
std::uint32_t room_at(const Home& home, const Eigen::Vector2d& point) {
  std::uint32_t nearest = 0;
  for (std::uint32_t room = 1; room < home.rooms.size(); ++room) {
    if (home.rooms[room].floor.squaredExteriorDistance(point) < home.rooms[nearest].floor.squaredExteriorDistance(point))
      nearest = room;
  }
  return nearest;
}

void add_thing(const Home& home, const ClearanceMap& clearance, const ThingBox& thing, std::vector<Sight>& sights) {
  const std::uint32_t room = room_at(home, thing.base.center);
  const double height_m = thing.top_m - thing.bottom_m;
  const double middle_m = (thing.bottom_m + thing.top_m) / 2;
  const double volume_weight = std::clamp(std::cbrt(8 * thing.base.half_m.prod() * height_m / 2), 0.3, 1.5);
  if (thing.top_m < 1.1) {
    const Vec3d top(thing.base.center.x(), thing.base.center.y(), thing.top_m);
    sights.push_back({top, Vec3d::UnitZ(), room, 1.5 * volume_weight});
  }
  for (const double sign : {1.0, -1.0}) {
    for (const bool is_front : {true, false}) {
      const Eigen::Vector2d normal = sign * (is_front ? thing.base.across() : thing.base.axis);
      const double half_m = is_front ? thing.base.half_m.y() : thing.base.half_m.x();
      const Eigen::Vector2d point = thing.base.center + normal * half_m;
      const bool is_open = home.rooms[room].floor.contains(point + normal * 0.3) && clearance.at(point + normal * 0.3) > 0.1;
      if (!is_open) continue;
      sights.push_back({Vec3d(point.x(), point.y(), middle_m), Vec3d(normal.x(), normal.y(), 0), room, volume_weight});
    }
  }
}

void add_room(const Home& home, std::uint32_t room, std::vector<Sight>& sights) {
  const Eigen::AlignedBox2d& floor = home.rooms[room].floor;
  const Eigen::Vector2i patches = (floor.sizes() / kPatch_m).array().ceil().cast<int>();
  for (int y = 0; y < patches.y(); ++y) {
    for (int x = 0; x < patches.x(); ++x) {
      const Eigen::Vector2d share((x + 0.5) / patches.x(), (y + 0.5) / patches.y());
      const Eigen::Vector2d point = floor.min() + floor.sizes().cwiseProduct(share);
      sights.push_back({Vec3d(point.x(), point.y(), 0), Vec3d::UnitZ(), room, kFloorWeight});
    }
  }
  for (const Side side : {Side::kWest, Side::kEast, Side::kSouth, Side::kNorth}) {
    const WallFace face = wall_face(floor, side);
    const int count = static_cast<int>(std::ceil(face.length_m / kPatch_m));
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d point = face.at((i + 0.5) / count * face.length_m);
      for (const double z_m : {0.6, 1.5}) {
        sights.push_back({Vec3d(point.x(), point.y(), z_m), Vec3d(face.inward.x(), face.inward.y(), 0), room, kWallWeight});
      }
    }
  }
}

}  // namespace

std::vector<Sight> sights(const Home& home, const ClearanceMap& clearance) {
  std::vector<Sight> all;
  for (std::uint32_t room = 0; room < home.rooms.size(); ++room) add_room(home, room, all);
  for (const ThingBox& thing : thing_boxes(home.scene)) add_thing(home, clearance, thing, all);
  return all;
}

bool is_in_reach(const Sight& sight, const Vec3d& eye) {
  const Vec3d towards_eye = eye - sight.point;
  const double distance_m = towards_eye.norm();
  return distance_m > 0.75 && distance_m < 3.0 && towards_eye.dot(sight.normal) > 0.3 * distance_m;
}

ClearanceMap walking_clearance(const Home& home, double head_m) {
  Eigen::AlignedBox2d area;
  for (const Room& room : home.rooms) area.extend(room.floor);
  ClearanceMap clearance(Eigen::AlignedBox2d(area.min().array() - 0.1, area.max().array() + 0.1), 0.05, 0.8);
  for (const FloorRect& wall : wall_rects(home)) clearance.add(wall);
  for (const ThingBox& thing : thing_boxes(home.scene)) {
    if (thing.bottom_m < head_m) clearance.add(thing.base);
  }
  return clearance;
}

}  // namespace panoptic
