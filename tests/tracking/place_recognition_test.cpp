// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Features, the motion that they agree on, and keyframes found by them.
#include <gtest/gtest.h>

#include "panoptic/tracking/keyframes.h"
#include "panoptic/tracking/rigid_fit.h"
#include "tests/tracking/painted_room.h"

namespace panoptic {
namespace {

constexpr DepthLimits kRange{0.1F, 8};

std::vector<Feature> features_of(const Frame& frame) {
  return find_features(frame, grey_pyramid(frame.color, frame.color_camera), kRange);
}

Keyframe keyframe_of(const Frame& frame) {
  const std::vector<GreyLevel> pyramid = grey_pyramid(frame.color, frame.color_camera);
  return {frame.index, grey_reference(frame, pyramid, kRange), find_features(frame, pyramid, kRange)};
}

TEST(Features, DistanceCountsBits) {
  EXPECT_EQ(distance({0, 0, 0, 0}, {1, 0, 3, 0}), 3);
  EXPECT_EQ(distance({~0ULL, 5, 6, 7}, {0, 5, 6, 7}), 64);
}

TEST(Features, AreFoundAgainFromElsewhere) {
  const Frame a = test::room_frame(0, 60);
  const Frame b = test::room_frame(3, 60);
  const std::vector<Feature> of_a = features_of(a);
  const std::vector<Feature> of_b = features_of(b);
  ASSERT_GT(of_a.size(), 100U);
  const std::vector<FeatureMatch> matches = match(of_a, of_b);
  ASSERT_GT(matches.size(), 40U);
  std::size_t right = 0;
  for (const FeatureMatch& m : matches) {
    const Vec3d in_a = a.world_from_camera * of_a[m.a].in_camera.cast<double>();
    const Vec3d in_b = b.world_from_camera * of_b[m.b].in_camera.cast<double>();
    right += (in_a - in_b).norm() < 0.03 ? 1 : 0;
  }
  EXPECT_GT(right * 10, matches.size() * 8);
}

TEST(Features, ABareImageHasNone) {
  Frame frame = test::render(test::bare_wall(), test::room_camera(), test::look_at({0, 0, 0}, {0, 0, 2}));
  frame.color = Image<Rgb>(320, 240, {90, 90, 90});
  EXPECT_TRUE(features_of(frame).empty());
  EXPECT_TRUE(match({}, features_of(test::room_frame(0, 60))).empty());
}

TEST(RigidFit, FindsTheMotionAmongWrongMatches) {
  Vector6d motion;
  motion << 0.4, -0.2, 0.1, 0.3, -0.2, 0.5;
  const Pose a_from_b = moved_by(motion);
  std::vector<Feature> a;
  std::vector<Feature> b;
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < 60; ++i) {
    const Vec3d p(std::sin(1.3 * static_cast<double>(i)), std::cos(2.1 * static_cast<double>(i)),
                  2 + std::sin(0.7 * static_cast<double>(i)));
    b.push_back({p.cast<float>(), {}});
    const Vec3d q = i % 3 == 0 ? Vec3d(p + Vec3d(0.5, -0.3, 0.4)) : Vec3d(a_from_b * p);
    a.push_back({q.cast<float>(), {}});
    matches.push_back({i, i});
  }
  const RigidFit fit = fit_rigid(a, b, matches);
  EXPECT_EQ(fit.inliers, 40U);
  EXPECT_LT((fit.a_from_b.matrix() - a_from_b.matrix()).norm(), 1e-4);
  EXPECT_EQ(fit_rigid(a, b, {matches[1], matches[2]}).inliers, 0U);
}

TEST(Recognition, FindsTheKeyframeAndWhereTheFrameStands) {
  std::vector<Keyframe> keyframes;
  for (const int n : {0, 15, 30, 45}) keyframes.push_back(keyframe_of(test::room_frame(n, 60)));
  const Frame frame = test::room_frame(17, 60);
  const std::vector<GreyLevel> pyramid = grey_pyramid(frame.color, frame.color_camera);
  const std::vector<Feature> features = find_features(frame, pyramid, kRange);
  const auto found = recognise_among({frame, pyramid, features, kRange}, keyframes, keyframes.size(), 1);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.front().keyframe, 1U);
  const Pose expected = test::room_pose(15, 60).inverse() * test::room_pose(17, 60);
  const PoseDifference d = difference(found.front().keyframe_from_frame, expected);
  EXPECT_LT(d.distance_m, 0.01);
  EXPECT_LT(d.angle_rad, 0.01);
}

TEST(Recognition, AnotherPlaceIsNone) {
  Frame elsewhere = test::render(test::room(), test::room_camera(), test::room_pose(0, 60), 0);
  elsewhere.world_from_camera.translation() += Vec3d(7, 3, 5);  // the same shape, painted otherwise
  elsewhere = test::paint(elsewhere);
  const Frame frame = test::room_frame(1, 60);
  const std::vector<GreyLevel> pyramid = grey_pyramid(frame.color, frame.color_camera);
  const std::vector<Feature> features = find_features(frame, pyramid, kRange);
  EXPECT_TRUE(recognise_among({frame, pyramid, features, kRange}, {keyframe_of(elsewhere)}, 1, 1).empty());
}

}  // namespace
}  // namespace panoptic
