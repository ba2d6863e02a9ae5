// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A large map has one mesh, and none of its files is another copy of it in memory.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "panoptic/base/files.h"
#include "panoptic/outputs.h"
#include "panoptic/surface.h"
#include "tests/fresh_folder.h"
#include "tests/limits/allocation_meter.h"

namespace panoptic {
namespace {

using test::allocations_of;
using test::fresh_folder;

// A field of hills, striped by id. Every vertex has a normal.
Mesh hills(std::uint32_t side) {
  Mesh mesh;
  const LabelSet labels = load_label_set("indoor");
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      const float height = std::sin(0.1F * static_cast<float>(x)) * std::sin(0.1F * static_cast<float>(y));
      mesh.vertices.push_back({{static_cast<float>(x), static_cast<float>(y), height},
                               Vec3f::UnitZ(),
                               {1, 2, 3},
                               ClassId::kUnknown,
                               static_cast<PanopticId>(labels.first_thing() + 10 * y / side)});
    }
  }
  for (std::uint32_t y = 0; y + 1 < side; ++y) {
    for (std::uint32_t x = 0; x + 1 < side; ++x) {
      const std::uint32_t v = y * side + x;
      mesh.triangles.push_back({v, v + 1, v + side});
      mesh.triangles.push_back({v + 1, v + side + 1, v + side});
    }
  }
  return mesh;
}

std::size_t bytes_of(const Mesh& mesh) {
  return mesh.vertices.size() * sizeof(mesh.vertices[0]) + mesh.triangles.size() * sizeof(mesh.triangles[0]);
}

// A floor of so many blocks a side.
PanopticMap floor_of(int side) {
  const auto planes = std::make_unique<BlockPlanes>();
  for (int v = 0; v < kBlockVoxels; ++v) {
    const int z = v / (kBlockSide * kBlockSide);
    if (z < 6 || z > 9) continue;
    planes->distance[static_cast<std::size_t>(v)] = (static_cast<float>(z) - 7.4F) * 0.01F;
    planes->weight[static_cast<std::size_t>(v)] = 1;
  }
  PanopticMap map({}, load_label_set("indoor"));
  for (int i = 0; i < side * side; ++i) map.voxels.block(map.voxels.allocate({i % side, i / side, 0})).pack(*planes);
  return map;
}

TEST(OutputLimits, APlyFileIsWrittenInPieces) {
  const Mesh mesh = hills(500);
  const auto path = fresh_folder() / "mesh.ply";
  EXPECT_LT(allocations_of([&] { write_ply(path, mesh); }).peak, bytes_of(mesh) / 20);
  const Mesh read = read_ply(path);
  EXPECT_EQ(read.triangles, mesh.triangles);
  EXPECT_EQ(read.vertices.back().position, mesh.vertices.back().position);
}

TEST(OutputLimits, AGlbFileTakesHalfOfTheMeshInMemory) {
  const Mesh mesh = hills(500);
  const auto path = fresh_folder() / "scene.glb";
  const LabelSet labels = load_label_set("indoor");
  EXPECT_LT(allocations_of([&] { write_glb(path, mesh, labels); }).peak, bytes_of(mesh) / 2);
  EXPECT_EQ(read_file(path), glb_bytes(mesh, labels));
}

TEST(OutputLimits, TheSurfaceOfALargeMapIsNeverThereTwice) {
  const PanopticMap map = floor_of(48);
  Mesh mesh;
  const test::Allocations taken = allocations_of([&] { mesh = surface_of(map); });
  EXPECT_GT(mesh.vertices.size(), 500'000U);
  EXPECT_LT(taken.peak, bytes_of(mesh) * 3 / 2);
}

}  // namespace
}  // namespace panoptic
