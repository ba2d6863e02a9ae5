// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/meshing/mesher.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <random>
#include <set>

#include "panoptic/fusion/integrator.h"
#include "panoptic/meshing/marching_cubes_table.h"
#include "panoptic/surface.h"
#include "tests/block_planes.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

// How often each undirected edge is used, and whether any directed edge is used twice.
struct EdgeUse {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
  bool directed_twice = false;
};

EdgeUse edge_use(const Mesh& mesh) {
  EdgeUse use;
  std::set<std::pair<std::uint32_t, std::uint32_t>> directed;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k];
      const std::uint32_t b = t[(k + 1) % 3];
      use.directed_twice |= !directed.insert({a, b}).second;
      use.count[std::minmax(a, b)]++;
    }
  }
  return use;
}

bool closed_and_two_manifold(const Mesh& mesh) {
  const EdgeUse use = edge_use(mesh);
  return !use.directed_twice && std::all_of(use.count.begin(), use.count.end(), [](const auto& e) { return e.second == 2; });
}

// A ball seen from the sides, edges and corners of a cube around it.
PanopticMap empty_map() { return {MapOptions{}, test::test_labels()}; }

PanopticMap fused_ball(double radius) {
  PanopticMap map = empty_map();
  Integrator integrator({}, map.voxels);
  Registration registration({});
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vec3d eye = Vec3d(x, y, z).normalized() * 1.7 + Vec3d(0.011, 0.017, 0.005);
        const Frame frame = test::render(test::sphere({0.011, 0.017, 0.005}, radius), test::small_camera(320, 240),
                                         test::look_at(eye, {0.011, 0.017, 0.005}));
        const RegisteredFrame& registered = registration.apply(frame, {});
        integrator.integrate(frame, registered, std::vector<LabelSlot>(registered.depth.size(), LabelSlot{1}), map.voxels);
      }
    }
  }
  return map;
}

TEST(MarchingCubesTable, EveryPatternIsBoundedOnlyOnTheFacesOfItsCell) {
  for (unsigned pattern = 0; pattern < 256; ++pattern) {
    std::set<std::pair<int, int>> open;
    for (const CellTriangle& t : cell_triangles()[pattern]) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::pair<int, int> edge{t[k], t[(k + 1) % 3]};
        if (open.erase({edge.second, edge.first}) == 0) {
          EXPECT_TRUE(open.insert(edge).second);
        }
      }
      for (const std::uint8_t e : t) {
        const int a = kCellEdges[e].corner;
        const int b = a + (1 << kCellEdges[e].axis);
        EXPECT_NE(pattern >> a & 1, pattern >> b & 1) << "a vertex lies where the sign changes";
      }
    }
    // Sides that are left open join two edges of one face: the two corner pairs have a coordinate in common.
    for (const auto& [from, to] : open) {
      const auto corners = [](int e) {
        return std::pair<int, int>{
            kCellEdges[static_cast<std::size_t>(e)].corner,
            kCellEdges[static_cast<std::size_t>(e)].corner + (1 << kCellEdges[static_cast<std::size_t>(e)].axis)};
      };
      const auto [a, b] = corners(from);
      const auto [c, d] = corners(to);
      const int same_low = ~(a | b | c | d) & 7;
      const int same_high = a & b & c & d;
      EXPECT_TRUE(same_low != 0 || same_high != 0) << "pattern " << pattern;
    }
  }
}

TEST(Mesher, AFusedBallIsClosedAndTwoManifoldAcrossBlocks) {
  const PanopticMap map = fused_ball(0.5);
  const Mesh mesh = surface_of(map);
  ASSERT_GT(map.voxels.block_count(), 8U);
  EXPECT_TRUE(closed_and_two_manifold(mesh));
  const auto edges = static_cast<long>(edge_use(mesh).count.size());
  EXPECT_EQ(static_cast<long>(mesh.vertices.size()) - edges + static_cast<long>(mesh.triangles.size()), 2)
      << "Euler's number of a ball";
}

TEST(Mesher, AFusedBallHasTheRightSizeAndFacesOutwards) {
  const Mesh mesh = surface_of(fused_ball(0.5));
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    const auto p = [&](std::size_t k) { return Vec3d(mesh.vertices[t[k]].position.cast<double>()); };
    volume += p(0).dot(p(1).cross(p(2))) / 6;
  }
  EXPECT_NEAR(volume, 4.0 / 3 * std::numbers::pi * 0.125, 0.02);
  const Vec3f center(0.011F, 0.017F, 0.005F);
  for (const MeshVertex& v : mesh.vertices) {
    ASSERT_NEAR((v.position - center).norm(), 0.5, 0.012);
    ASSERT_NEAR(v.normal.norm(), 1, 1e-5);
    ASSERT_GT(v.normal.dot((v.position - center).normalized()), 0.8F);
    ASSERT_EQ(v.panoptic_id, PanopticId{1});
    ASSERT_EQ(v.class_id, ClassId{1});
  }
}

