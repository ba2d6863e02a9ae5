// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/object_support.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/block_planes.h"
#include "tests/objects/maintained_world.h"

namespace panoptic {
namespace {

using test::kChair;
using test::World;

TEST(ObjectSupport, IsTheMeanScoreTimesTheShareOfVotes) {
  World world;
  const Object& object = *world.map.objects.find(world.seen(kChair, 3, {}, 0.8F));
  EXPECT_NEAR(mean_score(object), 0.8, 1e-6);
  EXPECT_NEAR(support(object, {3, 4}), 0.6, 1e-6);
  EXPECT_EQ(support(object, {}), 0) << "nobody voted";
}

TEST(ObjectSupport, CertaintyIsThatOfOneRightDetectionInTheFramesThatAgree) {
  World world;
  const Object& object = *world.map.objects.find(world.seen(kChair, 4, {}, 0.5F));
  EXPECT_NEAR(certainty(object, {1, 1}), 1 - 0.5 * 0.5 * 0.5 * 0.5, 1e-6);
  EXPECT_NEAR(certainty(object, {1, 2}), 1 - 0.5 * 0.5, 1e-6);
  EXPECT_EQ(certainty(object, {}), 0);
  const Object& unseen = *world.map.objects.find(*world.map.objects.create());
  EXPECT_EQ(certainty(unseen, {1, 1}), 0);
  const Object& sure = *world.map.objects.find(world.seen(kChair, 1, {}, 1.0F));
  EXPECT_LT(certainty(sure, {1, 1}), 1) << "no detection is beyond doubt";
}

TEST(ObjectSupport, VotesAreThoseOfTheVoxelsForTheLabelThatTheyHoldNow) {
  World world;
  const LabelSlot chair = world.seen(kChair);
  test::add_to(world, {test::solid_box({-0.2, -0.2, 0}, {0.2, 0.2, 0.4}, chair)});
  SurfaceVoxels surface(world.map.voxels);
  std::vector<std::uint32_t> all;
  double sum = 0;
  for (std::uint32_t i = 0; i < surface.size(); ++i) {
    const auto [slot, voxel] = surface.place_of(i);
    Voxel v = world.map.voxels.block(slot).at(voxel);
    v.label_weight = 1;
    v.vote_sum = static_cast<float>(1 + i % 3);
    world.map.voxels.block(slot).set(voxel, v);
    sum += v.vote_sum;
    all.push_back(i);
  }
  const Votes votes = votes_in(world.map.voxels, surface, all);
  EXPECT_NEAR(votes.for_label, static_cast<double>(all.size()), 1e-6);
  EXPECT_NEAR(votes.all, sum, 1e-3);
  for (const std::uint32_t i : all) surface.relabel(i, LabelSlot::kUnknown);
  EXPECT_EQ(votes_in(world.map.voxels, surface, all).for_label, 0) << "nobody voted for what was written since";
}

}  // namespace
}  // namespace panoptic
