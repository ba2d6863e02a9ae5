// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "tests/fresh_folder.h"
#include "tests/io/phone_recordings.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kJpeg = 6;  // how far its colours are off

template <typename T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

void append_attribute(std::string& bytes, const std::string& name, const std::string& type, const std::string& value) {
  bytes += name + '\0' + type + '\0';
  append(bytes, static_cast<std::int32_t>(value.size()));
  bytes += value;
}

template <typename... T>
std::string bytes_of(const T&... values) {
  std::string bytes;
  (append(bytes, values), ...);
  return bytes;
}

// OpenEXR without compression: metres in one channel R of 32-bit floats, as the app writes them.
std::string exr_bytes(const Image<std::uint16_t>& millimetres) {
  const std::int32_t width = millimetres.width();
  const std::int32_t height = millimetres.height();
  std::string channels = std::string("R") + '\0' + bytes_of(2, 0, 1, 1) + '\0';
  std::string bytes = bytes_of(20000630, 2);
  append_attribute(bytes, "channels", "chlist", channels);
  append_attribute(bytes, "compression", "compression", std::string(1, '\0'));
  append_attribute(bytes, "dataWindow", "box2i", bytes_of(0, 0, width - 1, height - 1));
  append_attribute(bytes, "displayWindow", "box2i", bytes_of(0, 0, width - 1, height - 1));
  append_attribute(bytes, "lineOrder", "lineOrder", std::string(1, '\0'));
  append_attribute(bytes, "pixelAspectRatio", "float", bytes_of(1.0F));
  append_attribute(bytes, "screenWindowCenter", "v2f", bytes_of(0.0F, 0.0F));
  append_attribute(bytes, "screenWindowWidth", "float", bytes_of(1.0F));
  bytes += '\0';
  const auto line_bytes = static_cast<std::uint64_t>(8 + 4 * width);
  const std::uint64_t first = bytes.size() + 8 * static_cast<std::uint64_t>(height);
  for (std::int32_t v = 0; v < height; ++v) append(bytes, first + static_cast<std::uint64_t>(v) * line_bytes);
  for (std::int32_t v = 0; v < height; ++v) {
    bytes += bytes_of(v, 4 * width);
    for (std::int32_t u = 0; u < width; ++u) append(bytes, static_cast<float>(millimetres(u, v)) / 1000);
  }
  return bytes;
}

struct Record3dKind {
  std::string folder = "EXR_RGBD";
  bool confidence = true;
  bool own_intrinsics = false;
  std::string poses;  // in place of those of the frames
};

void write_record3d(const fs::path& path, const Record3dKind& kind = {}) {
  const fs::path root = path / kind.folder;
  std::string poses;
  std::string own;
  for (int i = 0; i < kFrameCount; ++i) {
    write_color(root / fmt::format("rgb/{}.jpg", i), color_image(i));
    Image<std::uint16_t> depth = raw_depth(i);
    depth(1, 0) = 0;  // floats have no value for "none"
    write_text(root / fmt::format("depth/{}.exr", i), exr_bytes(depth));
    if (kind.confidence) write_confidence(root / fmt::format("confidence/{}.png", i), confidence_image());
    const Pose opengl = Pose(pose_matrix(i)) * Pose(Eigen::AngleAxisd(3.14159265358979323846, Vec3d::UnitX()));
    const Eigen::Quaterniond q(opengl.linear());
    const Vec3d t = opengl.translation();
    poses += fmt::format("{}[{},{},{},{},{},{},{}]", i == 0 ? "" : ",", q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z());
    const Camera c = stray_camera(i);
    own += fmt::format("{}[{},{},{},{}]", i == 0 ? "" : ",", c.fx, c.fy, c.cx, c.cy);
  }
  const Camera c = stray_camera();
  std::string text = fmt::format(R"({{"w":48,"h":36,"dw":32,"dh":24,"fps":60,"K":[{},0,0,0,{},0,{},{},1],"poses":[{}])", c.fx,
                                 c.fy, c.cx, c.cy, kind.poses.empty() ? poses : kind.poses);
  if (kind.own_intrinsics) text += R"(,"perFrameIntrinsicCoeffs":[)" + own + "]";
  write_text(root / "metadata.json", text + "}");
}

std::string reason(const Dataset& dataset, std::size_t position) {
  const ReadResult result = dataset.read(position);
  return result.frame ? "frame" : result.skipped.reason;
}

