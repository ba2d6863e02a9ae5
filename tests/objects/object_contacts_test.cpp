// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/object_contacts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "panoptic/parallel.h"
#include "panoptic/profile.h"
#include "tests/block_planes.h"
#include "tests/fusion/small_maps.h"

namespace panoptic {
namespace {

using test::add_solids;
using test::pid;
using test::solid_box;
using test::strewn_map;

using Shares = std::map<std::pair<LabelSlot, LabelSlot>, double>;

Shares shares_of(const std::vector<Contact>& contacts) {
  Shares result;
  for (const Contact& c : contacts) EXPECT_TRUE(result.emplace(std::pair(c.smaller, c.larger), c.share).second) << "a pair twice";
  return result;
}

bool near(const SurfaceVoxel& a, const SurfaceVoxel& b, int reach) {
  int squares = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) squares += (a.at[axis] - b.at[axis]) * (a.at[axis] - b.at[axis]);
  return squares <= reach * reach;
}

double naive_share(const std::vector<std::uint32_t>& part, const std::vector<std::uint32_t>& whole, const SurfaceVoxels& surface,
                   int reach) {
  const auto count = std::count_if(part.begin(), part.end(), [&](std::uint32_t i) {
    return std::any_of(whole.begin(), whole.end(), [&](std::uint32_t j) { return near(surface[i], surface[j], reach); });
  });
  return static_cast<double>(count) / static_cast<double>(part.size());
}

Shares naive_contacts(const std::vector<LabelSlot>& ids, const VoxelsByLabel& voxels, const SurfaceVoxels& surface, int reach) {
  Shares result;
  for (const LabelSlot a : ids) {
    for (const LabelSlot b : ids) {
      const std::size_t size_a = voxels.at(a).size();
      const std::size_t size_b = voxels.at(b).size();
      const bool a_is_smaller = size_a < size_b || (size_a == size_b && a > b);
      if (!a_is_smaller) continue;
      const double share = naive_share(voxels.at(a), voxels.at(b), surface, reach);
      if (share > 0) result[{a, b}] = share;
    }
  }
  return result;
}

// From reach 16 on, as the header says it: the same with cells in place of voxels.
double naive_cell_share(const std::vector<std::uint32_t>& part, const std::vector<std::uint32_t>& whole,
                        const SurfaceVoxels& surface, int reach) {
  const int edge = static_cast<int>(std::ceil(reach / 15.0));
  const auto cells = std::lround(static_cast<double>(reach) / edge);
  const auto cell_of = [&](std::uint32_t i, std::size_t axis) {
    return static_cast<std::int64_t>(std::floor(static_cast<double>(surface[i].at[axis]) / edge));
  };
  const auto count = std::count_if(part.begin(), part.end(), [&](std::uint32_t i) {
    return std::any_of(whole.begin(), whole.end(), [&](std::uint32_t j) {
      std::int64_t squares = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        squares += (cell_of(i, axis) - cell_of(j, axis)) * (cell_of(i, axis) - cell_of(j, axis));
      return squares <= cells * cells;
    });
  });
  return static_cast<double>(count) / static_cast<double>(part.size());
}

void expect_highest_first(const std::vector<Contact>& contacts) {
  EXPECT_TRUE(
      std::is_sorted(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) { return a.share > b.share; }));
}

TEST(Contacts, AreThoseOfASearchThroughAllPairs) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const VoxelMap map = strewn_map(0.012, 9, seed);
    const SurfaceVoxels surface(map);
    const VoxelsByLabel voxels = surface.by_label();
    const std::vector<LabelSlot> ids = {pid(1), pid(2), pid(4), pid(5), pid(8)};
    for (const int reach : {1, 2, 3, 5}) {
      const std::vector<Contact> contacts = contacts_between(ids, voxels, surface, reach);
      EXPECT_EQ(shares_of(contacts), naive_contacts(ids, voxels, surface, reach)) << "reach " << reach;
      expect_highest_first(contacts);
      EXPECT_FALSE(contacts.empty());
    }
  }
}

// Blocks far and near, on both sides of the origin: voxels here and there, of few objects.
VoxelMap scattered_map(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  VoxelMap map{MapOptions{}};
  for (int n = 0; n < 40; ++n) {
    const auto coordinate = [&] { return static_cast<std::int32_t>(random() % 60) - 30; };
    test::BlockEdit block_edit(map.block(map.allocate({coordinate(), coordinate() / 8, coordinate() / 8})));
    BlockPlanes& block = *block_edit;
    const auto label = static_cast<std::uint16_t>(1 + random() % 4);
    for (int k = 0; k < 12; ++k) {
      const std::size_t v = random() % kBlockVoxels;
      block.weight[v] = 1;
      block.label[v] = label;
    }
  }
  return map;
}

