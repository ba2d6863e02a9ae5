// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Bags as recordings. That they become the same map as a folder is tested with bags by writers of others: tests/bag_writers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "panoptic/bag.h"
#include "panoptic/base/files.h"
#include "panoptic/source.h"
#include "tests/bags/bag_bytes.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;
using namespace test;  // NOLINT(google-build-using-namespace): of the tests' own
using testing::Contains;
using testing::HasSubstr;

constexpr int kFrames = 3;
constexpr std::uint32_t kWidth = 8;
constexpr std::uint32_t kHeight = 6;

struct BagFields {
  InfoFields depth_info{kWidth, kHeight, "plumb_bob", {}, 10};
  std::string color_frame = "camera";
  std::string pose_topic = "/tf";
  double pose_shift_s = 0;
  std::vector<WrittenMessage> more;
};

fs::path write_bag(const fs::path& folder, const BagFields& f = {}) {
  std::vector<WrittenMessage> messages = f.more;
  for (int i = 0; i < kFrames; ++i) {
    const double time_s = 100 + 0.1 * i;
    std::string depth;
    for (std::uint32_t p = 0; p < kWidth * kHeight; ++p) depth += number_bytes(static_cast<std::uint16_t>(1000 + p));
    messages.push_back({"/d/image", "sensor_msgs/Image", time_s,
                        image_bytes({time_s, "camera", kWidth, kHeight, "16UC1", false, 2 * kWidth, depth})});
    messages.push_back({"/c/image", "sensor_msgs/Image", time_s,
                        image_bytes({time_s + 0.01, f.color_frame, kWidth, kHeight, "rgb8", false, 3 * kWidth,
                                     std::string(3 * kWidth * kHeight, 'c')})});
    if (!f.pose_topic.empty()) {
      messages.push_back({f.pose_topic, "tf2_msgs/TFMessage", time_s,
                          transform_bytes(time_s + f.pose_shift_s, "map", "camera", {0.1 * i, 0, 0})});
    }
  }
  messages.push_back({"/d/camera_info", "sensor_msgs/CameraInfo", 100, info_bytes(f.depth_info)});
  write_file(folder / "a.bag", ros1_bag(messages));
  return folder / "a.bag";
}

std::string refusal(const fs::path& path, const BagChoice& choice = {}) {
  return error_of([&] { open_bag(path, choice); });
}

TEST(DatasetBag, PairsImagesByTheirStampsAndGivesThemPoses) {
  const auto dataset = open_recording(write_bag(fresh_folder("bag")));
  EXPECT_EQ(dataset->description(), "ROS 1 bag, 3 frames, depth 8x6, colour 8x6");
  ASSERT_EQ(dataset->size(), 3U);
  const ReadResult read = dataset->read(1);
  ASSERT_TRUE(read.frame) << read.skipped.reason;
  EXPECT_NEAR(read.frame->time_s, 100.1, 1e-9);
  EXPECT_FLOAT_EQ(read.frame->depth(1, 0), 1.001F);
  EXPECT_NEAR(read.frame->world_from_camera.translation().x(), 0.1, 1e-12);
  EXPECT_EQ(read.frame->depth_camera, (Camera{8, 6, 10, 10, 0.5, 0.5}));
  EXPECT_NEAR(dataset->pose(2)->translation().x(), 0.2, 1e-12);
  EXPECT_THAT(dataset->notes().assumed, Contains(HasSubstr("pixel for pixel")));
}

TEST(DatasetBag, RemovesTheDistortionThatCameraInfoStates) {
  BagFields fields;
  fields.depth_info.d = {-0.3, 0.1, 0, 0, 0};
  const auto bent = open_bag(write_bag(fresh_folder("bent"), fields), {});
  const auto straight = open_bag(write_bag(fresh_folder("straight")), {});
  const auto bent_read = bent->read(0);
  const auto straight_read = straight->read(0);
  ASSERT_TRUE(bent_read.frame && straight_read.frame);
  EXPECT_FALSE(bent_read.frame->depth == straight_read.frame->depth);
  fields.depth_info.model = "equidistant";
  EXPECT_THAT(refusal(write_bag(fresh_folder("fisheye"), fields)), HasSubstr("equidistant"));
}

TEST(DatasetBag, ScalesACameraInfoOfTheSameShapeAndRefusesAnother) {
  BagFields fields;
  fields.depth_info = {2 * kWidth, 2 * kHeight, "plumb_bob", {}, 20};
  const auto dataset = open_bag(write_bag(fresh_folder("double"), fields), {});
  EXPECT_DOUBLE_EQ(dataset->read(0).frame->depth_camera.fx, 10);
  fields.depth_info = {kHeight, kWidth, "plumb_bob", {}, 20};
  EXPECT_THAT(refusal(write_bag(fresh_folder("upright"), fields)), HasSubstr("another shape"));
  fields.depth_info = {kWidth, kHeight, "plumb_bob", {}, 0};
  EXPECT_THAT(refusal(write_bag(fresh_folder("uncalibrated"), fields)), HasSubstr("not calibrated"));
}

