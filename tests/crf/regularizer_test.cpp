// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/regularizer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "panoptic/parallel.h"
#include "panoptic/profile.h"
#include "tests/block_planes.h"
#include "tests/crf/crf_graphs.h"
#include "tests/objects/floor_map.h"

namespace panoptic {
namespace {

using test::floor_map;
using test::labels_of;
using test::PaintedVoxel;
using test::share;

// Two halves of a label and a colour each; a tenth of the voxels says something else, unsurely.
PaintedVoxel noisy_halves(int x, int /*y*/, std::mt19937& random) {
  const bool left = x < 40;
  const bool noisy = share(random) < 0.1F;
  const auto other = static_cast<std::uint16_t>(3 + random() % 5);
  return {noisy ? other : static_cast<std::uint16_t>(left ? 1 : 2), noisy ? 1.0F : 6.0F, left ? 60.0F : 180.0F};
}

// The number of voxels in the band that hold another label than their half.
int wrong(const VoxelMap& map, float band_voxels) {
  int count = 0;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    const BlockPlanes b = test::planes_of(map.block(slot));
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      if (b.weight[v] <= 0 || std::abs(b.distance[v]) > band_voxels * map.voxel_size_m()) continue;
      const int x = 16 * map.index_of(slot).x + static_cast<int>(v % 16);
      count += b.label[v] != (x < 40 ? 1 : 2) ? 1 : 0;
    }
  }
  return count;
}

double label_weight_sum(const VoxelMap& map) {
  double sum = 0;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    for (const float w : test::planes_of(map.block(slot)).label_weight) sum += double{w};
  }
  return sum;
}

RegularizerOptions paper() {
  RegularizerOptions o;
  o.w1 = 10;
  o.w2 = 15;
  o.band_voxels = 4;
  return o;
}

TEST(Regularizer, RemovesNoiseAndKeepsTheBorderBetweenColours) {
  for (const RegularizerOptions& options : {RegularizerOptions{}, paper()}) {
    VoxelMap map = floor_map(80, noisy_halves);
    const int before = wrong(map, options.band_voxels);
    Regularizer regularizer(options, map);
    EXPECT_GT(regularizer.run(map), 0U);
    EXPECT_LT(wrong(map, options.band_voxels), before / 50);
  }
}

TEST(Regularizer, LeavesVoxelsOutsideTheBandAlone) {
  VoxelMap map = floor_map(80, noisy_halves);
  const int far_before = wrong(map, 4) - wrong(map, 1.5F);
  Regularizer(RegularizerOptions{}, map).run(map);
  EXPECT_EQ(wrong(map, 4) - wrong(map, 1.5F), far_before);
}

TEST(Regularizer, NoLabelWeightEverGrowsHoweverOftenItRuns) {
  VoxelMap map = floor_map(80, noisy_halves);
  double weights = label_weight_sum(map);
  std::size_t first = 0;
  std::size_t last = 0;
  for (int i = 0; i < 8; ++i) {
    last = Regularizer(paper(), map).run(map);  // a new one takes everything as changed
    if (i == 0) first = last;
    EXPECT_LE(label_weight_sum(map), weights);
    weights = label_weight_sum(map);
  }
  EXPECT_LE(last, first / 500) << "labels settle";
  EXPECT_LT(wrong(map, 4), 100) << "and stay right";
}

TEST(Regularizer, RunningAgainWithoutANewVoteChangesNothing) {
  for (const RegularizerOptions& options : {RegularizerOptions{}, paper()}) {
    VoxelMap map = floor_map(64, [](int x, int y, std::mt19937& random) {
      PaintedVoxel v = noisy_halves(x, y, random);
      const bool small = x % 9 < 4 && y % 9 < 4;  // unlike what lies around
      if (small || v.label > 2) v.label = x < 40 ? 2 : 1;
      v.label_weight = 9 * share(random);
      return v;
    });
    Regularizer regularizer(options, map);
    EXPECT_GT(regularizer.run(map), 500U);
    const std::vector<std::uint16_t> once = labels_of(map);
    for (int i = 0; i < 4; ++i) {
      map.begin_epoch();
      for (Slot slot = 0; slot < map.block_count(); ++slot) map.mark_changed(slot);
      EXPECT_EQ(regularizer.run(map), 0U);
    }
    EXPECT_EQ(labels_of(map), once);
  }
}

