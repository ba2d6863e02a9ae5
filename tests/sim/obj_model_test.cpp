// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/obj_model.h"

#include <gmock/gmock.h>

#include <set>

#include "panoptic/error.h"

namespace panoptic {
namespace {

using testing::HasSubstr;

const std::string kObj =
    "# a box without a lid\nmtllib box.mtl\r\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 2 2\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "usemtl a\nf 1/1 2/2 3/3 4/4\nusemtl b\nf 1/2 3/3 -1/4\nusemtl c\nf 1 2 3 5 4\nf 3 4 5\n";
const std::string kMtl = "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\nd 0.5\nnewmtl c\nKd 1 0 0\n";

TEST(ObjModel, SplitsPolygonsAndMergesEqualMaterials) {
  const ObjModel obj = parse_obj(kObj, kMtl, "box.obj");
  EXPECT_EQ(obj.model.triangles.size(), 7U);
  ASSERT_EQ(obj.materials.size(), 2U);
  EXPECT_EQ(obj.materials[0], (ObjMaterial{{255, 0, 0}, 1, ""}));
  EXPECT_EQ(obj.materials[1], (ObjMaterial{{0, 255, 0}, 0.5F, ""}));
  EXPECT_EQ(obj.model.material_of[0], obj.model.material_of[6]);
}

TEST(ObjModel, ACornerIsAVertexPerPairOfPositionAndTextureCoordinate) {
  const ObjModel obj = parse_obj(kObj, kMtl, "box.obj");
  std::set<std::uint32_t> quad(obj.model.triangles[0].begin(), obj.model.triangles[0].end());
  quad.insert(obj.model.triangles[1].begin(), obj.model.triangles[1].end());
  EXPECT_EQ(quad.size(), 4U);
  const auto& [a, b, c] = obj.model.triangles[2];
  EXPECT_FALSE(quad.contains(a)) << "1/2 is not 1/1";
  EXPECT_TRUE(quad.contains(b)) << "3/3 is 3/3";
  EXPECT_TRUE(obj.model.positions[c].isApprox(Vec3f(2, 2, 2))) << "-1 counts from the end";
  EXPECT_TRUE(obj.model.uvs[b].isApprox(Eigen::Vector2f(1, 0))) << "v counts from the top";
}

TEST(ObjModel, FacesOfAnUnknownMaterialAreGrey) {
  const ObjModel obj = parse_obj(kObj, "", "box.obj");
  for (const std::uint32_t material : obj.model.material_of) EXPECT_EQ(obj.materials.at(material), ObjMaterial{});
}

TEST(ObjModel, NamesTheMaterialLibrary) {
  EXPECT_EQ(material_library("mtllib chair.mtl\nv 0 0 0\n"), "chair.mtl");
  EXPECT_EQ(material_library("# mtllib no.mtl\nmtllib my chair.mtl\r\n"), "my chair.mtl");
  EXPECT_EQ(material_library("mtllib last.mtl"), "last.mtl");
  EXPECT_EQ(material_library("v 0 0 0\n"), "");
}

TEST(ObjModel, ReadsOrRefusesGeometryWithAnyByteChanged) {
  int refused = 0;
  for (std::size_t at = 0; at < kObj.size(); ++at) {
    for (const char c : {'9', '-', '/', ' ', '\n', 'f', '\0'}) {
      std::string text = kObj;
      text[at] = c;
      try {
        const ObjModel obj = parse_obj(text, kMtl, "box.obj");
        for (const Vec3f& p : obj.model.positions) ASSERT_TRUE(p.allFinite());
        for (const auto& triangle : obj.model.triangles) {
          for (const std::uint32_t vertex : triangle) ASSERT_LT(vertex, obj.model.positions.size());
        }
        for (const std::uint32_t material : obj.model.material_of) ASSERT_LT(material, obj.materials.size());
      } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("box.obj"));
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 50);
}

TEST(ObjModel, ReadsOrRefusesTextCutOffAnywhere) {
  for (std::size_t size = 0; size < kObj.size(); ++size) {
    try {
      EXPECT_LE(parse_obj(kObj.substr(0, size), kMtl.substr(0, size / 4), "box.obj").model.triangles.size(), 7U);
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("box.obj"));
    }
  }
}

}  // namespace
}  // namespace panoptic
