// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/error.h"
#include "panoptic/source.h"
#include "tests/fresh_folder.h"
#include "tests/io/recordings.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr int kJpegTolerance = 6;

std::string reason(const Dataset& dataset, std::size_t position) {
  const ReadResult result = dataset.read(position);
  return result.frame ? "frame" : result.skipped.reason;
}

void expect_all_frames(const Dataset& dataset, double scale, int tolerance) {
  ASSERT_EQ(dataset.size(), static_cast<std::size_t>(kFrameCount));
  for (int i = 0; i < kFrameCount; ++i) expect_frame(dataset.read(static_cast<std::size_t>(i)), i, scale, tolerance);
}

TEST(Dataset, ReadsEveryLayoutOfTheScannetExport) {
  for (const ScannetLayout& layout : {ScannetLayout{}, ScannetLayout{.folder = "frames"}, ScannetLayout{.poses = "poses"},
                                      ScannetLayout{.one_intrinsic = true}}) {
    const fs::path root = fresh_folder("export");
    write_scannet_export(root, layout);
    const auto dataset = open_recording(root);
    EXPECT_THAT(dataset->description(), StartsWith("ScanNet export, 4 frames, depth 32x24, colour 48x36"));
    expect_all_frames(*dataset, 1000, kJpegTolerance);
    EXPECT_EQ(dataset->read(3).frame->index, 200);  // numeric order, not 10 before 9
    EXPECT_EQ(dataset->read(0).frame->depth_camera, depth_camera());
    const Camera registered = resized(depth_camera(), kColorSize.width, kColorSize.height);
    EXPECT_EQ(dataset->read(0).frame->color_camera, layout.one_intrinsic ? registered : color_camera());
  }
}

TEST(Dataset, ScalesScannetIntrinsicsThatKeptTheSensorSize) {
  const fs::path root = fresh_folder("export");
  write_scannet_export(root);
  write_text(root / "intrinsic" / "intrinsic_depth.txt", intrinsic_text({0, 0, 577, 579, 319.5, 239.5}));
  write_text(root / "intrinsic" / "intrinsic_color.txt", intrinsic_text({0, 0, 1170, 1171, 647.5, 483.5}));
  const Frame frame = *open_recording(root)->read(0).frame;
  EXPECT_NEAR(frame.depth_camera.fx, 577.0 * 32 / 640, 1e-9);
  EXPECT_NEAR(frame.depth_camera.cx, 15.5, 1e-9);
  EXPECT_NEAR(frame.color_camera.fx, 1170.0 * 48 / 1296, 1e-9);
  EXPECT_NEAR(frame.color_camera.cy, 17.5, 1e-9);
}

TEST(Dataset, PlacesTheScannetCamerasByTheirExtrinsics) {
  const fs::path root = fresh_folder("export");
  write_scannet_export(root);
  Eigen::Matrix4d extrinsic = Eigen::Matrix4d::Identity();
  extrinsic(0, 3) = 0.05;
  write_text(root / "intrinsic" / "extrinsic_depth.txt", matrix_text(extrinsic));
  const Frame frame = *open_recording(root)->read(2).frame;
  EXPECT_NEAR(frame.color_from_depth.translation().x(), 0.05, 1e-6);
  EXPECT_TRUE(frame.world_from_camera.matrix().isApprox(pose_matrix(2) * extrinsic, 1e-6));
}

TEST(Dataset, ReadsTheScannetCppExport) {
  const fs::path root = fresh_folder("export");
  write_scannet_cpp_export(root);
  const auto dataset = open_recording(root);
  EXPECT_THAT(dataset->description(), StartsWith("ScanNet C++ export"));
  expect_all_frames(*dataset, 1000, kJpegTolerance);
  EXPECT_EQ(dataset->read(0).frame->color_camera, color_camera());
}

TEST(Dataset, NamesWhatIsWrongInTheInfoFileOfTheScannetCppExport) {
  const fs::path root = fresh_folder("export");
  write_scannet_cpp_export(root);
  write_text(root / "_info.txt", "m_depthShift = 1000\n");
  EXPECT_THAT(error_of(root), HasSubstr("'m_calibrationDepthIntrinsic' is missing"));
}