TEST(Record3d, IsReadFromItsExportOfFloats) {
  const fs::path root = fresh_folder("2025-04-22--10-19-25");
  write_record3d(root);
  const auto dataset = open_recording(root);
  EXPECT_EQ(dataset->description(), "Record3D, 4 frames, depth 32x24, colour 48x36");
  for (int i = 0; i < kFrameCount; ++i) expect_phone_frame(dataset->read(static_cast<std::size_t>(i)), i, stray_camera(), kJpeg);
  EXPECT_NEAR(dataset->read(3).frame->time_s, 0.05, 1e-12);
  EXPECT_THAT(dataset->notes().assumed, ElementsAre());
  EXPECT_THAT(open_recording(root / "EXR_RGBD")->description(), HasSubstr("Record3D, 4 frames"));
  write_record3d(root, {.own_intrinsics = true});
  for (int i = 0; i < kFrameCount; ++i)
    expect_phone_frame(open_recording(root)->read(static_cast<std::size_t>(i)), i, stray_camera(i), kJpeg);
}

// The convention itself, from the app's author (issues 27 and 33 of marek-simonik/record3d): qx qy qz qw px py pz of a camera
// with OpenGL's axes. It looks along -z, and after a turn to the left by 90 degrees along -x; up is y.
TEST(Record3d, HasPosesWithTheAxesOfOpenGl) {
  const fs::path root = fresh_folder("record3d");
  write_record3d(root, {.confidence = false, .poses = "[0,0,0,1,0,0,0],[0,0.70710678118654752,0,0.70710678118654752,5,1,2]"});
  for (int i = 0; i < 2; ++i) write_text(root / fmt::format("EXR_RGBD/depth/{}.exr", i), exr_bytes(flat_depth(3000)));
  const auto dataset = open_recording(root);
  const Frame ahead = *dataset->read(0).frame;
  EXPECT_NEAR(seen_at(ahead, 15, 12).z(), -3, 1e-6);
  EXPECT_GT(seen_at(ahead, 31, 12).x(), 1);
  EXPECT_GT(seen_at(ahead, 15, 1).y(), 1);
  const Frame left = *dataset->read(1).frame;
  EXPECT_NEAR(seen_at(left, 15, 12).x(), 2, 1e-6);
  EXPECT_LT(seen_at(left, 31, 12).z(), 1);
  EXPECT_GT(seen_at(left, 15, 1).y(), 2);
  EXPECT_EQ(reason(*dataset, 2), "no pose: metadata.json has 2");
  EXPECT_THAT(dataset->notes().assumed, ElementsAre(HasSubstr("there are no images in confidence/")));
}

TEST(Record3d, SkipsFramesWithDamagedParts) {
  const fs::path root = fresh_folder("record3d");
  write_record3d(root, {.poses = "[0,0,0,1,0,0,0],[0,0,0,1,null,0,0],[0,0,0,1,0,0,0],[0,0,0,0,0,0,0]"});
  fs::remove(root / "EXR_RGBD/depth/0.exr");
  write_confidence(root / "EXR_RGBD/confidence/2.png", confidence_image({16, 12}));
  const auto dataset = open_recording(root);
  EXPECT_EQ(reason(*dataset, 0), "depth image missing");
  EXPECT_EQ(reason(*dataset, 1), "pose is not finite");
  EXPECT_EQ(reason(*dataset, 2), "confidence image is 16x12, and the depth image 32x24");
  EXPECT_EQ(reason(*dataset, 3), "pose is not a rigid transform");
}

TEST(Record3d, SaysWhatIsWrongWithItsMetadata) {
  const fs::path root = fresh_folder("record3d");
  write_record3d(root, {.poses = "[0,0,1,0,0,0]"});
  EXPECT_THAT(error_of(root), HasSubstr("metadata.json: poses[0] must be 7 numbers: qx qy qz qw px py pz"));
  write_text(root / "EXR_RGBD/metadata.json", R"({"w":48,"h":36,"poses":[]})");
  EXPECT_THAT(error_of(root), HasSubstr("\"K\""));
  write_text(root / "EXR_RGBD/metadata.json", "{");
  EXPECT_THAT(error_of(root), HasSubstr("metadata.json"));
}

TEST(Record3d, OwnFilesAreRefusedWithTheWayToExport) {
  const fs::path root = fresh_folder("record3d");
  write_text(root / "walk.r3d", "PK");
  for (const fs::path& path : {root, root / "walk.r3d"})
    EXPECT_THAT(error_of(path), HasSubstr("found walk.r3d; .r3d is not read: export it in the app as EXR + RGB"));
}

}  // namespace
}  // namespace panoptic::test
