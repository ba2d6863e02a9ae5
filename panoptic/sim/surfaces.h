// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The triangles of a scene in the world's frame, as ray casting wants them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/sim/scene.h"

namespace panoptic {

// The origin of a triangle in the scene.
struct SurfaceOrigin {
  std::uint32_t object = 0;    // index into Scene::objects
  std::uint32_t triangle = 0;  // index into the object's SceneModel::triangles
};

// Objects in the order of the scene, each with the triangles of its model in the model's order. Flattened rather than
// instanced: homes are small (some 100,000 triangles), one level of tree is faster to trace, and non-uniform scales cost
// nothing.
struct Surfaces {
  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<SurfaceOrigin> origins;  // one per triangle
};

// Throws Error if an index of the scene points nowhere or there are more than 2^30 triangles.
Surfaces flatten(const Scene& scene);

// The linear map of an object's normals (not of unit length) to the world's: the inverse transpose of its scale and rotation.
Eigen::Matrix3f world_from_object_normal(const SceneObject& object);

// The vector at length one; straight up where v is zero.
Vec3f unit(const Vec3f& v);

Vec3f world_point(const SceneObject& object, const Vec3f& model_point);

// The point of the triangle (as weights of its corners, summing to one) that is nearest to p. A triangle without area is a
// segment or a point.
Vec3d nearest_weights(const std::array<Vec3d, 3>& corners, const Vec3d& p);

}  // namespace panoptic
