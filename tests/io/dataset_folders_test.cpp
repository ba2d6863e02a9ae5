// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Recordings in folders as their authors and users lay them out.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "panoptic/error.h"
#include "panoptic/source.h"
#include "tests/fresh_folder.h"
#include "tests/io/recordings.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

void expect_frames(const fs::path& root, const std::string& format, double scale = 1000) {
  SCOPED_TRACE(format);
  const auto dataset = open_recording(root);
  EXPECT_THAT(dataset->description(), StartsWith(format + ", 4 frames"));
  ASSERT_EQ(dataset->size(), static_cast<std::size_t>(kFrameCount));
  for (int i = 0; i < kFrameCount; ++i) expect_frame(dataset->read(static_cast<std::size_t>(i)), i, scale, 6);
}

Camera camera_of(const fs::path& root) { return open_recording(root)->read(0).frame->depth_camera; }

struct Names {
  std::string color = "images/{:05}.jpg";
  std::string depth = "depth/{:05}.png";
  int first = 0;
};

void write_images(const fs::path& root, const Names& names = {}) {
  for (int i = 0; i < kFrameCount; ++i) {
    write_color(root / fmt::format(fmt::runtime(names.color), i + names.first), color_image(i));
    write_depth(root / fmt::format(fmt::runtime(names.depth), i + names.first), raw_depth(i));
  }
}

std::string pose_lines(const std::string& before = "") {
  std::string text;
  for (int i = 0; i < kFrameCount; ++i) text += fmt::format(fmt::runtime(before), i) + matrix_text(pose_matrix(i), " ") + "\n";
  return text;
}

std::string redwood_log() {
  std::string text;
  for (int i = 0; i < kFrameCount; ++i) text += fmt::format("{0} {0} {1}\n", i, kFrameCount) + matrix_text(pose_matrix(i));
  return text;
}

constexpr const char* kOpen3dCamera = R"({"width": 32, "height": 24, "intrinsic_matrix": [30, 0, 0, 0, 31, 0, 15.5, 11.5, 1]})";

TEST(Folders, ReadOpen3dsRecorder) {
  const fs::path root = fresh_folder("open3d");
  write_images(root, {"color/{:06}.jpg", "depth/{:06}.png"});
  write_text(root / "camera_intrinsic.json", kOpen3dCamera);
  write_text(root / "trajectory.log", redwood_log());
  expect_frames(root, "Open3D recorder");
  EXPECT_EQ(camera_of(root), depth_camera());
  fs::create_directories(root / "scene");
  fs::rename(root / "trajectory.log", root / "scene/trajectory.log");
  expect_frames(root, "Open3D recorder");
}

TEST(Folders, ReadSemanticNerfsReplicaWithItsPublishedCamera) {
  const fs::path root = fresh_folder("Sequence_1");
  write_images(root, {"rgb/rgb_{}.png", "depth/depth_{}.png"});
  write_text(root / "traj_w_c.txt", pose_lines());
  expect_frames(root, "Replica (Semantic-NeRF)");
  EXPECT_NEAR(camera_of(root).fx, 320.0 * 32 / 640, 1e-9);
  EXPECT_NEAR(camera_of(root).cy, 11.5, 1e-9);
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
  EXPECT_EQ(camera_of(root), depth_camera());
}

TEST(Folders, ReadTheSubsetOfScannet) {
  const fs::path root = fresh_folder("scene0000_00");
  for (int i = 0; i < kFrameCount; ++i) {
    write_color(root / fmt::format("color/{:06}.jpeg", 100 * i), color_image(i));
    write_depth(root / fmt::format("depth/{:06}.png", 100 * i), raw_depth(i));
    write_text(root / fmt::format("pose/{:06}.txt", 100 * i), matrix_text(pose_matrix(i)));
  }
  write_text(root / "intrinsics_depth.txt", intrinsic_text(depth_camera()));
  write_text(root / "intrinsics_color.txt", intrinsic_text(color_camera()));
  expect_frames(root, "ScanNet export");
  EXPECT_EQ(open_recording(root)->read(0).frame->color_camera, color_camera());
  EXPECT_EQ(open_recording(root)->read(3).frame->index, 300);
}

