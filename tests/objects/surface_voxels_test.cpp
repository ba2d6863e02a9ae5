// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/surface_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "panoptic/parallel.h"
#include "tests/block_planes.h"
#include "tests/fusion/small_maps.h"

namespace panoptic {
namespace {

using test::pid;
using test::strewn_map;

using Found = std::tuple<std::array<std::int32_t, 3>, LabelSlot>;

// The surface band by its definition: observed, and within 1.5 voxels of the surface.
std::vector<Found> naive_surface(const VoxelMap& map) {
  std::vector<Found> result;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    const BlockIndex b = map.index_of(slot);
    const BlockPlanes block = test::planes_of(map.block(slot));
    for (int z = 0; z < kBlockSide; ++z) {
      for (int y = 0; y < kBlockSide; ++y) {
        for (int x = 0; x < kBlockSide; ++x) {
          const auto v = static_cast<std::size_t>(voxel_offset(x, y, z));
          if (block.weight[v] <= 0 || std::abs(block.distance[v]) > 1.5F * map.voxel_size_m()) continue;
          result.push_back({{b.x * kBlockSide + x, b.y * kBlockSide + y, b.z * kBlockSide + z}, pid(block.label[v])});
        }
      }
    }
  }
  return result;
}

bool within(const SurfaceVoxel& a, const SurfaceVoxel& b, int reach) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::abs(a.at[axis] - b.at[axis]) > reach) return false;
  }
  return true;
}

std::vector<std::uint32_t> neighbours(const SurfaceVoxels& surface, std::uint32_t i, int reach) {
  std::vector<std::uint32_t> found;
  surface.visit_near(i, reach, [&](std::uint32_t n) { found.push_back(n); });
  std::sort(found.begin(), found.end());
  return found;
}

// Flood fill over all pairs.
std::vector<std::vector<std::uint32_t>> naive_components(const SurfaceVoxels& surface, const std::vector<std::uint32_t>& members,
                                                         int reach) {
  std::set<std::uint32_t> left(members.begin(), members.end());
  std::vector<std::vector<std::uint32_t>> result;
  while (!left.empty()) {
    std::vector<std::uint32_t> component = {*left.begin()};
    left.erase(left.begin());
    for (std::size_t next = 0; next < component.size(); ++next) {
      for (auto it = left.begin(); it != left.end();) {
        const bool near = within(surface[component[next]], surface[*it], reach);
        if (near) component.push_back(*it);
        it = near ? left.erase(it) : std::next(it);
      }
    }
    std::sort(component.begin(), component.end());
    result.push_back(component);
  }
  return result;
}

TEST(SurfaceVoxels, AreTheObservedVoxelsNearTheSurfaceInOrder) {
  const VoxelMap map = strewn_map(0.1, 50, 1);
  const SurfaceVoxels surface(map);
  const std::vector<Found> expected = naive_surface(map);
  ASSERT_EQ(surface.size(), expected.size());
  ASSERT_GT(surface.size(), 1000U);
  for (std::uint32_t i = 0; i < surface.size(); ++i) {
    const SurfaceVoxel& voxel = surface[i];
    ASSERT_EQ(Found(voxel.at, voxel.label), expected[i]);
    EXPECT_EQ(map.block(voxel.slot).label(voxel.voxel), number(voxel.label));
  }
}

TEST(SurfaceVoxels, NeighboursAcrossBlockBordersAreThoseOfASearchThroughAll) {
  const VoxelMap map = strewn_map(0.02, 5, 2);
  const SurfaceVoxels surface(map);
  for (const int reach : {0, 1, 3, 15}) {
    std::size_t across = 0;
    for (std::uint32_t i = 0; i < surface.size(); i += 3) {
      std::vector<std::uint32_t> expected;
      for (std::uint32_t j = 0; j < surface.size(); ++j) {
        if (within(surface[i], surface[j], reach)) expected.push_back(j);
      }
      ASSERT_EQ(neighbours(surface, i, reach), expected) << i << " reach " << reach;
      across += static_cast<std::size_t>(
          std::count_if(expected.begin(), expected.end(), [&](auto j) { return surface[j].slot != surface[i].slot; }));
    }
    EXPECT_EQ(across > 0, reach > 0);
  }
}

TEST(SurfaceVoxels, ComponentsAreThoseOfAFloodFillOverAllPairs) {
  for (const std::uint64_t seed : {3U, 4U}) {
    const VoxelMap map = strewn_map(0.03, 2, seed);
    const SurfaceVoxels surface(map);
    for (const auto& [label, members] : surface.by_label()) {
      for (const int reach : {1, 2}) {
        const auto components = surface.components(members, reach);
        EXPECT_EQ(components, naive_components(surface, members, reach));
        EXPECT_GT(components.size(), 1U);
        EXPECT_LT(components.size(), members.size());
      }
    }
  }
}

