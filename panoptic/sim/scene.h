// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A furnished home as triangles: the layout makes it, the renderer draws it. MovingHome axes: x and y along the floor, z up, the
// floor at z = 0; metres. Classes are those of the scannet20 label set; kUnknown (ceiling, window reveals) is void in the
// truth.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"
#include "panoptic/labels.h"

namespace panoptic {

struct Material {
  Rgb color{200, 200, 200};   // multiplied with the texture where there is one
  std::int32_t texture = -1;  // index into Scene::textures
};

// Triangles in the object's own frame: z up, resting on z = 0, origin below the centre of the footprint, front (the side that
// people use) towards -y.
struct SceneModel {
  std::string name;
  std::vector<Vec3f> positions;
  std::vector<Eigen::Vector2f> uvs;  // one per position; (0, 0) is the texture's top left corner, v runs down; textures repeat
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> material_of;  // per triangle, index into Scene::materials
};

struct SceneObject {
  std::uint32_t model = 0;
  ClassId class_id = ClassId::kUnknown;
  std::uint16_t instance = 0;  // which one of the things of the scene, from 1; 0 for stuff and void
  std::string name;            // "Oak chair"; for people
  Pose world_from_object = Pose::Identity();
  Vec3f scale = Vec3f::Ones();  // of the model, before the pose
};

struct Lamp {
  Vec3f position = Vec3f::Zero();
  Vec3f radiance = Vec3f::Ones();  // light at 1 m, linear RGB; falls with the squared distance
};

struct Scene {
  std::vector<SceneModel> models;
  std::vector<Material> materials;
  std::vector<Image<Rgb>> textures;
  std::vector<SceneObject> objects;
  std::vector<Lamp> lamps;
  Vec3f towards_sun{0.4F, 0.3F, 0.85F};  // comes in through the windows
};

}  // namespace panoptic
