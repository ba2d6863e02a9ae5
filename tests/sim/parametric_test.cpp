// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/parametric.h"

#include <gmock/gmock.h>

#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::HasSubstr;

const Vec3f kSize(0.8F, 0.4F, 1.1F);

Eigen::AlignedBox3f box_of(const SceneModel& model) {
  Eigen::AlignedBox3f box;
  for (const Vec3f& p : model.positions) box.extend(p);
  return box;
}

bool equal(const ModelAsset& a, const ModelAsset& b) {
  const auto same_material = [](const Material& x, const Material& y) { return x.color == y.color && x.texture == y.texture; };
  return a.model.positions == b.model.positions && a.model.uvs == b.model.uvs && a.model.triangles == b.model.triangles &&
         a.model.material_of == b.model.material_of && a.textures == b.textures &&
         std::equal(a.materials.begin(), a.materials.end(), b.materials.begin(), b.materials.end(), same_material);
}

TEST(Parametric, EveryShapeFillsItsSizeAndStandsOnTheFloor) {
  for (const std::string& shape : parametric_shapes()) {
    for (int variant = 0; variant < 6; ++variant) {
      const Eigen::AlignedBox3f box = box_of(make_parametric({shape, kSize, {200, 150, 100}, variant}).model);
      EXPECT_TRUE(box.sizes().isApprox(kSize, 1e-4F)) << shape << ": " << box.sizes().transpose();
      EXPECT_NEAR(box.min().z(), 0, 1e-6F) << shape;
      EXPECT_TRUE(box.center().head<2>().isZero(1e-4F)) << shape;
    }
  }
}

TEST(Parametric, EveryIndexIsInRangeAndNoTriangleIsBroken) {
  for (const std::string& shape : parametric_shapes()) {
    const ModelAsset asset = make_parametric({shape, kSize, {200, 150, 100}, 1});
    const SceneModel& model = asset.model;
    ASSERT_EQ(model.uvs.size(), model.positions.size()) << shape;
    ASSERT_EQ(model.material_of.size(), model.triangles.size()) << shape;
    EXPECT_LT(model.triangles.size(), 6000U) << shape;
    for (const auto& triangle : model.triangles) {
      for (const std::uint32_t vertex : triangle) ASSERT_LT(vertex, model.positions.size()) << shape;
    }
    for (const Vec3f& p : model.positions) ASSERT_TRUE(p.allFinite()) << shape;
    for (const std::uint32_t material : model.material_of) ASSERT_LT(material, asset.materials.size()) << shape;
    for (const Material& material : asset.materials)
      ASSERT_LT(material.texture, static_cast<std::int32_t>(asset.textures.size())) << shape;
  }
}

TEST(Parametric, TheSameShapeGivesTheSameBytesAndAnotherVariantOthers) {
  for (const std::string& shape : parametric_shapes()) {
    const ParametricShape wanted{shape, kSize, {200, 150, 100}, 2};
    EXPECT_TRUE(equal(make_parametric(wanted), make_parametric(wanted))) << shape;
  }
  for (const char* shape : {"picture", "curtain", "bookshelf", "window", "door"}) {
    EXPECT_FALSE(equal(make_parametric({shape, kSize, {90, 90, 90}, 0}), make_parametric({shape, kSize, {90, 90, 90}, 1})))
        << shape;
  }
}

TEST(Parametric, APaintingLooksTowardsTheFrontAndAWindowHasASurface) {
  for (const char* shape : {"picture", "window"}) {
    const ModelAsset asset = make_parametric({shape, {1.2F, 0.1F, 1}, {90, 90, 90}, 0});
    double textured_m2 = 0;
    for (std::size_t t = 0; t < asset.model.triangles.size(); ++t) {
      if (asset.materials[asset.model.material_of[t]].texture + 1 != static_cast<std::int32_t>(asset.textures.size())) continue;
      const auto& [a, b, c] = asset.model.triangles[t];
      const auto& p = asset.model.positions;
      const Vec3f normal = (p[b] - p[a]).cross(p[c] - p[a]);
      EXPECT_LT(normal.y(), 0) << shape;
      textured_m2 += normal.norm() / 2.0;
    }
    EXPECT_GT(textured_m2, 0.75 * 1.2) << shape;
  }
}

TEST(Parametric, ListsTheShapesIfThereIsNoneOfThatName) {
  const std::string message = error_of([] { make_parametric({"spaceship", kSize, {}, 0}); });
  EXPECT_THAT(message, HasSubstr("spaceship"));
  EXPECT_THAT(message, HasSubstr("curtain"));
}

}  // namespace
}  // namespace panoptic
