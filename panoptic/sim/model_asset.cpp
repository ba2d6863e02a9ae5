// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/model_asset.h"

namespace panoptic {

void fit_to_size(SceneModel& model, int quarter_turns, const Vec3f& size_m) {
  for (int turn = 0; turn < quarter_turns; ++turn) {
    for (Vec3f& p : model.positions) p = Vec3f(-p.y(), p.x(), p.z());
  }
  Eigen::AlignedBox3f box;
  for (const Vec3f& p : model.positions) box.extend(p);
  if (box.isEmpty()) return;
  const Vec3f extent = box.sizes();
  Vec3f scale = Vec3f::Ones();
  for (int axis = 0; axis < 3; ++axis) {
    if (extent[axis] > 0) scale[axis] = size_m[axis] / extent[axis];
  }
  const Vec3f origin(box.center().x(), box.center().y(), box.min().z());
  for (Vec3f& p : model.positions) p = (p - origin).cwiseProduct(scale);
}

std::uint32_t append_asset(const ModelAsset& asset, Scene& scene) {
  const auto first_material = static_cast<std::uint32_t>(scene.materials.size());
  const auto first_texture = static_cast<std::int32_t>(scene.textures.size());
  for (Material material : asset.materials) {
    if (material.texture >= 0) material.texture += first_texture;
    scene.materials.push_back(material);
  }
  scene.textures.insert(scene.textures.end(), asset.textures.begin(), asset.textures.end());
  scene.models.push_back(asset.model);
  for (std::uint32_t& material : scene.models.back().material_of) material += first_material;
  return static_cast<std::uint32_t>(scene.models.size() - 1);
}

}  // namespace panoptic