TEST(Dataset, ReadsSevenScenesWithItsPublishedConstants) {
  const fs::path root = fresh_folder("chess");
  write_seven_scenes(root / "seq-02");
  const fs::path calibration = root / "small.toml";
  write_text(calibration, "[depth]\nfx = 30\nfy = 31\ncx = 15.5\ncy = 11.5\n[color]\nfx = 44\nfy = 45\ncx = 23.5\ncy = 17.5\n");
  for (const fs::path& path : {root, root / "seq-02", root / "seq-02" / ""}) {
    expect_all_frames(*open_recording(path, calibration), 1000, 0);
  }
  const Frame frame = *open_recording(root)->read(0).frame;  // 640x480 constants scaled to the small images
  EXPECT_NEAR(frame.depth_camera.fx, 585.0 * 32 / 640, 1e-9);
  EXPECT_NEAR(frame.color_camera.fx, 585.0 * 48 / 640, 1e-9);
}

TEST(Dataset, Reads3DMatchWithItsCameraFileInTheSceneFolder) {
  const fs::path root = fresh_folder("scene");
  write_seven_scenes(root / "seq-01", ".jpg");
  write_text(root / "camera-intrinsics.txt", intrinsic_text(depth_camera()));
  const auto dataset = open_recording(root / "seq-01");
  expect_all_frames(*dataset, 1000, kJpegTolerance);
  EXPECT_EQ(dataset->read(0).frame->depth_camera, depth_camera());
  EXPECT_EQ(dataset->read(0).frame->color_camera, resized(depth_camera(), kColorSize.width, kColorSize.height));
}

TEST(Dataset, AsksWhichOfSeveralSequencesIsMeant) {
  const fs::path root = fresh_folder("chess");
  write_seven_scenes(root / "seq-01");
  write_seven_scenes(root / "seq-02");
  EXPECT_THAT(error_of(root), HasSubstr("holds 2 sequences (seq-01, seq-02)"));
}

TEST(Dataset, ReadsReplicaWithItsCameraFileBesideOrAbove) {
  const fs::path root = fresh_folder("Replica");
  write_replica(root / "room0");
  const std::string camera = R"({"w": 32, "h": 24, "fx": 30, "fy": 31, "cx": 15.5, "cy": 11.5, "scale": 6553.5})";
  write_text(root / "cam_params.json", R"({"camera": )" + camera + "}");
  expect_all_frames(*open_recording(root / "room0"), 6553.5, kJpegTolerance);
  fs::remove(root / "cam_params.json");
  EXPECT_THAT(error_of(root / "room0"), HasSubstr("no camera intrinsics"));
  write_text(root / "room0" / "cam_params.json", camera);
  expect_all_frames(*open_recording(root / "room0"), 6553.5, kJpegTolerance);
  write_text(root / "room0" / "cam_params.json", R"({"w": -32})");
  EXPECT_THAT(error_of(root / "room0"), HasSubstr("'w' must be a number"));
}

TEST(Dataset, ReplicaFramesAfterTheLastPoseHaveNone) {
  const fs::path root = fresh_folder("room0");
  write_replica(root);
  write_text(root / "cam_params.json", R"({"w": 32, "h": 24, "fx": 30, "fy": 31, "cx": 15.5, "cy": 11.5, "scale": 6553.5})");
  write_text(root / "traj.txt", matrix_text(pose_matrix(0), " ") + "\n");
  const auto dataset = open_recording(root);
  EXPECT_EQ(reason(*dataset, 0), "frame");
  EXPECT_EQ(reason(*dataset, 1), "pose missing");
  write_text(root / "traj.txt", "1 2 3\n");
  EXPECT_THAT(error_of(root), HasSubstr("traj.txt:1: 3 numbers"));
}