TEST(SurfaceVoxels, ComponentsDoNotDependOnTheOrderOfTheirMembers) {
  const VoxelMap map = strewn_map(0.03, 2, 5);
  const SurfaceVoxels surface(map);
  std::vector<std::uint32_t> members = surface.by_label().at(pid(1));
  const auto expected = surface.components(members, 2);
  std::shuffle(members.begin(), members.end(), std::mt19937_64(1));
  EXPECT_EQ(surface.components(members, 2), expected);
  EXPECT_TRUE(surface.components({}, 2).empty());
}

TEST(SurfaceVoxels, ByLabelListsEveryVoxelOnce) {
  const VoxelMap map = strewn_map(0.1, 60000, 6);
  SurfaceVoxels surface(map);
  surface.relabel(3, pid(60001));
  VoxelsByLabel expected;
  for (std::uint32_t i = 0; i < surface.size(); ++i) expected[surface[i].label].push_back(i);
  EXPECT_EQ(surface.by_label(), expected);
  EXPECT_EQ(surface.by_label().at(pid(60001)), std::vector<std::uint32_t>{3});
}

TEST(SurfaceVoxels, WritesOnlyLabelsThatChangedAndMarksTheirBlocks) {
  VoxelMap map = strewn_map(0.1, 5, 7);
  FrameVotes votes;
  SurfaceVoxels surface(map);
  const std::uint64_t before = map.epoch();
  const std::uint64_t hash = map.hash();
  map.begin_epoch();
  EXPECT_EQ(surface.write_labels(map, votes), 0U);
  EXPECT_TRUE(map.changed_since(before).empty());
  std::set<Slot> touched;
  std::size_t changed = 0;
  for (std::uint32_t i = 0; i < 200; i += 7, ++changed) {
    surface.relabel(i, pid(77));
    touched.insert(surface[i].slot);
  }
  EXPECT_EQ(map.hash(), hash) << "the snapshot changes, not the map";
  EXPECT_EQ(surface.write_labels(map, votes), changed);
  EXPECT_EQ(map.changed_since(before), std::vector<Slot>(touched.begin(), touched.end()));
  const SurfaceVoxels again(map);
  for (std::uint32_t i = 0; i < again.size(); ++i) {
    EXPECT_EQ(again[i].label, surface[i].label);
    EXPECT_EQ(map.block(again[i].slot).label_weight(again[i].voxel), 2) << "weights stay";
  }
}

std::vector<Found> found_in(const SurfaceVoxels& surface) {
  std::vector<Found> result;
  for (std::uint32_t i = 0; i < surface.size(); ++i) result.emplace_back(surface[i].at, surface[i].label);
  return result;
}

TEST(SurfaceVoxels, AfterAnUpdateAreAsIfMadeAnew) {
  VoxelMap map = strewn_map(0.05, 5, 9);
  FrameVotes votes;
  SurfaceVoxels surface(map);
  std::mt19937_64 random(3);
  for (int round = 0; round < 4; ++round) {
    map.begin_epoch();
    for (std::uint32_t i = 0; i < 50; ++i) surface.relabel(i * 7, pid(9 + round));
    surface.write_labels(map, votes);
    const Slot slot = round == 2 ? map.allocate({2, 1, 0}) : static_cast<Slot>(random() % map.block_count());
    for (int n = 0; n < 100; ++n) {
      const std::size_t v = random() % kBlockVoxels;
      map.block(slot).set(
          static_cast<int>(v),
          {.distance = static_cast<float>(n % 2) * map.truncation_m(), .weight = static_cast<float>(n % 3), .label = 3});
    }
    map.mark_changed(slot);
    surface.update(map);
    const SurfaceVoxels anew(map);
    EXPECT_EQ(found_in(surface), found_in(anew));
    for (std::uint32_t i = 0; i < surface.size(); i += 11) ASSERT_EQ(neighbours(surface, i, 2), neighbours(anew, i, 2));
  }
}

TEST(SurfaceVoxels, UpdatedWithAnotherMapAreThoseOfThatMap) {
  const VoxelMap first = strewn_map(0.05, 5, 10);
  const VoxelMap second = strewn_map(0.05, 5, 11);
  SurfaceVoxels surface(first);
  surface.update(second);
  EXPECT_EQ(found_in(surface), naive_surface(second));
}

TEST(SurfaceVoxels, AreTheSameAtAnyThreadCount) {
  const VoxelMap map = strewn_map(0.1, 50, 8);
  const auto labels_and_places = [&](int threads) {
    set_thread_count(threads);
    const SurfaceVoxels surface(map);
    set_thread_count(0);
    return found_in(surface);
  };
  EXPECT_EQ(labels_and_places(1), labels_and_places(2));
}

TEST(SurfaceVoxels, OfAnEmptyMapAreNone) {
  VoxelMap map{MapOptions{}};
  FrameVotes votes;
  EXPECT_EQ(SurfaceVoxels(map).size(), 0U);
  EXPECT_TRUE(SurfaceVoxels(map).by_label().empty());
  map.allocate({0, 0, 0});
  EXPECT_EQ(SurfaceVoxels(map).size(), 0U) << "nothing was observed";
  EXPECT_EQ(SurfaceVoxels(map).write_labels(map, votes), 0U);
}

}  // namespace
}  // namespace panoptic
