// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/relabelling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "panoptic/objects/support_planes.h"
#include "panoptic/parallel.h"
#include "tests/block_planes.h"
#include "tests/fusion/small_maps.h"

namespace panoptic {
namespace {

using test::pid;
using test::strewn_map;

std::vector<LabelSlot> labels_of(const SurfaceVoxels& surface) {
  std::vector<LabelSlot> labels;
  for (std::uint32_t i = 0; i < surface.size(); ++i) labels.push_back(surface[i].label);
  return labels;
}

bool touch(const SurfaceVoxel& a, const SurfaceVoxel& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::abs(a.at[axis] - b.at[axis]) > 1) return false;
  }
  return true;
}

// A place of the surface in voxels, and its normal.
struct Facet {
  Vec3d place;
  Vec3d normal;
};

Facet facet_of(const VoxelMap& map, const SurfaceVoxel& v) {
  const Vec3d normal = normal_of(map, v);
  const double distance = double{map.block(v.slot).distance(v.voxel)} / double{map.voxel_size_m()};
  return {place_m(v, 1) - normal * distance, normal};
}

bool reaches(const Facet& rim, const Facet& hole) {
  const Vec3d from = hole.place - rim.place;
  if (from.cwiseAbs().maxCoeff() <= 3) return true;
  if (rim.normal.norm() == 0 || (hole.normal.norm() > 0 && hole.normal.dot(rim.normal) < 0.8)) return false;
  return std::abs(from.dot(rim.normal)) <= 1 + 0.05 * from.norm();
}

// Voxels in the order of z, y and x.
std::vector<std::uint32_t> in_order(const SurfaceVoxels& surface) {
  std::vector<std::uint32_t> all(surface.size());
  std::iota(all.begin(), all.end(), 0U);
  std::sort(all.begin(), all.end(), [&](std::uint32_t a, std::uint32_t b) {
    const auto pa = surface[a].at;
    const auto pb = surface[b].at;
    return std::tuple(pa[2], pa[1], pa[0]) < std::tuple(pb[2], pb[1], pb[0]);
  });
  return all;
}

// Round by round over all pairs; a round sees only what the rounds before it filled.
std::vector<LabelSlot> naive_fill(const VoxelMap& map, const SurfaceVoxels& surface, std::set<std::uint32_t> holes) {
  std::vector<LabelSlot> labels = labels_of(surface);
  const std::vector<std::uint32_t> all = in_order(surface);
  std::vector<Facet> rims;
  for (std::uint32_t i = 0; i < surface.size(); ++i) rims.push_back(facet_of(map, surface[i]));
  const std::vector<Facet> facets = rims;
  for (bool progress = true; progress;) {
    std::map<std::uint32_t, std::pair<LabelSlot, Facet>> filled;
    for (const std::uint32_t hole : holes) {
      std::map<LabelSlot, std::vector<std::uint32_t>> around;
      for (const std::uint32_t i : all) {
        if (!holes.contains(i) && touch(surface[hole], surface[i]) && reaches(rims[i], facets[hole]))
          around[labels[i]].push_back(i);
      }
      std::size_t most = 0;
      for (const auto& [label, neighbours] : around) {
        if (neighbours.size() > most) filled[hole] = {label, rims[neighbours.front()]};
        most = std::max(most, neighbours.size());
      }
    }
    for (const auto& [hole, fill] : filled) {
      labels[hole] = fill.first;
      rims[hole] = fill.second;
      holes.erase(hole);
    }
    progress = !filled.empty();
  }
  for (const std::uint32_t hole : holes) labels[hole] = LabelSlot::kUnknown;
  return labels;
}

// A line of voxels along x, across the border of two blocks.
VoxelMap line_of(const std::vector<int>& labels) {
  VoxelMap map{MapOptions{}};
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const int x = static_cast<int>(i) + 12;
    map.block(map.allocate({x / kBlockSide, 0, 0}))
        .set(voxel_offset(x % kBlockSide, 3, 3), {.weight = 1, .label = static_cast<std::uint16_t>(labels[i])});
  }
  return map;
}

std::vector<LabelSlot> filled_line(const std::vector<int>& labels, std::vector<std::uint32_t> holes) {
  const VoxelMap map = line_of(labels);
  SurfaceVoxels surface(map);
  fill_from_neighbours(std::move(holes), map, surface);
  return labels_of(surface);
}

TEST(Filling, EqualsANaiveFillRoundByRound) {
  std::mt19937_64 random(5);
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const VoxelMap map = strewn_map(0.04, 4, seed);
    SurfaceVoxels surface(map);
    std::vector<std::uint32_t> holes;
    for (std::uint32_t i = 0; i < surface.size(); ++i) {
      if (random() % 10 < 7) holes.push_back(i);
    }
    const std::vector<LabelSlot> expected = naive_fill(map, surface, {holes.begin(), holes.end()});
    std::shuffle(holes.begin(), holes.end(), random);
    fill_from_neighbours(holes, map, surface);
    EXPECT_EQ(labels_of(surface), expected);
  }
}

