// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/motion_mask.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "panoptic/parallel.h"
#include "tests/fusion/space_scenes.h"

namespace panoptic {
namespace {

using test::room;
using test::sphere;

const Vec3d kBall(0.2, 0.3, 0.4);
constexpr double kRadius_m = 0.3;

LabelSet labels_with_people() {
  std::vector<LabelClass> classes = test::test_labels().classes();
  classes.push_back({ClassId{4}, "person", true, {}, 2.5, false, true});
  return {"people", std::move(classes)};
}

// Cameras near one wall that look across the room.
Pose pose_at(int i) {
  return test::look_at({0.5 * std::sin(0.4 * i), -0.2 + 0.1 * std::cos(0.7 * i), -2}, {0.2 * std::cos(0.3 * i), 0.2, 1});
}

Frame seen(bool with_ball, int i) {
  return test::render(with_ball ? room({sphere(kBall, kRadius_m)}) : room(), test::space_camera(), pose_at(i), i);
}

// A room that was looked at for a while.
const PanopticMap& known_room() {
  static const PanopticMap kMap = [] {
    test::SeeingMap seeing(0.04F);
    for (int i = 0; i < 25; ++i) seeing.add(seen(false, i));
    return std::move(seeing.map);
  }();
  return kMap;
}

struct Taken {
  MovingSight sight;
  RegisteredFrame registered;
};

Taken take_out(const Frame& frame, const PanopticMap& map, const Segmentation& segmentation = {},
               const std::vector<MovingThing>& expected = {}, const MovingOptions& options = {}) {
  Registration registration{DepthOptions{}};
  RegisteredFrame& registered = registration.apply(frame, segmentation);
  MotionMask motion(options);
  const MovingSight sight = motion.take_out(frame, segmentation, map, expected, registered);
  return {sight, registered};
}

// Pixels of the ball, by the two scenes: what is in front of the room.
std::vector<bool> ball_pixels(int i) {
  const Frame with = seen(true, i);
  const Frame without = seen(false, i);
  std::vector<bool> ball;
  for (int v = 0; v < with.depth.height(); ++v) {
    for (int u = 0; u < with.depth.width(); ++u) ball.push_back(with.depth(u, v) < without.depth(u, v) - 0.01F);
  }
  return ball;
}

TEST(MotionMask, FindsNothingInARoomWhereNothingMoves) {
  for (int i = 0; i < 12; ++i) {
    const Taken taken = take_out(seen(false, 3 * i + 1), known_room());
    EXPECT_TRUE(taken.sight.things.empty()) << i;
    EXPECT_TRUE(taken.sight.mask.empty()) << i;
  }
}

TEST(MotionMask, FindsWhatComesIntoFreeSpaceToThePixel) {
  for (const int i : {2, 7, 11}) {
    const Taken taken = take_out(seen(true, i), known_room());
    ASSERT_EQ(taken.sight.things.size(), 1U) << i;
    EXPECT_EQ(taken.sight.things[0].class_id, ClassId::kUnknown);
    EXPECT_LT(((taken.sight.things[0].min_m + taken.sight.things[0].max_m) / 2 - kBall).norm(), 0.2);
    const std::vector<bool> ball = ball_pixels(i);
    std::size_t both = 0;
    std::size_t found = 0;
    std::size_t there = 0;
    for (std::size_t p = 0; p < ball.size(); ++p) {
      const bool moves = taken.sight.mask[p] == 255;
      both += moves && ball[p] ? 1 : 0;
      found += moves ? 1 : 0;
      there += ball[p] ? 1 : 0;
      if (ball[p]) {
        EXPECT_EQ(taken.registered.depth[p], 0) << "a pixel of the ball is left";
      }
    }
    EXPECT_GT(static_cast<double>(both), 0.97 * static_cast<double>(found));
    EXPECT_GT(static_cast<double>(both), 0.97 * static_cast<double>(there));
  }
}

TEST(MotionMask, IsTheSameAtAnyThreadCount) {
  std::vector<Taken> taken;
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    taken.push_back(take_out(seen(true, 7), known_room()));
  }
  set_thread_count(0);
  EXPECT_EQ(taken[0].sight.mask, taken[1].sight.mask);
  EXPECT_EQ(taken[0].sight.things, taken[1].sight.things);
  EXPECT_EQ(taken[0].sight.cells, taken[1].sight.cells);
  EXPECT_EQ(taken[0].registered.depth, taken[1].registered.depth);
}

TEST(MotionMask, TakesOutThingsOfMobileClassesWithWhatIsRightAroundThem) {
  const PanopticMap empty(MapOptions{}, labels_with_people());
  const Frame frame = seen(true, 7);
  const std::vector<bool> ball = ball_pixels(7);
  Segmentation segmentation{Image<std::uint16_t>(frame.depth.width(), frame.depth.height()), {{ClassId{4}, 0.9F, {}}}};
  for (std::size_t p = 0; p < ball.size(); ++p) segmentation.segment_at.data()[p] = ball[p] ? 1 : 0;
  const Taken taken = take_out(frame, empty, segmentation);
  ASSERT_EQ(taken.sight.things.size(), 1U);
  EXPECT_EQ(taken.sight.things[0].class_id, ClassId{4});
  EXPECT_TRUE(taken.sight.cells.empty()) << "a person who stays is no furniture";
  const int width = frame.depth.width();
  for (int v = 1; v + 1 < frame.depth.height(); ++v) {
    for (int u = 1; u + 1 < width; ++u) {
      const auto p = static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
      const bool beside = ball[p] || ball[p - 1] || ball[p + 1];
      if (!beside) continue;
      EXPECT_EQ(taken.registered.segment[p], RegisteredFrame::kNoSegment);
      EXPECT_EQ(taken.registered.depth[p], 0);
    }
  }
  segmentation.segments[0].is_whole_class = true;
  EXPECT_TRUE(take_out(frame, empty, segmentation).sight.things.empty()) << "a guess of a semantic network is no person";
  const MovingOptions off{.classes = false, .points = false, .objects = false};
  segmentation.segments[0].is_whole_class = false;
  EXPECT_TRUE(take_out(frame, empty, segmentation, {}, off).sight.things.empty());
}

TEST(MotionMask, FindsPeopleWhereNoNetworkLooked) {
  PanopticMap empty(MapOptions{}, labels_with_people());
  const Vec3d reach = Vec3d::Constant(kRadius_m);
  const std::vector<MovingThing> expected = {{ClassId{4}, kBall - reach, kBall + reach, 0}};
  const Taken taken = take_out(seen(true, 7), empty, {}, expected);
  ASSERT_EQ(taken.sight.things.size(), 1U);
  EXPECT_EQ(taken.sight.things[0].class_id, ClassId::kUnknown) << "no network said so in this frame";
  const std::vector<bool> ball = ball_pixels(7);
  for (std::size_t p = 0; p < ball.size(); ++p) {
    if (ball[p]) {
      EXPECT_EQ(taken.registered.depth[p], 0);
    }
  }
}

TEST(MotionMask, WhatAMaskShowsBehindAThingDoesNotMove) {
  const PanopticMap empty(MapOptions{}, labels_with_people());
  const Frame frame = seen(true, 7);
  const std::vector<bool> ball = ball_pixels(7);
  Segmentation segmentation{Image<std::uint16_t>(frame.depth.width(), frame.depth.height()), {{ClassId{4}, 0.9F, {}}}};
  constexpr int kTooFar_px = 6;
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const int from = std::max(u - kTooFar_px, 0);
      const auto row = static_cast<std::size_t>(v) * static_cast<std::size_t>(frame.depth.width());
      segmentation.segment_at(u, v) =
          ball[row + static_cast<std::size_t>(u)] || ball[row + static_cast<std::size_t>(from)] ? 1 : 0;
    }
  }
  const Taken taken = take_out(frame, empty, segmentation);
  ASSERT_EQ(taken.sight.things.size(), 1U);
  EXPECT_LT(taken.sight.things[0].max_m.z(), kBall.z() + kRadius_m) << "the wall is no part of it";
  std::size_t wrong = 0;
  std::size_t behind = 0;
  for (std::size_t p = 0; p < ball.size(); ++p) {
    if (segmentation.segment_at.data()[p] == 0) continue;
    EXPECT_EQ(taken.registered.depth[p], 0) << "nobody knows what it is";
    if (ball[p]) {
      EXPECT_EQ(taken.sight.mask[p], 255);
      continue;
    }
    ++behind;
    wrong += taken.sight.mask[p] == 255 ? 1 : 0;
  }
  EXPECT_GT(behind, 100U);
  EXPECT_LT(5 * wrong, behind) << "but right at the edge";
}