TEST(Contacts, FarApartAreThoseOfASearchThroughAllCells) {
  const std::vector<LabelSlot> ids = {pid(1), pid(2), pid(3), pid(4)};
  std::size_t partial = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const VoxelMap map = scattered_map(seed);
    const SurfaceVoxels surface(map);
    const VoxelsByLabel voxels = surface.by_label();
    for (const int reach : {16, 17, 30, 31, 100, 251, 1000}) {
      const Shares shares = shares_of(contacts_between(ids, voxels, surface, reach));
      for (const LabelSlot a : ids) {
        for (const LabelSlot b : ids) {
          const auto size = [&](LabelSlot id) { return voxels.at(id).size(); };
          if (a == b || size(a) > size(b) || (size(a) == size(b) && a < b)) continue;
          const auto found = shares.find({a, b});
          const double share = found == shares.end() ? 0 : found->second;
          EXPECT_EQ(share, naive_cell_share(voxels.at(a), voxels.at(b), surface, reach)) << "reach " << reach;
          // A place is known to a cell along each axis, and the reach to half of one.
          const double slack = (std::sqrt(3.0) + 0.5) * std::ceil(reach / 15.0);
          EXPECT_GE(share, naive_share(voxels.at(a), voxels.at(b), surface, static_cast<int>(reach - slack) - 1));
          EXPECT_LE(share, naive_share(voxels.at(a), voxels.at(b), surface, static_cast<int>(reach + slack) + 1));
          partial += share > 0 && share < 1 ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(partial, 10U) << "the test sees the difference";
}

// Two walls, a third of a million voxels of two objects that nearly but never come near: nothing is found, and that is the
// longest search. Counted against a reach of 15 on the same map, so that it holds on any machine.
TEST(Contacts, OfAFarReachTakeNoLongerThanThoseOfANearOne) {
  VoxelMap map(MapOptions{.voxel_size_m = 0.004F});
  const auto wall = [&](std::int32_t x, std::uint16_t label) {
    for (std::int32_t n = 0; n < 14 * 14; ++n) {
      test::BlockEdit block_edit(map.block(map.allocate({x, n % 14, n / 14})));
      BlockPlanes& block = *block_edit;
      for (std::size_t v = 0; v < kBlockVoxels; v += kBlockSide) {
        block.weight[v] = 1;
        block.label[v] = label;
      }
    }
  };
  wall(0, 1);
  wall(32, 2);
  const SurfaceVoxels surface(map);
  const VoxelsByLabel voxels = surface.by_label();
  ASSERT_GT(surface.size(), 100000U);
  const std::vector<LabelSlot> ids = {pid(1), pid(2)};
  const auto seconds = [&](int reach) {
    const Stopwatch stopwatch;
    EXPECT_TRUE(contacts_between(ids, voxels, surface, reach).empty()) << "reach " << reach;
    return stopwatch.seconds();
  };
  const Stopwatch stopwatch;
  for (const std::uint32_t voxel : voxels.at(pid(1))) surface.visit_near(voxel, 15, [](std::uint32_t) {});
  const double near_s = stopwatch.seconds();
  for (const int reach : {100, 250, 450}) EXPECT_LT(seconds(reach), 4 * near_s + 0.5) << "reach " << reach;
  EXPECT_EQ(contacts_between(ids, voxels, surface, 600).size(), 1U);
}

TEST(Contacts, AreMeasuredFromTheSmallerObject) {
  VoxelMap map{MapOptions{}};
  add_solids(map,
             {solid_box({0, 0, 0}, {0.5, 0.5, 0.5}, pid(50)), solid_box({0.5, 0.2, 0.2}, {0.6, 0.3, 0.3}, pid(51)),
              solid_box({-0.6, 0, 0}, {-0.3, 0.3, 0.3}, pid(52))},
             Vec3d::Constant(-0.7), Vec3d::Constant(0.7));
  const SurfaceVoxels surface(map);
  const std::vector<LabelSlot> ids = {pid(50), pid(51), pid(52)};
  const Shares shares = shares_of(contacts_between(ids, surface.by_label(), surface, 2));
  ASSERT_EQ(shares.size(), 1U) << "the third is far away";
  const auto& [pair, share] = *shares.begin();
  EXPECT_EQ(pair, std::pair(pid(51), pid(50)));
  EXPECT_GT(share, 0.1);
  EXPECT_LT(share, 0.9);
}

// Equal sizes: the younger object is the part.
TEST(Contacts, BetweenTwinsTheYoungerIsTheSmaller) {
  VoxelMap map{MapOptions{}};
  VoxelBlock& block = map.block(map.allocate({-1, 0, 0}));
  block.set(voxel_offset(4, 0, 0), {.weight = 1, .label = 90});
  block.set(voxel_offset(5, 0, 0), {.weight = 1, .label = 80});
  const SurfaceVoxels surface(map);
  const std::vector<LabelSlot> ids = {pid(80), pid(90)};
  const std::vector<Contact> contacts = contacts_between(ids, surface.by_label(), surface, 1);
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(contacts[0].smaller, pid(90));
  EXPECT_EQ(contacts[0].larger, pid(80));
  EXPECT_EQ(contacts[0].share, 1);
}

TEST(Contacts, AreTheSameAtAnyThreadCountWithHundredsOfObjects) {
  const VoxelMap map = strewn_map(0.1, 700, 9);
  const SurfaceVoxels surface(map);
  const VoxelsByLabel voxels = surface.by_label();
  std::vector<LabelSlot> ids;
  for (const auto& [id, own] : voxels) ids.push_back(id);
  ASSERT_EQ(ids.size(), 700U);
  std::vector<std::vector<std::tuple<LabelSlot, LabelSlot, double>>> runs;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    auto& run = runs.emplace_back();
    for (const Contact& c : contacts_between(ids, voxels, surface, 3)) run.emplace_back(c.smaller, c.larger, c.share);
  }
  set_thread_count(0);
  EXPECT_FALSE(runs[0].empty());
  EXPECT_EQ(runs[0], runs[1]);
}

TEST(Contacts, OfNoObjectsAreNone) {
  const VoxelMap map = strewn_map(0.01, 3, 4);
  const SurfaceVoxels surface(map);
  EXPECT_TRUE(contacts_between({}, surface.by_label(), surface, 3).empty());
  const std::vector<LabelSlot> alone = {pid(1)};
  EXPECT_TRUE(contacts_between(alone, surface.by_label(), surface, 3).empty());
}

}  // namespace
}  // namespace panoptic