TEST(DatasetBag, RefusesWhatItCannotConnect) {
  BagFields fields;
  fields.color_frame = "color_camera";
  EXPECT_THAT(refusal(write_bag(fresh_folder("color"), fields)), HasSubstr("of another frame than depth"));
  fields = {};
  fields.pose_topic = "";
  fields.more = {{"/tf", "tf2_msgs/TFMessage", 100, transform_bytes(100, "odom", "base_link", {0, 0, 0})},
                 {"/tf", "tf2_msgs/TFMessage", 101, transform_bytes(101, "odom", "base_link", {1, 0, 0})}};
  EXPECT_THAT(refusal(write_bag(fresh_folder("loose"), fields)), HasSubstr("no transform leads to the frame 'camera'"));
  fields = {};
  fields.pose_shift_s = 50;
  EXPECT_THAT(refusal(write_bag(fresh_folder("clocks"), fields)), HasSubstr("of one clock"));
}

TEST(DatasetBag, OdometryOfARobotIsCarriedToItsCamera) {
  BagFields fields;
  fields.pose_topic = "";
  // Between the images, so that poses are interpolated.
  for (const double time_s : {99.95, 100.05, 100.15, 100.25}) {
    fields.more.push_back(
        {"/odom", "nav_msgs/Odometry", time_s, odometry_bytes(time_s, "odom", "base_link", {10 * (time_s - 100), 0, 0})});
  }
  fields.more.push_back({"/tf_static", "tf2_msgs/TFMessage", 100, transform_bytes(100, "base_link", "mast", {0, 0, 1})});
  fields.more.push_back({"/tf_static", "tf2_msgs/TFMessage", 100, transform_bytes(100, "mast", "camera", {0, 0.5, 0})});
  const auto dataset = open_recording(write_bag(fresh_folder("robot"), fields));
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d expected(static_cast<double>(i), 0.5, 1);
    ASSERT_TRUE(dataset->pose(i));
    EXPECT_NEAR((dataset->pose(i)->translation() - expected).norm(), 0, 1e-9) << i;
  }
}

TEST(DatasetBag, InAFolderBelowIsNamed) {
  const fs::path folder = fresh_folder("above");
  fs::create_directory(folder / "walk");
  write_bag(folder / "walk");
  EXPECT_THAT(error_of([&] { open_recording(folder); }), HasSubstr((folder / "walk").string() + " meant?"));
  fs::remove(folder / "walk/a.bag");
  write_file(folder / "walk/metadata.yaml", "rosbag2_bagfile_information:\n");
  EXPECT_THAT(error_of([&] { open_recording(folder / "walk"); }), HasSubstr("not beside it"));
}

TEST(DatasetBag, WithoutPosesIsOpenedToBeTracked) {
  BagFields fields;
  fields.pose_topic = "";
  const fs::path bare = write_bag(fresh_folder("poseless"), fields);
  EXPECT_THROW(open_recording(bare), NoPoses);
  EXPECT_THAT(refusal(bare), HasSubstr("holds no poses"));
  // A camera that only stands fixed on its robot has no poses either.
  fields.more = {{"/tf_static", "tf2_msgs/TFMessage", 100, transform_bytes(100, "base_link", "camera", {0, 0, 1})}};
  const fs::path fixed = write_bag(fresh_folder("fixed"), fields);
  EXPECT_THROW(open_recording(fixed), NoPoses);
  for (const std::string& name : {bare.string(), fixed.string(), fixed.string() + "?depth=/d/image"}) {
    const auto dataset = open_without_poses(name);
    ASSERT_EQ(dataset->size(), 3U);
    EXPECT_TRUE(dataset->read(2).frame->world_from_camera.isApprox(Pose::Identity(), 0)) << name;
  }
  // Poses that are there are not looked at.
  const auto posed = open_without_poses(write_bag(fresh_folder("posed")));
  EXPECT_TRUE(posed->read(2).frame->world_from_camera.isApprox(Pose::Identity(), 0));
}

TEST(DatasetBag, TakesTheTopicsThatItsNameChooses) {
  BagFields fields;
  fields.more = {
      {"/other/image", "sensor_msgs/Image", 100,
       image_bytes({100, "camera", kWidth, kHeight, "16UC1", false, 2 * kWidth, std::string(2 * kWidth * kHeight, 'd')})}};
  const fs::path path = write_bag(fresh_folder("chosen"), fields);
  EXPECT_THAT(refusal(path), HasSubstr("choose with --topics depth=TOPIC: /other/image"));
  EXPECT_EQ(open_recording(path.string() + "?depth=/d/image")->size(), 3U);
  EXPECT_THAT(refusal(path, parse_bag_choice("depth=/c/image")), HasSubstr("rgb8"));
}

TEST(DatasetBag, ChoicesOfTopicsAreReadOrRefused) {
  const BagChoice choice = parse_bag_choice("depth=/a,pose=/b");
  EXPECT_EQ(choice.depth, "/a");
  EXPECT_EQ(choice.pose, "/b");
  for (const char* text : {"depth", "depth=", "deep=/a", "depth=/a,depth=/b"})
    EXPECT_THAT(error_of([&] { parse_bag_choice(text); }), HasSubstr("no choice of topics")) << text;
}

TEST(DatasetBag, ListsTopicsWithTheirRoles) {
  const BagListing listing = list_bag(write_bag(fresh_folder("list")));
  EXPECT_EQ(listing.container, "ROS 1 bag");
  ASSERT_EQ(listing.topics.size(), 4U);
  EXPECT_EQ(listing.topics[0].name, "/c/image");
  EXPECT_EQ(listing.topics[0].role, "color");
  EXPECT_EQ(listing.topics[1].role, "info");
  EXPECT_EQ(listing.topics[2].role, "depth");
  EXPECT_EQ(listing.topics[2].messages, 3U);
  EXPECT_EQ(listing.topics[3].role, "pose");
}

}  // namespace
}  // namespace panoptic