TEST(Folders, ReadTheLayoutOfEth3d) {
  const fs::path root = fresh_folder("table_3");
  write_tum(root);
  write_text(root / "calibration.txt", "30 31 15.5 11.5\n");
  expect_frames(root, "TUM RGB-D (ETH3D)", 5000);
  EXPECT_EQ(camera_of(root), depth_camera());
  fs::remove(root / "rgb.txt");
  fs::remove(root / "depth.txt");
  std::string pairs;
  for (int i = 0; i < kFrameCount; ++i) pairs += fmt::format("{0}.012 rgb/{0}.0000.png {0}.0 depth/{0}.0000.png\n", 1000 + i);
  write_text(root / "associated.txt", pairs);
  expect_frames(root, "TUM RGB-D (ETH3D)", 5000);
}

TEST(Folders, ReadSun3dWithItsTurnedBitsAndItsTwoClocks) {
  const fs::path root = fresh_folder("hotel");
  std::string poses;
  for (int i = 0; i < kFrameCount; ++i) {
    Image<std::uint16_t> depth = raw_depth(i);
    for (std::size_t k = 0; k < depth.size(); ++k) depth[k] = std::rotl(depth[k], 3);
    write_color(root / fmt::format("image/{:07}-{:012}.jpg", i + 1, 33000 * i), color_image(i));
    write_depth(root / fmt::format("depth/{:07}-{:012}.png", 2 * i + 1, 33000 * i + 4000), depth);
    write_depth(root / fmt::format("depth/{:07}-{:012}.png", 2 * i + 2, 33000 * i + 20000), raw_depth(0));
    const std::string text = matrix_text(pose_matrix(i));
    poses += text.substr(0, text.rfind('\n', text.size() - 2) + 1);
  }
  write_text(root / "extrinsics/20140101.txt", "1 2 3\n");
  write_text(root / "extrinsics/20140808.txt", poses);
  write_text(root / "intrinsics.txt", intrinsic_text(depth_camera()));
  expect_frames(root, "SUN3D");
}

TEST(Folders, ReadIclNuimWithoutAList) {
  const fs::path root = fresh_folder("living_room_traj2");
  write_icl(root);
  fs::remove(root / "associations.txt");
  const auto dataset = open_recording(root);
  EXPECT_THAT(dataset->description(), StartsWith("ICL-NUIM, 4 frames"));
  for (int i = 1; i < kFrameCount; ++i) expect_frame(dataset->read(static_cast<std::size_t>(i)), i, 5000);
}

TEST(Folders, ReadFlatOnes) {
  const fs::path root = fresh_folder("posed_images");
  write_images(root, {"{:05}.jpg", "{:05}.png"});
  for (int i = 0; i < kFrameCount; ++i) write_text(root / fmt::format("{:05}.txt", i), matrix_text(pose_matrix(i)));
  write_text(root / "intrinsic.txt", "30 0 15.5 0\n0 31 11.5 0\n0 0 1 0\n0 0 0 1\n");
  expect_frames(root, "flat folder");
  const fs::path words = fresh_folder("words");
  write_images(words, {"{:04}-color.png", "{:04}-depth.png"});
  write_text(words / "poses.txt", pose_lines());
  write_text(words / "K.txt", intrinsic_text(depth_camera()));
  expect_frames(words, "flat folder");
}

TEST(Folders, ReadPosesInAnyUsualForm) {
  const fs::path root = fresh_folder("plain");
  write_images(root);
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
  for (const std::string& text : {pose_lines(), "\xEF\xBB\xBF" + pose_lines(), pose_lines("{:05}.jpg "),
                                  pose_lines("images/{:05}.jpg "), pose_lines("{} "), redwood_log()}) {
    write_text(root / "poses.txt", text);
    expect_frames(root, "plain folder");
  }
  EXPECT_THAT(open_recording(root)->notes().assumed,
              Contains(HasSubstr("taken from camera (x right, y down, z forward) to world")));
}

