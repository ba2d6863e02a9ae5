// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A furnished room small enough to check by hand: 4 x 3 x 2.5 m with a window hole towards +x, a table of five boxes and a
// tilted crate that is scaled unevenly.
#pragma once

#include <cmath>
#include <string>

#include "panoptic/sim/scene.h"

namespace panoptic::test {

constexpr ClassId kWallClass{1};
constexpr ClassId kFloorClass{2};
constexpr ClassId kTableClass{7};
constexpr ClassId kWindowClass{9};
constexpr ClassId kCurtainClass{16};
constexpr ClassId kCrateClass{39};

inline void add_quad(const std::array<Vec3f, 4>& corners, std::uint32_t material, SceneModel& model) {
  const auto first = static_cast<std::uint32_t>(model.positions.size());
  const float width = (corners[1] - corners[0]).norm();
  const float height = (corners[3] - corners[0]).norm();
  model.positions.insert(model.positions.end(), corners.begin(), corners.end());
  model.uvs.insert(model.uvs.end(), {{0, 0}, {width, 0}, {width, height}, {0, height}});
  model.triangles.push_back({first, first + 1, first + 2});
  model.triangles.push_back({first, first + 2, first + 3});
  model.material_of.insert(model.material_of.end(), 2, material);
}

// Seen from outside, counter-clockwise.
inline void add_box(const Vec3f& low, const Vec3f& high, std::uint32_t material, SceneModel& model) {
  const auto at = [&](int x, int y, int z) {
    return Vec3f(x ? high.x() : low.x(), y ? high.y() : low.y(), z ? high.z() : low.z());
  };
  add_quad({at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)}, material, model);
  add_quad({at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)}, material, model);
  add_quad({at(1, 1, 0), at(0, 1, 0), at(0, 1, 1), at(1, 1, 1)}, material, model);
  add_quad({at(0, 1, 0), at(0, 0, 0), at(0, 0, 1), at(0, 1, 1)}, material, model);
  add_quad({at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)}, material, model);
  add_quad({at(0, 1, 0), at(1, 1, 0), at(1, 0, 0), at(0, 0, 0)}, material, model);
}

inline void add_object(SceneModel model, ClassId class_id, std::uint16_t instance, Scene& scene) {
  SceneObject object;
  object.model = static_cast<std::uint32_t>(scene.models.size());
  object.class_id = class_id;
  object.instance = instance;
  object.name = model.name;
  scene.models.push_back(std::move(model));
  scene.objects.push_back(object);
}

inline SceneModel walls_with_window(std::uint32_t material) {
  SceneModel walls;
  walls.name = "wall";
  add_quad({Vec3f(4, 0, 0), Vec3f(0, 0, 0), Vec3f(0, 0, 2.5F), Vec3f(4, 0, 2.5F)}, material, walls);
  add_quad({Vec3f(0, 0, 0), Vec3f(0, 3, 0), Vec3f(0, 3, 2.5F), Vec3f(0, 0, 2.5F)}, material, walls);
  add_quad({Vec3f(0, 3, 0), Vec3f(4, 3, 0), Vec3f(4, 3, 2.5F), Vec3f(0, 3, 2.5F)}, material, walls);
  add_quad({Vec3f(4, 3, 0), Vec3f(4, 0, 0), Vec3f(4, 0, 0.9F), Vec3f(4, 3, 0.9F)}, material, walls);
  add_quad({Vec3f(4, 3, 2.1F), Vec3f(4, 0, 2.1F), Vec3f(4, 0, 2.5F), Vec3f(4, 3, 2.5F)}, material, walls);
  add_quad({Vec3f(4, 3, 0.9F), Vec3f(4, 2.2F, 0.9F), Vec3f(4, 2.2F, 2.1F), Vec3f(4, 3, 2.1F)}, material, walls);
  add_quad({Vec3f(4, 0.8F, 0.9F), Vec3f(4, 0, 0.9F), Vec3f(4, 0, 2.1F), Vec3f(4, 0.8F, 2.1F)}, material, walls);
  return walls;
}

inline SceneModel table(std::uint32_t material) {
  SceneModel model;
  model.name = "table";
  add_box({-0.6F, -0.4F, 0.7F}, {0.6F, 0.4F, 0.74F}, material, model);
  for (const float x : {-0.55F, 0.5F}) {
    for (const float y : {-0.35F, 0.3F}) add_box({x, y, 0}, {x + 0.05F, y + 0.05F, 0.7F}, material, model);
  }
  return model;
}

inline Image<Rgb> checkers(const Rgb& a, const Rgb& b) {
  Image<Rgb> image(64, 64);
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 64; ++u) image(u, v) = (u / 16 + v / 16) % 2 == 0 ? a : b;
  }
  return image;
}

inline Scene box_room() {
  Scene scene;
  scene.textures = {checkers({150, 100, 60}, {120, 80, 50})};
  scene.materials = {{{230, 225, 215}, -1}, {{255, 255, 255}, 0}, {{160, 60, 40}, -1}, {{30, 30, 34}, -1}};
  add_object(walls_with_window(0), kWallClass, 0, scene);
  SceneModel floor;
  floor.name = "floor";
  add_quad({Vec3f(0, 0, 0), Vec3f(4, 0, 0), Vec3f(4, 3, 0), Vec3f(0, 3, 0)}, 1, floor);
  add_object(floor, kFloorClass, 0, scene);
  SceneModel ceiling;
  ceiling.name = "ceiling";
  add_quad({Vec3f(0, 3, 2.5F), Vec3f(4, 3, 2.5F), Vec3f(4, 0, 2.5F), Vec3f(0, 0, 2.5F)}, 0, ceiling);
  add_object(ceiling, ClassId::kUnknown, 0, scene);
  add_object(table(2), kTableClass, 1, scene);
  scene.objects.back().world_from_object.translation() = Vec3d(1.2, 1.5, 0);
  SceneModel crate;
  crate.name = "crate";
  add_box({-0.5F, -0.5F, 0}, {0.5F, 0.5F, 1}, 3, crate);
  add_object(crate, kCrateClass, 2, scene);
  SceneObject& tilted = scene.objects.back();
  tilted.world_from_object.translation() = Vec3d(2.6, 2.1, 0.2);
  tilted.world_from_object.linear() = Eigen::AngleAxisd(0.5, Vec3d(0.3, 0.2, 1).normalized()).toRotationMatrix();
  tilted.scale = Vec3f(0.6F, 0.4F, 0.8F);
  scene.lamps = {{Vec3f(2, 1.5F, 2.35F), Vec3f(1.6F, 1.5F, 1.3F)}};
  scene.towards_sun = Vec3f(0.8F, 0.1F, 0.45F);
  return scene;
}

inline Camera small_camera() { return {160, 120, 144.5, 144.5, 79.5, 59.5}; }

// At `eye`, looking at `target`, upright.
inline Pose looking(const Vec3d& eye, const Vec3d& target) {
  Pose pose = Pose::Identity();
  const Vec3d forward = (target - eye).normalized();
  const Vec3d right = forward.cross(Vec3d::UnitZ()).normalized();
  pose.linear().col(0) = right;
  pose.linear().col(1) = forward.cross(right);
  pose.linear().col(2) = forward;
  pose.translation() = eye;
  return pose;
}

}  // namespace panoptic::test
