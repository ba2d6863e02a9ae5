// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/model_places.h"

#include <cmath>
#include <map>

#include "panoptic/sim/surfaces.h"

namespace panoptic {
namespace {

constexpr float kCreaseCosine = 0.75F;  // faces that meet flatter than about 40 degrees are one curved surface

using Key = std::array<float, 3>;
Key key_of(const Vec3f& v) { return {v.x(), v.y(), v.z()}; }

// Twice the area times the unit normal.
Vec3f area_normal(const SceneModel& model, const std::array<std::uint32_t, 3>& triangle) {
  const auto& [a, b, c] = triangle;
  return (model.positions[b] - model.positions[a]).cross(model.positions[c] - model.positions[a]);
}

// Numbers for equal positions: models repeat a position where texture coordinates differ.
std::vector<std::uint32_t> position_numbers(const SceneModel& model) {
  std::map<Key, std::uint32_t> number_of;
  std::vector<std::uint32_t> numbers;
  for (const Vec3f& position : model.positions) {
    numbers.push_back(number_of.emplace(key_of(position), static_cast<std::uint32_t>(number_of.size())).first->second);
  }
  return numbers;
}

}  // namespace

ModelPlaces places_of(const SceneModel& model) {
  constexpr std::size_t kMostNeighbours = 64;  // the tip of a cone with 10,000 faces needs no more
  const std::vector<std::uint32_t> number_at = position_numbers(model);
  std::vector<std::vector<std::uint32_t>> faces_at(model.positions.size());
  std::vector<Vec3f> area_normals;
  for (std::uint32_t t = 0; t < model.triangles.size(); ++t) {
    area_normals.push_back(area_normal(model, model.triangles[t]));
    for (const std::uint32_t corner : model.triangles[t]) {
      auto& faces = faces_at[number_at[corner]];
      if (faces.size() < kMostNeighbours) faces.push_back(t);
    }
  }
  ModelPlaces places;
  std::map<std::array<std::int32_t, 4>, std::uint32_t> place_of;  // position and roughly the normal
  for (std::size_t t = 0; t < model.triangles.size(); ++t) {
    const Vec3f own = unit(area_normals[t]);
    auto& normals = places.normals.emplace_back();
    auto& corner_at = places.corner_at.emplace_back();
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t number = number_at[model.triangles[t][i]];
      Vec3f sum = area_normals[t];
      for (const std::uint32_t other : faces_at[number]) {
        const float cosine = unit(area_normals[other]).dot(own);
        if (other != t && std::abs(cosine) > kCreaseCosine) sum += cosine < 0 ? Vec3f(-area_normals[other]) : area_normals[other];
      }
      normals[i] = unit(sum);
      const Eigen::Vector3i rough = (normals[i] * 8).array().round().cast<int>();
      const std::array<std::int32_t, 4> key{static_cast<std::int32_t>(number), rough.x(), rough.y(), rough.z()};
      const auto [place, is_new] = place_of.emplace(key, static_cast<std::uint32_t>(places.owners.size()));
      if (is_new) places.owners.push_back({static_cast<std::uint32_t>(t), static_cast<std::uint32_t>(i)});
      corner_at[i] = place->second;
    }
  }
  return places;
}

}  // namespace panoptic
