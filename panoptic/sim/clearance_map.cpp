// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/clearance_map.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "panoptic/sim/floor_plan.h"

namespace panoptic {

std::vector<ThingBox> thing_boxes(const Scene& scene) {
  std::map<std::uint32_t, Eigen::AlignedBox3f> box_of;
  std::vector<ThingBox> boxes;
  for (const SceneObject& object : scene.objects) {
    if (object.instance == 0) continue;
    const auto [found, is_new] = box_of.try_emplace(object.model);
    if (is_new) {
      for (const Vec3f& position : scene.models[object.model].positions) found->second.extend(position);
    }
    if (found->second.isEmpty()) continue;
    const Vec3d low = found->second.min().cwiseProduct(object.scale).cast<double>();
    const Vec3d high = found->second.max().cwiseProduct(object.scale).cast<double>();
    const Vec3d center = object.world_from_object * Vec3d((low + high) / 2);
    ThingBox thing;
    thing.base.center = center.head<2>();
    thing.base.half_m = (high - low).head<2>() / 2;
    thing.base.axis = object.world_from_object.linear().col(0).head<2>();
    thing.bottom_m = center.z() - (high.z() - low.z()) / 2;
    thing.top_m = center.z() + (high.z() - low.z()) / 2;
    thing.instance = object.instance;
    boxes.push_back(thing);
  }
  return boxes;
}

std::vector<FloorRect> wall_rects(const Home& home) {
  std::vector<FloorRect> walls;
  for (std::uint32_t room = 0; room < home.rooms.size(); ++room) {
    for (const Side side : {Side::kWest, Side::kEast, Side::kSouth, Side::kNorth}) {
      const WallFace face = wall_face(home.rooms[room].floor, side);
      std::vector<std::pair<double, double>> gaps;
      for (const Doorway& doorway : home.doorways) {
        const Eigen::Vector2d offset = doorway.center - face.start;
        const double along_m = offset.dot(face.along);
        const bool is_here = (doorway.room_a == room || doorway.room_b == room) &&
                             std::abs(offset.dot(face.inward)) < kInnerWall_m && along_m > 0 && along_m < face.length_m;
        if (is_here) gaps.emplace_back(along_m - doorway.width_m / 2, along_m + doorway.width_m / 2);
      }
      std::sort(gaps.begin(), gaps.end());
      gaps.emplace_back(face.length_m, face.length_m);
      double done_m = 0;
      for (const auto& [low_m, high_m] : gaps) {
        walls.push_back({face.at((done_m + low_m) / 2, -kInnerWall_m / 4), {(low_m - done_m) / 2, kInnerWall_m / 4}, face.along});
        done_m = high_m;
      }
    }
  }
  return walls;
}

ClearanceMap::ClearanceMap(const Eigen::AlignedBox2d& area, double cell_m, double far_m)
    : origin_(area.min()), cell_m_(cell_m), far_m_(far_m) {
  width_ = static_cast<int>(std::ceil(area.sizes().x() / cell_m));
  height_ = static_cast<int>(std::ceil(area.sizes().y() / cell_m));
  clearance_m_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), far_m);
}

Eigen::Vector2d ClearanceMap::middle(int cell) const {
  return origin_ + Eigen::Vector2d(cell % width_ + 0.5, cell / width_ + 0.5) * cell_m_;
}

int ClearanceMap::cell_at(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d cell = (point - origin_) / cell_m_;
  const int x = std::clamp(static_cast<int>(std::floor(cell.x())), 0, width_ - 1);
  const int y = std::clamp(static_cast<int>(std::floor(cell.y())), 0, height_ - 1);
  return y * width_ + x;
}

double ClearanceMap::at(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d cell = ((point - origin_) / cell_m_).array() - 0.5;
  const double x = std::clamp(cell.x(), 0.0, width_ - 1.001);
  const double y = std::clamp(cell.y(), 0.0, height_ - 1.001);
  const int left = static_cast<int>(x);
  const int low = static_cast<int>(y);
  const int first = low * width_ + left;
  const double below = std::lerp((*this)[first], (*this)[first + 1], x - left);
  const double above = std::lerp((*this)[first + width_], (*this)[first + width_ + 1], x - left);
  return std::lerp(below, above, y - low);
}

void ClearanceMap::add(const FloorRect& obstacle) {
  const Eigen::AlignedBox2d box = bounds(grown(obstacle, far_m_));
  const int first = cell_at(box.min());
  const int last = cell_at(box.max());
  for (int y = first / width_; y <= last / width_; ++y) {
    for (int x = first % width_; x <= last % width_; ++x) {
      const int cell = y * width_ + x;
      double& clearance_m = clearance_m_[static_cast<std::size_t>(cell)];
      clearance_m = std::min(clearance_m, distance_m(obstacle, middle(cell)));
    }
  }
}

}  // namespace panoptic
