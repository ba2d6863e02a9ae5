// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/free_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace panoptic {
namespace {

constexpr float kVoxel_m = 0.025F;

SpaceView at_time(std::uint64_t time) { return {Vec3d(1, 2, 3), Vec3d::UnitX(), time}; }

// One view of one cell.
void see(FreeSpaceMap& space, const CellIndex& cell, std::uint64_t time, Space as) {
  const auto floor4 = [](std::int32_t c) { return (c - (c % 4 + 4) % 4) / 4; };
  const BlockIndex block{floor4(cell[0]), floor4(cell[1]), floor4(cell[2])};
  const int n = cell[0] - 4 * block.x + 4 * (cell[1] - 4 * block.y) + 16 * (cell[2] - 4 * block.z);
  const std::uint64_t bit = std::uint64_t{1} << n;
  space.begin_view(at_time(time), time + 1);
  space.observe(block, as == Space::kFree ? bit : 0, as == Space::kOccupied ? bit : 0);
}

TEST(FreeSpaceMap, KnowsNothingAtFirst) {
  const FreeSpaceMap space(kVoxel_m);
  EXPECT_TRUE(space.empty());
  EXPECT_FLOAT_EQ(space.cell_size_m(), 0.1F);
  EXPECT_EQ(space.at({0, 0, 0}), Space::kUnknown);
  EXPECT_EQ(space.at({2'000'000'000, 0, -2'000'000'000}), Space::kUnknown);
  EXPECT_FALSE(space.bounds());
  EXPECT_EQ(space.record({5, -5, 5}), CellRecord{});
}

TEST(FreeSpaceMap, FindsTheCellAroundAPoint) {
  const FreeSpaceMap space(kVoxel_m);
  EXPECT_EQ(space.cell_around({0.05, -0.05, 0.95}), (CellIndex{0, -1, 9}));
  EXPECT_FALSE(space.cell_around({1e9, 0, 0}));
  EXPECT_FALSE(space.cell_around({std::nan(""), 0, 0}));
}

// The definition, on a few hundred cells: counts and times that are kept one by one.
TEST(FreeSpaceMap, AgreesWithItsDefinition) {
  FreeSpaceMap space(kVoxel_m);
  std::map<CellIndex, CellRecord> expected;
  std::mt19937 random(7);
  for (std::uint64_t time = 0; time < 3000; ++time) {
    const auto coordinate = [&] { return static_cast<std::int32_t>(random() % 12) - 6; };
    const CellIndex cell{coordinate(), coordinate() / 3, coordinate() / 2};
    const Space as = random() % 5 < 3 ? Space::kFree : Space::kOccupied;
    see(space, cell, time, as);
    CellRecord& record = expected[cell];
    if (as == Space::kFree) {
      record.evidence = std::min(record.evidence + 1, kMostEmpty);
      record.empty_at = time;
    } else {
      record.evidence = std::max((record.evidence > 0 ? record.evidence / 2 : record.evidence) - 2, -kMostOccupied);
      record.occupied_at = time;
    }
  }
  std::size_t visited = 0;
  space.for_each([&](const CellIndex& cell, Space as) {
    ++visited;
    ASSERT_TRUE(expected.contains(cell));
    EXPECT_EQ(space.record(cell), expected[cell]);
    EXPECT_EQ(as, expected[cell].evidence > 0 ? Space::kFree : Space::kOccupied);
    EXPECT_EQ(as, space.at(cell));
  });
  EXPECT_EQ(visited, expected.size());
  const auto bounds = space.bounds();
  ASSERT_TRUE(bounds);
  EXPECT_EQ(bounds->first[0], expected.begin()->first[0]);
  EXPECT_EQ(bounds->second[0], expected.rbegin()->first[0]);
}

TEST(FreeSpaceMap, TimesAreKeptHoweverLongItTakes) {
  FreeSpaceMap space(kVoxel_m);
  see(space, {0, 0, 0}, 0, Space::kFree);
  see(space, {1, 0, 0}, 4094, Space::kOccupied);
  EXPECT_EQ(space.frames_per_tick(), 1U);
  EXPECT_EQ(space.record({1, 0, 0}).occupied_at, 4094U);
  see(space, {2, 0, 0}, 1'000'000'000'000, Space::kFree);
  const std::uint64_t tick = space.frames_per_tick();
  EXPECT_LE(tick * 2047, 1'000'000'000'000U);
  EXPECT_EQ(space.record({0, 0, 0}).empty_at, 0U);
  EXPECT_FALSE(space.record({0, 0, 0}).occupied_at);
  EXPECT_EQ(space.record({1, 0, 0}).occupied_at, 0U) << "rounded down";
  EXPECT_EQ(space.record({2, 0, 0}).empty_at, 1'000'000'000'000 / tick * tick);
}

TEST(FreeSpaceMap, IsTheSameInWhateverOrderItsBlocksWereSeen) {
  FreeSpaceMap forwards(kVoxel_m);
  FreeSpaceMap backwards(kVoxel_m);
  forwards.begin_view(at_time(0), 1);
  backwards.begin_view(at_time(0), 1);
  for (int i = 0; i < 100; ++i) {
    forwards.observe({i % 7, i / 7, 3}, 0xFF00 + i, 0);
    const int j = 99 - i;
    backwards.observe({j % 7, j / 7, 3}, 0xFF00 + j, 0);
  }
  EXPECT_EQ(forwards.hash(), backwards.hash());
  std::vector<CellIndex> order[2];
  forwards.for_each([&](const CellIndex& cell, Space) { order[0].push_back(cell); });
  backwards.for_each([&](const CellIndex& cell, Space) { order[1].push_back(cell); });
  EXPECT_EQ(order[0], order[1]);
  backwards.observe({0, 0, 3}, 1, 0);
  EXPECT_NE(forwards.hash(), backwards.hash());
}

TEST(FreeSpaceMap, ChunksGiveTheSameMapAgain) {
  FreeSpaceMap space(kVoxel_m);
  for (int i = 0; i < 50; ++i)
    see(space, {i * 3 - 70, i, -i}, static_cast<std::uint64_t>(i), i % 3 == 0 ? Space::kOccupied : Space::kFree);
  space.set_doubt({-4, 7, 0}, {{1, 2, 4}, {1, 0, 2}});
  space.set_doubt({-4, 7, 1}, {{8, 0, 0}, {1, 0, 2}});
  FreeSpaceMap again(kVoxel_m);
  again.restore_view(*space.last_view(), space.log2_frames_per_tick());
  for (const SpaceChunk& chunk : space.changed_since(0)) {
    ASSERT_TRUE(FreeSpaceMap::is_sound(chunk));
    again.put(chunk);
  }
  EXPECT_EQ(again.hash(), space.hash());
  EXPECT_EQ(again.doubt_count(), 2U);
  EXPECT_EQ(again.changed_since(0).size(), space.changed_since(0).size()) << "what was loaded is saved again";
  EXPECT_TRUE(space.changed_since(50).empty());
  see(space, {0, 0, 0}, 60, Space::kFree);
  EXPECT_EQ(space.changed_since(50).size(), 1U);
}

TEST(FreeSpaceMap, TellsChunksThatCannotBe) {
  FreeSpaceMap space(kVoxel_m);
  see(space, {0, 0, 0}, 0, Space::kFree);
  space.set_doubt({1, 0, 0}, {{1, 0, 0}, {0, 0, 0}});
  const SpaceChunk sound = space.changed_since(0).at(0);
  EXPECT_TRUE(FreeSpaceMap::is_sound(sound));
  const auto spoilt = [&](const std::function<void(SpaceChunk&)>& spoil) {
    SpaceChunk chunk = sound;
    spoil(chunk);
    return !FreeSpaceMap::is_sound(chunk);
  };
  EXPECT_TRUE(spoilt([](SpaceChunk& c) { c.present = 3; }));
  EXPECT_TRUE(spoilt([](SpaceChunk& c) { c.index.x = 1 << 20; }));
  EXPECT_TRUE(spoilt([](SpaceChunk& c) { c.blocks[0][0] = 0x7F000001; })) << "more evidence than there can be";
  EXPECT_TRUE(spoilt([](SpaceChunk& c) { c.blocks[0][0] = 0x01000000; })) << "seen to be empty, but never";
  EXPECT_TRUE(spoilt([](SpaceChunk& c) { c.doubts[0].second.count = {}; }));
  EXPECT_TRUE(spoilt([](SpaceChunk& c) { c.doubts[0].second.seen_from_m.x() = std::nanf(""); }));
  EXPECT_TRUE(spoilt([](SpaceChunk& c) { c.doubts.push_back(c.doubts[0]); }));
  EXPECT_TRUE(spoilt([](SpaceChunk& c) { c.doubts[0].first = {99, 0, 0}; })) << "of another chunk";
}

TEST(FreeSpaceMap, ForgetsADoubtThatIsDropped) {
  FreeSpaceMap space(kVoxel_m);
  space.begin_view(at_time(0), 1);
  space.set_doubt({5, 0, 0}, {{1, 0, 0}, {0, 0, 0}});
  EXPECT_EQ(space.doubted({1, 0, 0}), 2U);
  ASSERT_NE(space.doubt({5, 0, 0}), nullptr);
  EXPECT_EQ(space.doubt({4, 0, 0}), nullptr);
  space.drop_doubt({5, 0, 0});
  EXPECT_EQ(space.doubted({1, 0, 0}), 0U);
  EXPECT_EQ(space.doubt({5, 0, 0}), nullptr);
}

TEST(FreeSpaceMap, MergingBelievesTheLaterMapWhereTheyContradictEachOther) {
  FreeSpaceMap before(kVoxel_m);
  FreeSpaceMap later(kVoxel_m);
  for (std::uint64_t t = 0; t < 9; ++t) see(before, {0, 0, 0}, t, Space::kFree);
  see(before, {1, 0, 0}, 9, Space::kOccupied);
  see(before, {2, 0, 0}, 9, Space::kFree);
  see(later, {0, 0, 0}, 3, Space::kOccupied);
  see(later, {1, 0, 0}, 4, Space::kFree);
  see(later, {2, 0, 0}, 5, Space::kFree);
  see(later, {3, 0, 0}, 6, Space::kFree);
  before.merge(later);
  EXPECT_EQ(before.at({0, 0, 0}), Space::kOccupied);
  EXPECT_EQ(before.at({1, 0, 0}), Space::kFree);
  EXPECT_EQ(before.record({2, 0, 0}), (CellRecord{2, 15, std::nullopt})) << "times of the later map follow";
  EXPECT_EQ(before.at({3, 0, 0}), Space::kFree);
  EXPECT_EQ(before.record({0, 0, 0}), (CellRecord{-2, 8, 13}));
}

}  // namespace
}  // namespace panoptic
