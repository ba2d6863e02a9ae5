// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/bag_transforms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/expect_error.h"

namespace panoptic {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

PoseMessage transform(const std::string& parent, const std::string& child, double time_s, const Vec3d& position,
                      double angle = 0) {
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(angle, Vec3d::UnitZ()));
  return {{static_cast<std::int64_t>(time_s * 1e9), parent}, child, position, rotation};
}

// map -> base moves, base -> mast and mast -> camera are fixed, base -> lamp too.
TransformTree robot() {
  TransformTree tree;
  tree.add(transform("map", "base", 10, {0, 0, 0}), false);
  tree.add(transform("map", "base", 10.1, {1, 0, 0}, std::numbers::pi / 2), false);
  tree.add(transform("base", "mast", 0, {0, 0, 1}), true);
  tree.add(transform("mast", "camera", 0, {0.5, 0, 0}), true);
  tree.add(transform("base", "lamp", 3, {0, 2, 0}), false);
  tree.add(transform("base", "lamp", 4, {0, 2, 0}), false);
  tree.finish();
  return tree;
}

TEST(TransformTree, InterpolatesPositionsLinearlyAndRotationsAlongTheShortestWay) {
  const TransformTree tree = robot();
  const auto chain = tree.chain("camera", "a.bag");
  EXPECT_THAT(chain, ElementsAre("camera", "mast", "base", "map"));
  EXPECT_TRUE(tree.moves(chain));
  const auto pose = tree.pose(chain, 10.05);
  ASSERT_TRUE(pose);
  const Vec3d camera = pose->topRightCorner<3, 1>();
  // Half of the way and half of the turn: the camera is half a metre before the base, at 45 degrees.
  EXPECT_NEAR((camera - Vec3d(0.5 + 0.5 * std::sqrt(0.5), 0.5 * std::sqrt(0.5), 1)).norm(), 0, 1e-6);
}

TEST(TransformTree, HasNoPoseInAGapOrBeyondItsEnds) {
  TransformTree tree;
  for (const double time_s : {1.0, 1.1, 1.4}) tree.add(transform("map", "camera", time_s, {time_s, 0, 0}), false);
  tree.finish();
  const auto chain = tree.chain("camera", "a.bag");
  EXPECT_TRUE(tree.pose(chain, 1.05));
  EXPECT_FALSE(tree.pose(chain, 1.25)) << "0.3 s are too long to guess what lies between";
  EXPECT_FALSE(tree.pose(chain, 0.9));
  EXPECT_TRUE(tree.pose(chain, 1.41)) << "the nearest within 0.02 s";
}

TEST(TransformTree, WhatNeverChangesIsFixedAlsoWhereItIsSentAgainAndAgain) {
  const TransformTree tree = robot();
  EXPECT_FALSE(tree.moves({"lamp", "base"}));
  const auto lamp_from_camera = tree.fixed("lamp", "camera");
  ASSERT_TRUE(lamp_from_camera);
  EXPECT_NEAR((Vec3d(lamp_from_camera->topRightCorner<3, 1>()) - Vec3d(0.5, -2, 1)).norm(), 0, 1e-12);
  EXPECT_FALSE(tree.fixed("map", "camera")) << "the base moves between them";
  EXPECT_FALSE(tree.fixed("camera", "nowhere"));
}

TEST(TransformTree, RefusesTwoParentsAndCirclesByName) {
  TransformTree tree = robot();
  tree.add(transform("odom", "base", 10, {0, 0, 0}), false);
  tree.finish();
  EXPECT_THAT(test::error_of([&] { tree.chain("camera", "a.bag"); }), HasSubstr("base two parents, map and odom"));
  TransformTree circle;
  circle.add(transform("a", "b", 1, {0, 0, 0}), false);
  circle.add(transform("b", "a", 1, {0, 0, 0}), false);
  circle.finish();
  EXPECT_THAT(test::error_of([&] { circle.chain("a", "a.bag"); }), HasSubstr("circle"));
  EXPECT_TRUE(circle.fixed("a", "b"));
}

}  // namespace
}  // namespace panoptic
