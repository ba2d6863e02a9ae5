// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::size_t kMostTriangles = std::size_t{1} << 30;

// Also what follows must not overflow: squares of lengths, and integers made of texture coordinates.
bool is_sane(float value) { return std::abs(value) < 1e6F; }

void check_model(const Scene& scene, const SceneModel& model) {
  const auto fail = [&](const char* what) { throw Error(fmt::format("the model '{}' {}", model.name, what)); };
  if (model.uvs.size() != model.positions.size()) fail("has another number of texture coordinates than of positions");
  if (model.material_of.size() != model.triangles.size()) fail("has another number of materials than of triangles");
  for (const Vec3f& position : model.positions) {
    if (!is_sane(position.x()) || !is_sane(position.y()) || !is_sane(position.z())) fail("has a corner at infinity");
  }
  for (const Eigen::Vector2f& uv : model.uvs) {
    if (!is_sane(uv.x()) || !is_sane(uv.y())) fail("has a texture coordinate at infinity");
  }
  for (const auto& triangle : model.triangles) {
    for (const std::uint32_t corner : triangle) {
      if (corner >= model.positions.size()) fail("has a triangle whose corner does not exist");
    }
  }
  for (const std::uint32_t material : model.material_of) {
    if (material >= scene.materials.size()) fail("uses a material that the scene lacks");
  }
}

void check(const Scene& scene) {
  for (const SceneModel& model : scene.models) check_model(scene, model);
  for (const Material& material : scene.materials) {
    if (material.texture < 0) continue;
    const auto texture = static_cast<std::size_t>(material.texture);
    if (texture >= scene.textures.size() || scene.textures[texture].empty()) {
      throw Error(fmt::format("a material uses texture {}, which the scene lacks", texture));
    }
  }
  std::size_t triangles = 0;
  for (const SceneObject& object : scene.objects) {
    if (object.model >= scene.models.size()) throw Error(fmt::format("the object '{}' has no model", object.name));
    triangles += scene.models[object.model].triangles.size();
  }
  if (triangles > kMostTriangles)
    throw Error(fmt::format("the scene has {} triangles, the most is {}", triangles, kMostTriangles));
}

double squared_distance_at(const std::array<Vec3d, 3>& corners, const Vec3d& weights, const Vec3d& p) {
  return (weights.x() * corners[0] + weights.y() * corners[1] + weights.z() * corners[2] - p).squaredNorm();
}

}  // namespace

Vec3f unit(const Vec3f& v) {
  const float length = v.norm();
  return length > 0 ? Vec3f(v / length) : Vec3f(Vec3f::UnitZ());
}

Vec3f world_point(const SceneObject& object, const Vec3f& model_point) {
  const Vec3d scaled = model_point.cwiseProduct(object.scale).cast<double>();
  return (object.world_from_object * scaled).cast<float>();
}

Eigen::Matrix3f world_from_object_normal(const SceneObject& object) {
  const Eigen::Vector3d inverse = object.scale.cast<double>().cwiseInverse();
  return (object.world_from_object.linear() * inverse.asDiagonal()).cast<float>();
}

Surfaces flatten(const Scene& scene) {
  check(scene);
  Surfaces surfaces;
  for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const SceneModel& model = scene.models[object.model];
    const auto first = static_cast<std::uint32_t>(surfaces.positions.size());
    for (const Vec3f& position : model.positions) surfaces.positions.push_back(world_point(object, position));
    for (std::uint32_t t = 0; t < model.triangles.size(); ++t) {
      const auto& [a, b, c] = model.triangles[t];
      surfaces.triangles.push_back({first + a, first + b, first + c});
      surfaces.origins.push_back({i, t});
    }
  }
  return surfaces;
}

Vec3d nearest_weights(const std::array<Vec3d, 3>& corners, const Vec3d& p) {
  const Vec3d edge_b = corners[1] - corners[0];
  const Vec3d edge_c = corners[2] - corners[0];
  const Vec3d normal = edge_b.cross(edge_c);
  const Vec3d to_p = p - corners[0];
  const double area2 = normal.squaredNorm();
  if (area2 > 0) {
    const double b = to_p.cross(edge_c).dot(normal) / area2;
    const double c = edge_b.cross(to_p).dot(normal) / area2;
    if (b >= 0 && c >= 0 && b + c <= 1) return {1 - b - c, b, c};
  }
  // Not above the inside: the nearest point lies on an edge.
  Vec3d best = Vec3d::UnitX();
  double best_distance = to_p.squaredNorm();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Vec3d edge = corners[j] - corners[i];
    const double length2 = edge.squaredNorm();
    const double along = length2 > 0 ? std::clamp((p - corners[i]).dot(edge) / length2, 0.0, 1.0) : 0.0;
    Vec3d weights = Vec3d::Zero();
    weights[i] = 1 - along;
    weights[j] = along;
    const double distance = squared_distance_at(corners, weights, p);
    if (distance < best_distance) {
      best_distance = distance;
      best = weights;
    }
  }
  return best;
}

}  // namespace panoptic