// Random signs give every pattern beside every other one: the hardest test for cracks and for cuts in faces.
TEST(Mesher, RandomFieldsHaveNoCracksAndNoEdgeWithFourTriangles) {
  PanopticMap map = empty_map();
  std::mt19937 random(3);
  for (int x = -1; x < 2; ++x) {
    for (int y = -1; y < 1; ++y) {
      for (int z = 0; z < 2; ++z) {
        test::BlockEdit block_edit(map.voxels.block(map.voxels.allocate({x, y, z})));
        BlockPlanes& block = *block_edit;
        block.weight.fill(1);
        for (float& d : block.distance) d = static_cast<float>(random() % 2001) / 1000.0F - 1.0003F;
      }
    }
  }
  const Mesh mesh = surface_of(map);
  const EdgeUse use = edge_use(mesh);
  EXPECT_FALSE(use.directed_twice);
  // Edges with one triangle are at the outside of the observed box only.
  const Vec3f low = Vec3f(-16, -16, 0) * 0.024F + Vec3f::Constant(0.012F);
  const Vec3f high = Vec3f(32, 16, 32) * 0.024F - Vec3f::Constant(0.012F);
  const auto at_box = [&](std::uint32_t v) {
    const Vec3f p = mesh.vertices[v].position;
    return ((p - low).cwiseAbs().minCoeff() < 1e-4F) || ((p - high).cwiseAbs().minCoeff() < 1e-4F);
  };
  for (const auto& [edge, count] : use.count) {
    ASSERT_LE(count, 2);
    if (count == 1) {
      ASSERT_TRUE(at_box(edge.first) && at_box(edge.second));
    }
  }
}

TEST(Mesher, AnUpdateOfWhatChangedEqualsAFreshMesh) {
  PanopticMap map = empty_map();
  Integrator integrator({}, map.voxels);
  Registration registration({});
  Mesher incremental({});
  for (int i = 0; i < 6; ++i) {
    const Frame frame = test::render(test::sphere({0, 0, 0}, 0.5), test::small_camera(),
                                     test::look_at({1.5 * std::cos(i * 0.3), 0.2 * i, 1.5 * std::sin(i * 0.3)}, {0, 0, 0}), i);
    const RegisteredFrame& registered = registration.apply(frame, {});
    integrator.integrate(frame, registered, std::vector<LabelSlot>(registered.depth.size(), LabelSlot{1}), map.voxels);
    incremental.update(map);
  }
  EXPECT_EQ(incremental.update(map), 0U) << "nothing changed, nothing to do";
  const Mesh a = incremental.assemble(map);
  const Mesh b = surface_of(map);
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  ASSERT_EQ(a.triangles, b.triangles);
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    ASSERT_EQ(a.vertices[i].position, b.vertices[i].position);
    ASSERT_EQ(a.vertices[i].normal, b.vertices[i].normal);
    ASSERT_EQ(a.vertices[i].color, b.vertices[i].color);
  }
}

TEST(Mesher, CellsWithAnUnobservedCornerAreLeftOut) {
  PanopticMap map = empty_map();
  VoxelBlock& block = map.voxels.block(map.voxels.allocate({0, 0, 0}));
  for (int i = 0; i < kBlockVoxels; ++i) block.set(i, {.distance = static_cast<float>(i / 256) - 7.5F, .weight = 1});
  EXPECT_EQ(surface_of(map).triangles.size(), 15U * 15U * 2U);
  block.set(voxel_offset(5, 5, 7), {});
  EXPECT_EQ(surface_of(map).triangles.size(), 15U * 15U * 2U - 4 * 2U);
}

// A block with a level surface, all of which is the object in slot 4.
void add_labelled_plane(VoxelMap& voxels) {
  test::BlockEdit block_edit(voxels.block(voxels.allocate({0, 0, 0})));
  BlockPlanes& block = *block_edit;
  block.weight.fill(1);
  block.label.fill(4);
  for (int i = 0; i < kBlockVoxels; ++i) block.distance[static_cast<std::size_t>(i)] = static_cast<float>(i / 256) - 7.5F;
}

TEST(Mesher, ObjectsGetTheClassOfTheirEvidence) {
  PanopticMap map = empty_map();
  add_labelled_plane(map.voxels);
  ObjectRegistry& objects = map.objects;
  objects.observe(*objects.create(), {ClassId{3}, 1.0F, {}}, 0);
  Mesher mesher({});
  mesher.update(map);
  const Mesh mesh = mesher.assemble(map);
  ASSERT_FALSE(mesh.vertices.empty());
  EXPECT_EQ(mesh.vertices[0].class_id, ClassId{3});
  EXPECT_EQ(mesh.vertices[0].panoptic_id, PanopticId{4});
}

// Who holds an older chunk sees the object that was there, whoever has its slot now.
TEST(Mesher, AChunkKeepsItsIdWhenTheSlotIsGivenAnew) {
  PanopticMap map = empty_map();
  add_labelled_plane(map.voxels);
  ObjectRegistry& objects = map.objects;
  while (objects.create()) continue;
  Mesher mesher({});
  mesher.update(map);
  const std::shared_ptr<const MeshChunk> before = mesher.chunks()[0];

  const auto relabel = [&](std::uint16_t label) {
    map.voxels.begin_epoch();
    test::BlockEdit(map.voxels.block(0))->label.fill(label);
    map.voxels.mark_changed(0);
  };
  relabel(1);
  std::vector<bool> in_use(kLabelSlots, true);
  in_use[4] = false;
  objects.retire_unused(in_use);
  ASSERT_EQ(objects.create(), LabelSlot{4});
  relabel(4);
  mesher.update(map);
  EXPECT_EQ(before->vertices[0].panoptic_id, PanopticId{4});
  EXPECT_EQ(mesher.chunks()[0]->vertices[0].panoptic_id, PanopticId{65535});
  EXPECT_EQ(mesher.assemble(map).vertices[0].panoptic_id, PanopticId{65535});
}

}  // namespace
}  // namespace panoptic