TEST(MotionMask, FindsPeopleWhomANetworkMissed) {
  PanopticMap empty(MapOptions{}, labels_with_people());
  const Vec3d reach = Vec3d::Constant(kRadius_m);
  const std::vector<MovingThing> expected = {{ClassId{4}, kBall - reach, kBall + reach, 0}};
  const Frame frame = seen(true, 7);
  Segmentation segmentation{Image<std::uint16_t>(frame.depth.width(), frame.depth.height()), {{ClassId{4}, 0.9F, {}}}};
  const Taken missed = take_out(frame, empty, segmentation, expected);
  ASSERT_EQ(missed.sight.things.size(), 1U);
  EXPECT_EQ(missed.sight.things[0].class_id, ClassId::kUnknown) << "no network said so in this frame";
  EXPECT_TRUE(missed.sight.cells.empty()) << "a person who stays is no furniture";
  const std::vector<bool> ball = ball_pixels(7);
  for (std::size_t p = 0; p < ball.size(); ++p) {
    if (ball[p]) {
      EXPECT_EQ(missed.registered.depth[p], 0);
    }
  }
  for (std::size_t p = 0; p < ball.size(); ++p) segmentation.segment_at.data()[p] = ball[p] ? 1 : 0;
  const Taken found = take_out(frame, empty, segmentation, expected);
  ASSERT_EQ(found.sight.things.size(), 1U) << "once is enough";
  EXPECT_EQ(found.sight.things[0].class_id, ClassId{4});
}

