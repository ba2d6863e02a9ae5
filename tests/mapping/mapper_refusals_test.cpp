// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Frames, segmentations and options that a mapper refuses, because they would make a wrong map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "panoptic/error.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/map.h"
#include "panoptic/mapper.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/ball_on_floor.h"
#include "tests/mapping/least_limit.h"
#include "tests/sanitized.h"

namespace panoptic {
namespace {

using test::halves;
using test::render;
using test::small_camera;

Frame good_frame() { return render(test::ball_on_floor(), small_camera(), test::look_at({2, -0.9, 0}, {0, 0, 0})); }

TEST(Mapper, RefusesALimitBelowWhatTheFirstFrameTakesAndNamesTheLeast) {
  if (test::kSanitized) GTEST_SKIP() << "a sanitizer takes memory of its own for what is allocated";
  Options options;
  options.map.swap_folder = test::fresh_folder().string();
  const Frame frame = good_frame();
  const auto refusal_at = [&](int limit_mb) -> std::string {
    options.map.memory_limit_mb = limit_mb;
    Mapper mapper(options, test::test_labels());
    try {
      EXPECT_TRUE(mapper.add(frame, halves(small_camera())).used);
    } catch (const Error& error) {
      EXPECT_EQ(mapper.frames().used(), 0U);
      return error.what();
    }
    return "";
  };
  const std::string refusal = refusal_at(3);
  EXPECT_THAT(refusal, testing::ContainsRegex("map.memory_limit_mb = 3, .* set it to [0-9]+ at least, or 0$"));
  EXPECT_EQ(refusal_at(test::least_limit_mb(refusal)), "");
  EXPECT_NE(refusal_at(test::least_limit_mb(refusal) - 30), "");
}

TEST(Mapper, EveryKindOfBadFrameIsRejectedCountedAndLeavesTheMapAlone) {
  Mapper mapper({}, test::test_labels());
  const Frame good = good_frame();
  ASSERT_EQ(mapper.add(good, halves(small_camera())), Outcome{});
  const std::uint64_t before = mapper.map().voxels.hash();

  Frame nan_pose = good;
  nan_pose.world_from_camera.translation().x() = std::numeric_limits<double>::quiet_NaN();
  Frame infinite_pose = good;
  infinite_pose.world_from_camera.matrix().setConstant(-std::numeric_limits<double>::infinity());
  Frame sheared = good;
  sheared.world_from_camera.linear()(0, 0) += 0.5;
  Frame no_depth = good;
  no_depth.depth = Image<float>(good.depth.width(), good.depth.height());
  Frame wrong_size = good;
  wrong_size.depth = Image<float>(7, 5, 1.0F);
  Frame no_color = good;
  no_color.color = {};
  for (const Frame* bad : {&nan_pose, &infinite_pose, &sheared, &no_depth, &wrong_size, &no_color}) {
    EXPECT_FALSE(mapper.add(*bad, {}).used);
  }
  Segmentation too_small{Image<std::uint16_t>(3, 3), {}};
  EXPECT_FALSE(mapper.add(good, too_small).used);
  Segmentation dangling = halves(small_camera());
  dangling.segment_at(0, 0) = 9;
  EXPECT_FALSE(mapper.add(good, dangling).used);

  Segmentation nan_score = halves(small_camera());
  nan_score.segments[0].score = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(mapper.add(good, nan_score).used);

  EXPECT_EQ(mapper.map().voxels.hash(), before);
  EXPECT_EQ(mapper.frames().used(), 1U);
  EXPECT_EQ(mapper.frames().skipped(), 9U);
  EXPECT_EQ(mapper.frames().skipped_by_reason().at("pose is not finite"), 2U);
}

TEST(Mapper, AFarPoseAndDepthOutOfRangeAreRejected) {
  Mapper mapper({}, test::test_labels());
  Frame far = good_frame();
  far.world_from_camera.translation() = Vec3d(1e9, -1e9, 1e9);
  EXPECT_FALSE(mapper.add(far, {}).used);
  Frame wrong_scale = good_frame();
  wrong_scale.depth = Image<float>(wrong_scale.depth.width(), wrong_scale.depth.height(), 1000);
  EXPECT_NE(mapper.add(wrong_scale, {}).reason.find("depth.max_m"), std::string::npos);
  EXPECT_EQ(mapper.frames().used(), 0U);
  EXPECT_EQ(mapper.map().voxels.block_count(), 0U);
}

TEST(Mapper, OptionsThatLeaveNoDepthAreAnError) {
  Options options;
  options.depth.min_m = 9;
  EXPECT_THROW(Mapper(options, test::test_labels()), Error);
}

TEST(Mapper, OptionsOutOfTheirRangeAreAnErrorThatNamesThem) {
  const auto complaint = [](const std::function<void(Options&)>& change) {
    Options options;
    change(options);
    return test::error_of([&] { Mapper(options, test::test_labels()); });
  };
  using testing::HasSubstr;
  EXPECT_THAT(complaint([](Options& o) { o.objects.every_frames = 0; }), HasSubstr("objects.every_frames"));
  EXPECT_THAT(complaint([](Options& o) { o.integrator.method = "Raycast"; }), HasSubstr("projective, raycast"));
  EXPECT_THAT(complaint([](Options& o) { o.map.voxel_size_m = 0; }), HasSubstr("map.voxel_size_m"));
  EXPECT_THAT(complaint([](Options& o) { o.tracker.iou_threshold = std::numeric_limits<float>::quiet_NaN(); }),
              HasSubstr("tracker.iou_threshold"));
  EXPECT_NO_THROW(Mapper({}, test::test_labels()));
}

// Class 9 is beyond the classes, so its number is the slot of an object to come.
TEST(Mapper, SegmentsOfClassesThatTheLabelSetLacksAreRefused) {
  Mapper mapper({}, test::test_labels());
  const Frame frame = good_frame();
  for (const bool as_class : {true, false}) {
    for (const std::uint16_t id : {std::uint16_t{9}, std::uint16_t{65535}}) {
      Segmentation segmentation = halves(frame.color_camera);
      Segment& segment = segmentation.segments[0];
      segment.is_whole_class = true;
      if (as_class) segment.class_id = ClassId{id};
      if (!as_class) segment.class_probabilities = {{ClassId{id}, 1.0F}};
      EXPECT_EQ(mapper.add(frame, segmentation).reason,
                "segmentation has class " + std::to_string(id) + ", which the label set 'test' has not");
    }
  }
  EXPECT_EQ(mapper.map().voxels.block_count(), 0U);
  Segmentation unknown = halves(frame.color_camera);
  unknown.segments[0] = {};
  EXPECT_EQ(mapper.add(frame, unknown), Outcome{});
}

// Such a frame took 23.7 GB.
TEST(Mapper, AFrameWhoseIntrinsicsAreNotInPixelsIsRefusedBeforeAnythingIsAllocated) {
  const Camera camera{640, 480, 0.9, 0.9, 0.5, 0.5};
  const Frame frame = render(test::plane(Vec3d::UnitZ(), 3), camera, Pose::Identity());
  for (const char* method : {"projective", "raycast"}) {
    for (const float voxel_m : {0.024F, 0.002F}) {
      Options options;
      options.integrator.method = method;
      options.map.voxel_size_m = voxel_m;
      Mapper mapper(options, test::test_labels());
      const std::string reason = mapper.add(frame, {}).reason;
      EXPECT_NE(reason.find("are its intrinsics in pixels?"), std::string::npos) << reason;
      EXPECT_EQ(mapper.add_geometry(frame).reason, reason);
      EXPECT_EQ(mapper.add_labels(frame, halves(camera)).reason, reason);
      EXPECT_EQ(mapper.frames().skipped(), 2U);
      EXPECT_EQ(mapper.frames().skipped_by_reason().at(reason), 2U);
      EXPECT_EQ(mapper.map().voxels.block_count(), 0U);
    }
  }
}

}  // namespace
}  // namespace panoptic