TEST(Folders, GivePosesWithNumbersToTheFramesOfTheseNumbers) {
  const fs::path root = fresh_folder("plain");
  write_images(root, {.first = 5});
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
  write_text(root / "poses.txt", "6 " + matrix_text(pose_matrix(1), " ") + "\n8 " + matrix_text(pose_matrix(3), " ") + "\n");
  const auto dataset = open_recording(root);
  EXPECT_EQ(dataset->read(0).skipped.reason, "pose missing");
  expect_frame(dataset->read(1), 1, 1000, 6);
  expect_frame(dataset->read(3), 3, 1000, 6);
  write_text(root / "poses.txt", pose_lines("{} "));  // from 0, for images from 5
  expect_frames(root, "plain folder");
  EXPECT_THAT(open_recording(root)->notes().assumed, Contains(HasSubstr("begin with number 0 and the images with 5")));
}

TEST(Folders, ReadTextWithOldMacintoshLineEndsAndInUtf16) {
  const fs::path root = fresh_folder("plain");
  write_images(root);
  std::string text = pose_lines();
  std::string camera = intrinsic_text(depth_camera());
  for (std::string* file : {&text, &camera}) std::replace(file->begin(), file->end(), '\n', '\r');
  write_text(root / "K.txt", camera);
  write_text(root / "poses.txt", text);
  expect_frames(root, "plain folder");
  std::string wide = "\xFF\xFE";
  for (const char c : pose_lines()) wide += {c, '\0'};
  write_text(root / "poses.txt", wide);
  expect_frames(root, "plain folder");
}

TEST(Folders, TakeTheSizeThatMostImagesHave) {
  const fs::path root = fresh_folder("plain");
  write_images(root);
  write_depth(root / "depth/00000.png", raw_depth(0, {16, 12}));
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
  write_text(root / "poses.txt", pose_lines());
  const auto dataset = open_recording(root);
  EXPECT_EQ(dataset->read(0).skipped.reason, "depth image is 16x12, expected 32x24");
  for (int i = 1; i < kFrameCount; ++i) expect_frame(dataset->read(static_cast<std::size_t>(i)), i, 1000, 6);
}

TEST(Folders, NameColourAndDepthThatAreSwapped) {
  const fs::path root = fresh_folder("plain");
  write_images(root, {.color = "depth/{:05}.jpg", .depth = "images/{:05}.png"});
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
  write_text(root / "poses.txt", pose_lines());
  EXPECT_THAT(error_of(root), HasSubstr("whose colour and depth are swapped: images/00000.png has one channel of 16 bits"));
}

TEST(Folders, NameImagesOfAnEndingThatIsNotRead) {
  const fs::path root = fresh_folder("plain");
  write_images(root, {.color = "images/{:05}.png"});
  for (int i = 0; i < kFrameCount; ++i)
    fs::rename(root / fmt::format("images/{:05}.png", i), root / fmt::format("images/{:05}.webp", i));
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
  write_text(root / "poses.txt", pose_lines());
  EXPECT_THAT(error_of(root), HasSubstr("images: no colour image (.png, .jpg, .jpeg); it has 4 files, 00000.webp for one"));
  fs::remove(root / "poses.txt");
  write_text(root / "poses.json", "[]");
  EXPECT_THAT(error_of(root), HasSubstr("poses are not read from poses.json: write them to poses.txt"));
}