TEST(Dataset, ReadsAPlainFolderWhoseNumbersHaveGaps) {
  const fs::path root = fresh_folder("plain");
  write_plain_folder(root);
  const auto dataset = open_recording(root);
  EXPECT_THAT(dataset->description(), StartsWith("plain folder, 4 frames"));
  expect_all_frames(*dataset, 1000, 0);
  EXPECT_EQ(dataset->read(3).frame->index, 12);
}

TEST(Dataset, RefusesAPlainFolderWithAnotherNumberOfPosesThanImages) {
  const fs::path root = fresh_folder("plain");
  write_plain_folder(root);
  fs::remove(root / "images" / "00004.png");
  EXPECT_THAT(error_of(root), HasSubstr("4 poses for 3 colour images"));
}

TEST(Dataset, ReadsAPlainFolderWithAPoseFileForEachFrame) {
  const fs::path root = fresh_folder("plain");
  write_plain_folder(root);
  fs::remove(root / "poses.txt");
  for (int i = 0; i < kFrameCount; ++i)
    write_text(root / "poses" / fmt::format("{}.txt", 3 + i * i), matrix_text(pose_matrix(i)));
  expect_all_frames(*open_recording(root), 1000, 0);
}

TEST(Dataset, SaysWhatItLookedForInAFolderThatIsNoRecording) {
  const fs::path root = fresh_folder("empty");
  const std::string error = error_of(root);
  for (const char* format :
       {"no recording of a known format", ".sens", "ScanNet export", "C++", "7-Scenes", "TUM", "Replica", "plain folder"}) {
    EXPECT_THAT(error, HasSubstr(format));
  }
  EXPECT_EQ(error.find('\n'), std::string::npos);
  EXPECT_THAT(error_of(root / "absent"), HasSubstr("no such file or folder"));
  EXPECT_THAT(error_of("sim:7"), HasSubstr("sim:7: a simulated home, and the simulator is not part of this"));
}

TEST(Dataset, SkipsFramesWithAReasonAndCountsThemAsPositions) {
  const fs::path root = fresh_folder("plain");
  write_plain_folder(root);
  fs::remove(root / "poses.txt");
  Eigen::Matrix4d lost = Eigen::Matrix4d::Constant(-std::numeric_limits<double>::infinity());
  Eigen::Matrix4d stretched = pose_matrix(1);
  stretched.topLeftCorner<3, 3>() *= 1.2;
  Eigen::Matrix4d mirrored = pose_matrix(1);
  mirrored.col(0).head<3>() *= -1;
  const auto read_first = [&](const std::string& pose) {
    write_text(root / "poses" / "3.txt", pose);
    return reason(*open_recording(root), 0);
  };
  EXPECT_EQ(read_first(matrix_text(lost)), "pose is not finite");
  EXPECT_EQ(read_first("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 -1.#INF"), "pose is not finite");
  EXPECT_EQ(read_first(matrix_text(stretched)), "pose is not a rigid transform");
  EXPECT_EQ(read_first(matrix_text(mirrored)), "pose is not a rigid transform");
  for (const char* text : {"1 2 3", "", "hello"})
    EXPECT_THAT(read_first(text), StartsWith("pose unreadable: poses/3.txt is no pose"));
  EXPECT_EQ(reason(*open_recording(root), 1), "pose missing");
  EXPECT_EQ(read_first(matrix_text(pose_matrix(0))), "frame");
}

TEST(Dataset, SkipsFramesWhoseImagesAreMissingCutOffOrOfAnotherSize) {
  const fs::path root = fresh_folder("scene");
  write_seven_scenes(root);
  fs::remove(root / "frame-000000.color.png");
  fs::resize_file(root / "frame-000001.depth.png", 60);
  write_depth(root / "frame-000002.depth.png", raw_depth(0, {16, 12}));
  const auto dataset = open_recording(root);
  ASSERT_EQ(dataset->size(), 4U);
  EXPECT_EQ(reason(*dataset, 0), "colour image missing");
  EXPECT_EQ(dataset->read(0).skipped.index, 0);
  EXPECT_THAT(reason(*dataset, 1),
              AllOf(StartsWith("depth image unreadable: "), HasSubstr("frame-000001.depth.png: not a readable image")));
  EXPECT_EQ(reason(*dataset, 2), "depth image is 16x12, expected 32x24");
  EXPECT_EQ(reason(*dataset, 3), "frame");
  EXPECT_EQ(dataset->read(2).skipped.index, 2);
  fs::remove(root / "frame-000003.depth.png");  // behind the reader's back
  EXPECT_EQ(reason(*dataset, 3), "depth image missing: frame-000003.depth.png");
}

