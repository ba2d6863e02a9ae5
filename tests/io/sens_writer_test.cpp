// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/sens_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include "panoptic/base/files.h"
#include "panoptic/io/sens.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const Camera kCamera{64, 48, 58.5, 57.5, 31.25, 23.75};

Frame test_frame(int index) {
  Frame frame;
  frame.index = index;
  frame.time_s = index / 30.0;
  frame.depth_camera = frame.color_camera = kCamera;
  frame.world_from_camera.translation() = Vec3d(0.1 * index, -2, 0.5);
  frame.world_from_camera.linear() = Eigen::AngleAxisd(0.3 * index, Vec3d(1, 2, 3).normalized()).toRotationMatrix();
  Image<float> depth(kCamera.width, kCamera.height);
  frame.color = Image<Rgb>(kCamera.width, kCamera.height, Rgb{200, 100, static_cast<std::uint8_t>(10 * index)});
  for (std::size_t i = 0; i < depth.size(); ++i)
    depth[i] = 0.5F + 0.0013F * static_cast<float>(i) + 0.1F * static_cast<float>(index);
  depth[0] = 0;
  depth[1] = 0.0004F;  // rounds to nothing
  depth[2] = 65.535F;
  depth[3] = 65.5358F;
  frame.depth = std::move(depth);
  return frame;
}

fs::path write_frames(const fs::path& path, int frames) {
  SensWriter writer(path, kCamera);
  for (int i = 0; i < frames; ++i) writer.write(encode_sens_frame(test_frame(i), 95));
  writer.finish();
  return path;
}

TEST(SensWriter, WritesWhatTheReaderReads) {
  const fs::path path = write_frames(fresh_folder() / "scene.sens", 5);
  const SensDataset dataset(path);
  ASSERT_EQ(dataset.size(), 5U);
  for (int i = 0; i < 5; ++i) {
    const Frame written = test_frame(i);
    const ReadResult result = dataset.read(static_cast<std::size_t>(i));
    ASSERT_TRUE(result.frame) << result.skipped.reason;
    const Frame& read = *result.frame;
    EXPECT_EQ(read.index, i);
    EXPECT_NEAR(read.time_s, written.time_s, 1e-6);
    EXPECT_EQ(read.depth_camera, kCamera);
    EXPECT_EQ(read.color_camera, kCamera);
    EXPECT_TRUE(read.world_from_camera.isApprox(written.world_from_camera, 1e-6));
    EXPECT_TRUE(read.color_from_depth.isApprox(Pose::Identity()));
    for (std::size_t p = 4; p < read.depth.size(); ++p) ASSERT_NEAR(read.depth[p], written.depth[p], 0.000501);
    EXPECT_NEAR(read.color(30, 20).g, 100, 4);
  }
}

TEST(SensWriter, KeepsToWhatSixteenBitsHold) {
  const SensDataset dataset(write_frames(fresh_folder() / "scene.sens", 1));
  const SharedImage<float> depth = dataset.read(0).frame->depth;
  EXPECT_EQ(depth[0], 0);
  EXPECT_EQ(depth[1], 0);
  EXPECT_EQ(depth[3], 0);  // beyond the range is no reading, never a wrapped one
}

TEST(SensWriter, TheSameFramesGiveTheSameBytes) {
  const fs::path folder = fresh_folder();
  EXPECT_EQ(read_file(write_frames(folder / "a.sens", 3)), read_file(write_frames(folder / "b.sens", 3)));
}

TEST(SensWriter, LeavesNothingUnlessFinished) {
  const fs::path folder = fresh_folder();
  {
    SensWriter writer(folder / "scene.sens", kCamera);
    writer.write(encode_sens_frame(test_frame(0), 95));
    EXPECT_FALSE(fs::exists(folder / "scene.sens"));
  }
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(SensWriter, NamesTheFileThatCannotBeMade) {
  EXPECT_THAT(error_of([] { SensWriter("/proc/no/scene.sens", kCamera); }), HasSubstr("cannot write /proc/no/scene.sens"));
}

TEST(SensWriter, SaysThatTheDiskIsFull) {
  const fs::path folder = fresh_folder();
  const pid_t child = fork();
  if (child == 0) {  // a file size limit acts as a full disk does, and must not outlive this test
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{20000, 20000};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      write_frames(folder / "scene.sens", 50);
      _exit(1);
    } catch (const Error& e) {
      _exit(std::string(e.what()).find("File too large") != std::string::npos && fs::is_empty(folder) ? 0 : 2);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace panoptic::test