// A curtain in a draught, and one in the wind.
TEST(MotionMask, WhatSwaysByAFewCentimetresIsSurfaceAndWhatSwingsFarIsNot) {
  test::SeeingMap seeing(0.04F);
  for (int i = 0; i < 25; ++i) seeing.add(seen(true, i));
  const auto sees_motion = [&](double by_m) {
    const Vec3d swung = kBall + Vec3d(by_m, 0, 0);
    const Frame frame = test::render(room({sphere(swung, kRadius_m)}), test::space_camera(), pose_at(25), 25);
    return !take_out(frame, seeing.map).sight.things.empty();
  };
  EXPECT_FALSE(sees_motion(0));
  EXPECT_FALSE(sees_motion(0.03));
  EXPECT_FALSE(sees_motion(-0.03));
  EXPECT_TRUE(sees_motion(0.4));
}

TEST(MotionMask, IsTheWholeBallForAsLongAsItsCellsAreFree) {
  test::SeeingMap seeing(0.04F);
  int i = 0;
  for (; i < 25; ++i) seeing.add(seen(false, i));
  MotionMask motion(MovingOptions{});
  const auto see = [&](bool has_settled) {
    const Frame frame = seen(true, i++);
    RegisteredFrame& registered = seeing.registration.apply(frame, {});
    const MovingSight& sight = motion.take_out(frame, {}, seeing.map, {}, registered);
    const std::vector<CellIndex> settled = has_settled ? sight.cells : std::vector<CellIndex>();
    clear(seeing.observer.see(frame, registered, seeing.frames++, settled, seeing.map), seeing.map.voxels);
    return !sight.things.empty();
  };
  for (int n = 0; n < 60; ++n) EXPECT_TRUE(see(false)) << n;
  EXPECT_TRUE(see(true));
  EXPECT_FALSE(seeing.observer.came_up().empty());
  int longer = 0;
  while (see(true) && longer < 60) ++longer;
  EXPECT_LT(longer, 10) << "then it is furniture";
}

}  // namespace
}  // namespace panoptic