TEST(Filling, GoesFromTheRimInwardsAndMeetsInTheMiddle) {
  EXPECT_EQ(filled_line({9, 5, 5, 5, 5, 7}, {1, 2, 3, 4}), (std::vector{pid(9), pid(9), pid(9), pid(7), pid(7), pid(7)}));
}

// A floor that meets a wall; the hole is a strip of both, deeper than a border can be frayed.
TEST(Filling, FarFromTheRimGoesOnlyInItsPlane) {
  VoxelMap room{MapOptions{}};
  test::add_solids(
      room,
      {test::solid_box({-0.6, -0.6, -0.3}, {0.6, 0.6, 0}, pid(2)), test::solid_box({-0.6, 0.3, -0.3}, {0.6, 0.6, 0.7}, pid(1))},
      {-0.5, -0.5, -0.2}, {0.5, 0.5, 0.8});
  SurfaceVoxels surface(room);
  const std::vector<LabelSlot> before = labels_of(surface);
  std::vector<std::uint32_t> holes;
  for (std::uint32_t i = 0; i < surface.size(); ++i) {
    if (std::abs(place_m(surface[i], room.voxel_size_m()).x()) < 0.3) holes.push_back(i);
  }
  fill_from_neighbours(holes, room, surface);
  std::size_t wrong = 0;
  for (const std::uint32_t i : holes) wrong += surface.label(i) != before[i] && surface.label(i) != LabelSlot::kUnknown ? 1 : 0;
  EXPECT_GT(holes.size(), 2000U);
  EXPECT_LT(wrong, holes.size() / 50) << "only where wall and floor meet";
}

TEST(Filling, GivesTiesToTheLowerLabel) {
  EXPECT_EQ(filled_line({9, 5, 7}, {1}), (std::vector{pid(9), pid(7), pid(7)}));
  EXPECT_EQ(filled_line({7, 5, 9}, {1}), (std::vector{pid(7), pid(7), pid(9)}));
  EXPECT_EQ(filled_line({9, 5, 5, 5, 7}, {1, 2, 3}), (std::vector{pid(9), pid(9), pid(7), pid(7), pid(7)}));
}

TEST(Filling, LeavesHolesThatNothingSurroundsUnknown) {
  EXPECT_EQ(filled_line({8, 8, 8}, {0, 1, 2}), std::vector<LabelSlot>(3, LabelSlot::kUnknown));
  EXPECT_TRUE(filled_line({}, {}).empty());
}

TEST(Filling, TakesUnknownNeighboursForWhatTheyAre) {
  EXPECT_EQ(filled_line({0, 5, 7}, {1}), (std::vector{pid(0), pid(0), pid(7)})) << "unknown is a label, and the lower one";
}

TEST(Renaming, ChangesEveryVoxelAtOnceOnTheSurfaceOrNot) {
  VoxelMap map = strewn_map(0.05, 6, 4);
  const VoxelMap before = strewn_map(0.05, 6, 4);
  SurfaceVoxels surface(map);
  FrameVotes votes;
  Renaming renaming;
  renaming.add(pid(1), pid(2));
  renaming.add(pid(2), pid(3));  // at once: what was 1 does not go on to 3
  renaming.add(pid(5), pid(65534));
  renaming.apply(map, votes, surface);
  const std::map<int, int> expected = {{0, 0}, {1, 2}, {2, 3}, {3, 3}, {4, 4}, {5, 65534}};
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    for (int v = 0; v < kBlockVoxels; ++v) {
      ASSERT_EQ(map.block(slot).label(v), expected.at(before.block(slot).label(v)));
    }
    EXPECT_EQ(test::planes_of(map.block(slot)).label_weight, test::planes_of(before.block(slot)).label_weight);
  }
  const SurfaceVoxels fresh(map);
  EXPECT_EQ(labels_of(surface), labels_of(fresh));
}

TEST(Renaming, MarksOnlyBlocksThatHoldARenamedLabel) {
  VoxelMap map = line_of({7, 7, 7, 7, 8, 8, 8});  // four voxels in the first block
  SurfaceVoxels surface(map);
  const std::uint64_t before = map.epoch();
  map.begin_epoch();
  FrameVotes votes;
  Renaming renaming;
  renaming.apply(map, votes, surface);
  EXPECT_TRUE(map.changed_since(before).empty());
  renaming.add(pid(8), pid(9));
  renaming.apply(map, votes, surface);
  EXPECT_EQ(map.changed_since(before), std::vector<Slot>{1});
}

TEST(Renaming, IsTheSameAtAnyThreadCount) {
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    VoxelMap map = strewn_map(0.05, 60, 6);
    SurfaceVoxels surface(map);
    FrameVotes votes;
    Renaming renaming;
    for (int n = 0; n < 50; ++n) renaming.add(pid(n), pid(n / 2));
    renaming.apply(map, votes, surface);
    hashes.push_back(map.hash());
  }
  set_thread_count(0);
  EXPECT_EQ(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace panoptic
