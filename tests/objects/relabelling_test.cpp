// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/relabelling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

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

// Round by round over all pairs; a round sees only what the rounds before it filled.
std::vector<LabelSlot> naive_fill(const SurfaceVoxels& surface, std::set<std::uint32_t> holes) {
  std::vector<LabelSlot> labels = labels_of(surface);
  for (bool progress = true; progress;) {
    std::map<std::uint32_t, LabelSlot> filled;
    for (const std::uint32_t hole : holes) {
      std::map<LabelSlot, int> counts;
      for (std::uint32_t i = 0; i < surface.size(); ++i) {
        if (!holes.contains(i) && touch(surface[hole], surface[i])) ++counts[labels[i]];
      }
      int most = 0;
      for (const auto& [label, count] : counts) {
        if (count > most) filled[hole] = label;
        most = std::max(most, count);
      }
    }
    for (const auto& [hole, label] : filled) {
      labels[hole] = label;
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
  fill_from_neighbours(std::move(holes), surface);
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
    const std::vector<LabelSlot> expected = naive_fill(surface, {holes.begin(), holes.end()});
    std::shuffle(holes.begin(), holes.end(), random);
    fill_from_neighbours(holes, surface);
    EXPECT_EQ(labels_of(surface), expected);
  }
}

TEST(Filling, GoesFromTheRimInwardsAndMeetsInTheMiddle) {
  EXPECT_EQ(filled_line({9, 5, 5, 5, 5, 7}, {1, 2, 3, 4}), (std::vector{pid(9), pid(9), pid(9), pid(7), pid(7), pid(7)}));
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