TEST(Regularizer, AVoxelGetsItsVoteBackWhenItsSurroundingsTakeItsSide) {
  VoxelMap map = floor_map(48, [](int x, int y, std::mt19937&) {
    return x == 24 && y == 24 ? PaintedVoxel{7, 4, 60} : PaintedVoxel{1, 8, 60};
  });
  Regularizer regularizer(RegularizerOptions{}, map);
  regularizer.run(map);
  const Slot slot = map.find_slot({1, 1, 0});
  const int voxel = voxel_offset(8, 8, 0);
  ASSERT_EQ(map.block(slot).label(voxel), 1);
  map.begin_epoch();  // frames see something large there, but not the voxel itself
  for (Slot s = 0; s < map.block_count(); ++s) {
    for (int v = 0; v < kBlockVoxels; ++v) {
      if (s != slot || v != voxel) map.block(s).set_label(v, 7);
    }
    map.mark_changed(s);
  }
  regularizer.run(map);
  EXPECT_EQ(map.block(slot).label(voxel), 7);
  EXPECT_EQ(map.block(slot).label_weight(voxel), 4) << "as the frames left it";
}

TEST(Regularizer, AnObjectOfItsOwnColourOutlivesManyRuns) {
  const auto book = [](int x, int y) { return x >= 20 && x < 28 && y >= 20 && y < 26; };
  VoxelMap map = floor_map(64, [&](int x, int y, std::mt19937&) {
    return book(x, y) ? PaintedVoxel{9, 7, 200} : PaintedVoxel{1, 7, 60};
  });
  for (int i = 0; i < 10; ++i) Regularizer(RegularizerOptions{}, map).run(map);
  int kept = 0;
  for (int z = -1; z < 1; ++z) {
    for (int y = 20; y < 26; ++y) {
      for (int x = 20; x < 28; ++x) {
        const VoxelBlock* block = map.find({x >> 4, y >> 4, z >> 4});
        kept += block->label(voxel_offset(x & 15, y & 15, z & 15)) == 9 ? 1 : 0;
      }
    }
  }
  EXPECT_GE(kept, 90) << "of 96";
}

TEST(Regularizer, OneContraryFrameTurnsBackAVoxelThatWasFlippedWithoutKnowledge) {
  VoxelMap map = floor_map(48, [](int x, int y, std::mt19937&) {
    return x == 24 && y == 24 ? PaintedVoxel{7, 0, 60} : PaintedVoxel{1, 8, 60};
  });
  Regularizer(RegularizerOptions{}, map).run(map);
  const VoxelBlock* block = map.find({1, 1, 0});
  const int voxel = voxel_offset(8, 8, 0);
  EXPECT_EQ(block->label(voxel), 1);
  EXPECT_EQ(block->label_weight(voxel), 0) << "as unsure as before";
}

TEST(Regularizer, GivesTheSameMapAtAnyThreadCount) {
  for (const int max_blocks : {0, 6, 25}) {
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 5}) {
      set_thread_count(threads);
      RegularizerOptions options = paper();
      options.max_blocks = max_blocks;
      VoxelMap map = floor_map(100, noisy_halves);
      Regularizer(options, map).run(map);
      hashes.push_back(map.hash());
    }
    set_thread_count(0);
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
  }
}

TEST(Regularizer, TheBordersOfTilesDoNotShow) {
  const auto labels_after = [](int max_blocks) {
    RegularizerOptions options = paper();
    options.max_blocks = max_blocks;
    VoxelMap map = floor_map(100, noisy_halves);
    Regularizer(options, map).run(map);
    std::vector<std::uint16_t> labels;
    for (Slot s = 0; s < map.block_count(); ++s) {
      const BlockPlanes planes = test::planes_of(map.block(s));
      labels.insert(labels.end(), planes.label.begin(), planes.label.end());
    }
    return labels;
  };
  const auto whole = labels_after(0);
  for (const int max_blocks : {1, 4, 25}) {
    const auto divided = labels_after(max_blocks);
    int different = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) different += whole[i] != divided[i] ? 1 : 0;
    EXPECT_LT(different, 100 * 100 * 8 / 200) << "fewer than one in 200, " << max_blocks;
  }
}

TEST(Regularizer, ASecondRunHasNothingToDoUntilABlockChanges) {
  VoxelMap map = floor_map(100, noisy_halves);
  Regularizer regularizer(RegularizerOptions{}, map);
  regularizer.run(map);
  EXPECT_TRUE(regularizer.choose(map).empty()) << "its own changes are none";
  const std::uint64_t hash = map.hash();
  EXPECT_EQ(regularizer.run(map), 0U);
  EXPECT_EQ(map.hash(), hash);
  map.begin_epoch();
  map.mark_changed(map.find_slot({0, 0, 0}));
  std::size_t blocks = 0;
  for (const auto& tile : regularizer.choose(map)) blocks += tile.size();
  EXPECT_EQ(blocks, 8U) << "the block and its neighbours";
}

TEST(Regularizer, ItsChangesAreSeenByOtherReaders) {
  VoxelMap map = floor_map(48, noisy_halves);
  const std::uint64_t seen = map.epoch();
  Regularizer(RegularizerOptions{}, map).run(map);
  EXPECT_FALSE(map.changed_since(seen).empty());
}

