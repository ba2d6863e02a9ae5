// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One model with the materials and textures that it needs, before it joins a scene.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/sim/scene.h"

namespace panoptic {

// Indices count within the asset: SceneModel::material_of into materials, Material::texture into textures.
struct ModelAsset {
  SceneModel model;
  std::vector<Material> materials;
  std::vector<Image<Rgb>> textures;
};

// Turns the model by quarters of a turn about z (1: the front goes from -y to +x), scales its bounding box to size_m along each
// axis (an axis without extent keeps its scale), and moves it onto z = 0 with the origin below the centre of its footprint.
void fit_to_size(SceneModel& model, int quarter_turns, const Vec3f& size_m);

// Appends copies to the scene and returns the model's index in scene.models.
std::uint32_t append_asset(const ModelAsset& asset, Scene& scene);

}  // namespace panoptic