TEST(Dataset, RefusesARecordingWithoutOneUsableImage) {
  const fs::path root = fresh_folder("scene");
  write_seven_scenes(root);
  for (int i = 0; i < kFrameCount; ++i) fs::remove(root / fmt::format("frame-{:06}.color.png", i));
  EXPECT_THAT(error_of(root), HasSubstr("colour image missing"));
}

TEST(Dataset, TakesTheCamerasOfACalibrationFile) {
  const fs::path root = fresh_folder("plain");
  write_plain_folder(root);
  write_text(root / "c.toml",
             "[depth]\nfx = 60\nfy = 62\ncx = 31.5\ncy = 23.5\nwidth = 64\nheight = 48\nscale = 500\ninvalid = [65535, 1014]\n"
             "[color]\nfx = 40\nfy = 41\ncx = 20\ncy = 21\n[color_from_depth]\ntranslation = [0.1, 0, 0]\n");
  const Frame frame = *open_recording(root, root / "c.toml")->read(0).frame;
  EXPECT_NEAR(frame.depth_camera.fx, 30, 1e-9);  // for 64x48 images, scaled to 32x24
  EXPECT_NEAR(frame.depth_camera.cx, 15.5, 1e-9);
  EXPECT_EQ(frame.color_camera, (Camera{48, 36, 40, 41, 20, 21}));
  EXPECT_NEAR(frame.color_from_depth.translation().x(), 0.1, 1e-12);
  EXPECT_EQ(frame.depth(2, 0), 0.0F);  // raw 1014
  EXPECT_FLOAT_EQ(frame.depth(3, 0), 1021.0F / 500);
}

TEST(Dataset, RefusesIntrinsicsForImagesOfAnotherShape) {
  const fs::path root = fresh_folder("plain");
  write_plain_folder(root);
  write_text(root / "c.toml", "[depth]\nwidth = 1280\nheight = 720\n");
  EXPECT_THAT(error_of(root, root / "c.toml"), HasSubstr("for 1280x720 images but the images are 32x24"));
}

TEST(Recording, ListsTheFilesThatNoFrameIsMadeOf) {
  const fs::path root = fresh_folder("scene");
  write_plain_folder(root);
  EXPECT_THAT(open_recording(root)->notes().left_out, ::testing::IsEmpty());
  write_text(root / "depth" / "picture.bmp", "x");
  write_text(root / "depth" / "another.bmp", "x");
  write_text(root / "images" / "notes", "x");
  write_text(root / "images" / ".DS_Store", "x");
  EXPECT_THAT(open_recording(root)->notes().left_out,
              ::testing::ElementsAre("depth/: 2 files *.bmp, the first is another.bmp", "images/: 1 file *, the first is notes"));
}

TEST(Recording, TellsAPoseWithoutItsImages) {
  const fs::path root = fresh_folder("scene");
  write_seven_scenes(root);
  fs::remove(root / "frame-000002.pose.txt");
  const auto dataset = open_recording(root);
  for (const std::size_t i : {0U, 1U, 3U}) {
    ASSERT_TRUE(dataset->pose(i));
    EXPECT_TRUE(dataset->pose(i)->isApprox(dataset->read(i).frame->world_from_camera));
  }
  EXPECT_FALSE(dataset->pose(2));
}

TEST(Recording, GivesTheReasonWhyAnImageCannotBeRead) {
  const fs::path root = fresh_folder("scene");
  write_seven_scenes(root);
  write_color(root / "frame-000001.depth.png", color_image(1));
  EXPECT_THAT(open_recording(root)->read(1).skipped.reason, ::testing::HasSubstr("a colour picture; depth needs"));
}

}  // namespace
}  // namespace panoptic::test