TEST(Folders, ReadIntrinsicsInAnyUsualForm) {
  const fs::path root = fresh_folder("plain");
  write_images(root);
  write_text(root / "poses.txt", pose_lines());
  const std::vector<std::pair<const char*, const char*>> files = {
      {"K.txt", "30 31 15.5 11.5\n"},
      {"K.txt", "30 0 0 0 31 0 15.5 11.5 1\n"},
      {"K.txt", "[[30.   0.  15.5]\n [ 0.  31.  11.5]\n [ 0.   0.   1. ]]\n"},
      {"intrinsics.txt", "30 0 15.5\n0 31 11.5\n0 0 1\n"},
      {"K.txt", "fx: 30\nfy: 31\ncx: 15.5\ncy: 11.5\n"},
      {"K.txt", "cx,cy,fx,fy\r\n15.5,11.5,30,31\r\n"},
      {"intrinsic.json", kOpen3dCamera},
      {"camera.json", R"({"camera": {"w": 32, "h": 24, "fx": 30, "fy": 31, "cx": 15.5, "cy": 11.5}})"},
      {"camera_intrinsics.json", R"({"K": [[30, 0, 15.5], [0, 31, 11.5], [0, 0, 1]]})"}};
  for (const auto& [name, text] : files) {
    write_text(root / name, text);
    EXPECT_EQ(camera_of(root), depth_camera()) << name << " " << text;
    fs::remove(root / name);
  }
  write_text(root / "K.txt", "30 31 15.5 11.5 0.1 0.2 0.3 0.4 0.5\n");
  EXPECT_THAT(error_of(root), HasSubstr("no usable intrinsic matrix"));
  fs::remove(root / "K.txt");
  write_text(root / "camera.json", R"({"camera": {"w": 32, "fx": 30}})");
  EXPECT_THAT(error_of(root), HasSubstr("camera.json: no intrinsics"));
}

TEST(Folders, ReadDepthAsFloatsInMetresAndAsWholeMillimetres) {
  const fs::path root = fresh_folder("plain");
  write_images(root);
  write_text(root / "poses.txt", pose_lines());
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
  for (int i = 0; i < kFrameCount; ++i) {
    fs::remove(root / fmt::format("depth/{:05}.png", i));
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (24, 32), }";
    header.resize(117, ' ');
    std::string bytes = std::string("\x93NUMPY\x01\0\x76\0", 10) + header + "\n";
    const Image<std::uint16_t> image = raw_depth(i);
    for (const std::uint16_t raw : image.pixels()) {
      const float metres = raw == 65535 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(raw) / 1000;
      bytes.append(reinterpret_cast<const char*>(&metres), sizeof metres);
    }
    write_text(root / fmt::format("depth/{:05}.npy", i), bytes);
  }
  expect_frames(root, "plain folder");
  EXPECT_EQ(open_recording(root)->notes().depth_scale, 1);
}

TEST(Folders, NameTheReasonWhyADepthImageIsNone) {
  const fs::path root = fresh_folder("plain");
  write_images(root);
  write_text(root / "poses.txt", pose_lines());
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
  for (int i = 0; i < kFrameCount; ++i) write_color(root / fmt::format("depth/{:05}.png", i), color_image(i));
  EXPECT_THAT(error_of(root), HasSubstr("a colour picture; depth needs one channel of 16 bits"));
}

TEST(Folders, NameTheNearestFormatAndWhatItLacks) {
  const fs::path root = fresh_folder("plain");
  write_images(root);
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
  EXPECT_THAT(error_of(root), HasSubstr("plain folder recording without poses; panoptic run --track finds them"));
  const fs::path replica = fresh_folder("room0");
  write_text(replica / "results" / "frame000000.jpg", "as a flat folder has it");
  write_text(replica / "results" / "depth000000.png", "as a flat folder has it");
  EXPECT_THAT(error_of(replica), HasSubstr("nearest is Replica: it has results/ and lacks traj.txt"));
  const fs::path zips = fresh_folder("zips");
  write_text(zips / "seq-01.zip", "PK");
  EXPECT_THAT(error_of(zips), HasSubstr("found seq-01.zip; unpack it"));
  const fs::path outer = fresh_folder("outer");
  write_images(outer / "inner");
  write_text(outer / "inner" / "poses.txt", pose_lines());
  EXPECT_THAT(error_of(outer), HasSubstr((outer / "inner").string() + " meant?"));
  for (const fs::path& path : {root, replica, zips, outer}) EXPECT_THAT(error_of(path), Not(HasSubstr("\n")));
}

}  // namespace
}  // namespace panoptic::test