TEST(Regularizer, AVoxelThatAFrameChangedMeanwhileIsNotWrittenAndItsBlockStaysDue) {
  VoxelMap map = floor_map(48, noisy_halves);
  Regularizer regularizer(RegularizerOptions{}, map);
  const auto tiles = regularizer.choose(map);
  ASSERT_EQ(tiles.size(), 1U);
  const TileChanges changes = regularizer.solve(regularizer.gather(map, tiles[0]));
  ASSERT_GT(changes.changes.size(), 10U);
  const CoreVoxel changed = changes.changes[3].before;
  map.begin_epoch();  // a frame comes
  test::BlockEdit(map.block(changed.slot))->weight[changed.voxel] += 1;
  map.mark_changed(changed.slot);
  map.begin_epoch();
  EXPECT_EQ(regularizer.write_back(changes, map), changes.changes.size() - 1);
  EXPECT_EQ(map.block(changed.slot).label(changed.voxel), changed.held.label);
  const auto due = regularizer.choose(map);
  ASSERT_FALSE(due.empty());
}

TEST(Regularizer, OddMapsAreLeftInOrder) {
  VoxelMap empty({});
  EXPECT_EQ(Regularizer(paper(), empty).run(empty), 0U);

  VoxelMap unobserved({});
  unobserved.allocate({0, 0, 0});
  EXPECT_EQ(Regularizer(paper(), unobserved).run(unobserved), 0U);

  VoxelMap one_label = floor_map(32, [](int, int, std::mt19937&) { return PaintedVoxel{}; });
  const std::uint64_t hash = one_label.hash();
  EXPECT_EQ(Regularizer(paper(), one_label).run(one_label), 0U);
  EXPECT_EQ(one_label.hash(), hash);

  VoxelMap unsure = floor_map(32, [](int x, int y, std::mt19937&) {
    return PaintedVoxel{static_cast<std::uint16_t>((x + y) % 3), 0, 0};
  });
  Regularizer(paper(), unsure).run(unsure);
  EXPECT_EQ(label_weight_sum(unsure), 0);

  VoxelMap spoilt = floor_map(32, noisy_halves);
  {
    test::BlockEdit block(spoilt.block(0));
    block->distance[5] = std::nanf("");
    block->weight[6] = std::nanf("");
    block->label_weight[7] = 1e30F;
    block->label_weight[8] = -3;
  }
  Regularizer(paper(), spoilt).run(spoilt);
  for (int v = 0; v < kBlockVoxels; ++v) EXPECT_FALSE(std::isnan(spoilt.block(0).label_weight(v)));
}

TEST(Regularizer, ThousandsOfLabelsInATileStayWithinMemory) {
  const auto paint = [](int x, int y, std::mt19937& random) {
    return PaintedVoxel{static_cast<std::uint16_t>(1 + random() % 60000), 3, static_cast<float>((x + y) % 250)};
  };
  VoxelMap map = floor_map(80, paint);
  [[maybe_unused]] const double before = peak_rss_mb();
  RegularizerOptions options = paper();
  options.max_blocks = 0;
  Regularizer regularizer(options, map);
  const TileGraph tile = regularizer.gather(map, regularizer.choose(map)[0]);
  EXPECT_EQ(tile.ids.size(), kMostLabels);
  EXPECT_GT(tile.graph.all_labels, 20'000U);
  regularizer.run(map);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they take memory of their own
  EXPECT_LT(peak_rss_mb() - before, 250);
#endif
}

TEST(Regularizer, AMapSpreadOverKilometresNeedsNoBoxAroundIt) {
  VoxelMap map({});
  for (const BlockIndex index : {BlockIndex{-1'000'000, 0, 0}, {0, 1'000'000, 0}, {0, 0, -1'000'000}, {1'000'000, 5, 5}}) {
    test::BlockEdit block_edit(map.block(map.allocate(index)));
    BlockPlanes& block = *block_edit;
    for (std::size_t v = 0; v < 512; ++v) {
      block.weight[v] = block.vote_sum[v] = 1;
      block.label[v] = static_cast<std::uint16_t>(v % 7);
    }
  }
  RegularizerOptions options = paper();
  options.max_blocks = 0;
  EXPECT_NO_THROW(Regularizer(options, map).run(map));
}

TEST(Regularizer, GivesTheSameMapInEveryBuildAndOnEveryCpu) {
  VoxelMap map = floor_map(64, noisy_halves);
  Regularizer(paper(), map).run(map);
  EXPECT_EQ(map.hash(), 16007242324240071568U);
}

}  // namespace
}  // namespace panoptic
