// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/pose_update.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::HasSubstr;

class PoseUpdateFiles : public testing::Test {
 protected:
  std::filesystem::path file(const std::string& text) {
    write_file(path_, text);
    return path_;
  }
  std::string error_of_updates(const std::string& text) {
    return error_of([&] { read_pose_updates(file(text)); });
  }

  std::filesystem::path path_ = test::fresh_folder() / "poses";
};

constexpr const char* kIdentity = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";

TEST_F(PoseUpdateFiles, ALineOfJsonIsTheCorrectionsOfAMoment) {
  const auto updates = read_pose_updates(
      file(std::string(R"({"at_frame": 7, "poses": [{"frame": 3, "pose": [0,-1,0,0.5, 1,0,0,2, 0,0,1,-3, 0,0,0,1]}]})") + "\n\n" +
           R"({"at_frame": 7, "poses": []})" + "\n" + R"({"at_frame": 9, "poses": [{"frame": 0, "pose": )" + kIdentity + "}]}"));
  ASSERT_EQ(updates.size(), 3U);
  EXPECT_EQ(updates[0].at_frame, 7);
  ASSERT_EQ(updates[0].poses.size(), 1U);
  EXPECT_EQ(updates[0].poses[0].frame, 3);
  const Pose& pose = updates[0].poses[0].world_from_camera;
  EXPECT_TRUE((pose * Vec3d(1, 0, 0)).isApprox(Vec3d(0.5, 3, -3))) << "row by row";
  EXPECT_TRUE(updates[1].poses.empty());
  EXPECT_EQ(updates[2].at_frame, 9);
}

TEST_F(PoseUpdateFiles, WhatIsWrongIsSaidWithItsLine) {
  EXPECT_THAT(error_of_updates(""), HasSubstr("holds no corrections"));
  EXPECT_THAT(error_of_updates("\n{nonsense"), HasSubstr("poses line 2 is not JSON"));
  EXPECT_THAT(error_of_updates("{}"), HasSubstr("line 1: the whole must be an object with the member \"at_frame\""));
  EXPECT_THAT(error_of_updates(R"({"at_frame": -1, "poses": []})"), HasSubstr("at_frame must be"));
  EXPECT_THAT(error_of_updates(R"({"at_frame": 1, "poses": [{"frame": 0, "pose": [1, 2]}]})"), HasSubstr("16 numbers"));
  EXPECT_THAT(error_of_updates(R"({"at_frame": 1, "poses": [{"frame": 5, "pose": [2,0,0,0,0,2,0,0,0,0,2,0,0,0,0,1]}]})"),
              HasSubstr("the pose of frame 5 is no rigid motion"));
  EXPECT_THAT(error_of_updates(R"({"at_frame": 1, "poses": [{"frame": 5, "pose": [1,0,0,0,0,1,0,0,0,0,1,0,1,2,3,1]}]})"),
              HasSubstr("row by row"))
      << "column by column";
  EXPECT_THAT(error_of_updates("{\"at_frame\": 4, \"poses\": []}\n{\"at_frame\": 3, \"poses\": []}"),
              HasSubstr("line 2: at_frame 3 comes after 4"));
}

TEST_F(PoseUpdateFiles, NumbersAreFramesWhereAllOfThemAreAndElseTimes) {
  const std::vector<FrameTime> frames = {{10, 100.0}, {11, 100.1}, {12, 100.2}};
  auto poses = read_corrected_poses(file("10 1 0 0 0 0 0 1\n12 2 0 0 0 0 0 1\n"), frames).poses;
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[0].frame, 10);
  EXPECT_EQ(poses[1].frame, 12);
  EXPECT_EQ(poses[1].world_from_camera.translation().x(), 2);

  const auto timed = read_corrected_poses(file("100.012 1 0 0 0 0 0 1\n100.195 2 0 0 0 0 0 1\n100.9 3 0 0 0 0 0 1\n"), frames);
  EXPECT_EQ(timed.left_over, 1U);
  poses = timed.poses;
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[0].frame, 10);
  EXPECT_EQ(poses[1].frame, 12);
  // A tracker that is twice as fast: of two poses for a frame the nearer one counts.
  const auto fast = read_corrected_poses(file("100.0 1 0 0 0 0 0 1\n100.015 2 0 0 0 0 0 1\n100.103 3 0 0 0 0 0 1\n"), frames);
  ASSERT_EQ(fast.poses.size(), 2U);
  EXPECT_EQ(fast.poses[0].world_from_camera.translation().x(), 1);
  EXPECT_EQ(fast.left_over, 1U);
  // Frames without times of their own are never meant by times.
  const std::vector<FrameTime> timeless = {{0, 0}, {1, 0}, {2, 0}};
  EXPECT_EQ(read_corrected_poses(file("0 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n"), timeless).poses[1].frame, 2);
  EXPECT_THAT(error_of([&] { read_corrected_poses(file("0.001 1 0 0 0 0 0 1\n0.002 1 0 1 0 0 0 1\n"), timeless); }),
              HasSubstr("0 are within 20 ms"));
  EXPECT_THAT(error_of([&] { read_corrected_poses(file("2 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n"), timeless); }),
              HasSubstr("two poses for frame 2"));
  // A whole second may be a frame's number or a time: what fits more frames.
  const std::vector<FrameTime> slow = {{0, 1}, {1, 2}, {2, 3}};
  EXPECT_EQ(read_corrected_poses(file("1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n3 2 0 0 0 0 0 1\n"), slow).poses[0].frame, 0);
  EXPECT_EQ(read_corrected_poses(file("0 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n"), slow).poses[1].frame, 2);
  EXPECT_THAT(error_of([&] { read_corrected_poses(file("13 1 0 0 0 0 0 1\n"), frames); }),
              HasSubstr("of its 1 poses 0 have the number of a frame"));
}

}  // namespace
}  // namespace panoptic
