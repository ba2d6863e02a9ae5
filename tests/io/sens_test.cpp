// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <thread>

#include "panoptic/error.h"
#include "panoptic/source.h"
#include "tests/fresh_folder.h"
#include "tests/io/recordings.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::size_t kFrameHeaderBytes = 64 + 32;

fs::path write_sens(const std::string& bytes) {
  fs::path path = fresh_folder("sens") / "scene.sens";
  write_text(path, bytes);
  return path;
}

std::string error_of(const std::string& bytes) {
  try {
    open_recording(write_sens(bytes));
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

std::string reason(const SensFields& fields, std::size_t position) {
  const ReadResult result = open_recording(write_sens(sens_bytes(fields)))->read(position);
  return result.frame ? "frame" : result.skipped.reason;
}

TEST(SensReader, ReadsEveryCompression) {
  for (const std::int32_t color : {0, 1, 2}) {
    for (const std::int32_t depth : {0, 1}) {
      const auto dataset = open_recording(write_sens(sens_bytes({.color_compression = color, .depth_compression = depth})));
      EXPECT_EQ(dataset->description(), "ScanNet .sens, 4 frames, depth 32x24, colour 48x36");
      for (int i = 0; i < kFrameCount; ++i) expect_frame(dataset->read(static_cast<std::size_t>(i)), i, 1000, color == 2 ? 6 : 0);
      const Frame frame = *dataset->read(3).frame;
      EXPECT_EQ(frame.depth_camera, depth_camera());
      EXPECT_EQ(frame.color_camera, color_camera());
      EXPECT_NEAR(frame.time_s, 0.3002, 1e-9);
    }
  }
}

TEST(SensReader, NeedsNoPosesForACameraThatIsTracked) {
  const auto dataset = open_without_poses(write_sens(sens_bytes({.lost_frame = 2})));
  for (std::size_t i = 0; i < 4; ++i) {
    const ReadResult result = dataset->read(i);
    ASSERT_TRUE(result.frame) << result.skipped.reason;
    EXPECT_TRUE(result.frame->world_from_camera.matrix().isIdentity(0));
    EXPECT_TRUE(dataset->pose(i)->matrix().isIdentity(0));
  }
}

TEST(SensReader, OpensTheOnlySensFileOfAFolder) {
  const fs::path path = write_sens(sens_bytes());
  EXPECT_EQ(open_recording(path.parent_path())->size(), 4U);
  write_text(path.parent_path() / "other.sens", "");
  EXPECT_THROW(open_recording(path.parent_path()), Error);
}

TEST(SensReader, AppliesDepthShiftAndDepthExtrinsics) {
  SensFields fields{.depth_shift = 5000};
  fields.depth_extrinsic(1, 3) = 0.25;
  const Frame frame = *open_recording(write_sens(sens_bytes(fields)))->read(1).frame;
  EXPECT_FLOAT_EQ(frame.depth(2, 0), static_cast<float>(raw_depth(1)(2, 0)) / 5000);
  EXPECT_TRUE(frame.world_from_camera.matrix().isApprox(pose_matrix(1) * fields.depth_extrinsic, 1e-5));
  EXPECT_NEAR(frame.color_from_depth.translation().y(), 0.25, 1e-6);
}

TEST(SensReader, SkipsFramesThatWereNotTracked) {
  EXPECT_EQ(reason({.lost_frame = 2}, 2), "pose is not finite");
  EXPECT_EQ(reason({.lost_frame = 2}, 3), "frame");
}

TEST(SensReader, SkipsDepthThatInflatesToAnotherSize) {
  const std::string expected = "depth image unreadable: its bytes do not make up the size in the header";
  const std::string bomb = zlib(std::string(std::size_t{64} << 20, '\0'));  // 64 KiB that become 64 MiB
  EXPECT_EQ(reason({.odd_frame = 1, .odd_blob = bomb}, 1), expected);
  EXPECT_EQ(reason({.odd_frame = 1, .odd_blob = zlib("short")}, 1), expected);
  EXPECT_EQ(reason({.odd_frame = 1, .odd_blob = "no zlib stream"}, 1), expected);
  EXPECT_EQ(reason({.odd_frame = 1, .odd_blob = ""}, 1), expected);
  EXPECT_EQ(reason({.depth_compression = 0, .odd_frame = 1, .odd_blob = "short"}, 1), expected);
  EXPECT_EQ(reason({.odd_frame = 1, .odd_blob = bomb}, 2), "frame");
}

TEST(SensReader, RefusesAFileCutOffAnywhereBeforeItsLastFrameEnds) {
  const std::string whole = sens_bytes({.imu_tail = false});
  ASSERT_EQ(error_of(whole), "no error");
  const fs::path path = write_sens(whole);
  for (std::size_t bytes = whole.size(); bytes-- > 0;) {
    const bool header = bytes <= kSensHeaderBytes + kFrameHeaderBytes + 8;
    if (!header && bytes % 13 != 0 && bytes + 16 < whole.size()) continue;
    fs::resize_file(path, bytes);
    try {
      open_recording(path);
      ADD_FAILURE() << "opened with " << bytes << " of " << whole.size() << " bytes";
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
  }
}

TEST(SensReader, NamesTheFrameInWhichTheFileIsCutOff) {
  const std::string whole = sens_bytes({.imu_tail = false});
  EXPECT_THAT(error_of(whole.substr(0, whole.size() - 1)), HasSubstr("in frame 3 of 4"));
}

TEST(SensReader, NeedsNoAccelerationRecords) {
  const std::string whole = sens_bytes();
  for (const std::size_t missing : {1U, 128U, 256U, 260U, 264U})
    EXPECT_EQ(error_of(whole.substr(0, whole.size() - missing)), "no error");
}

TEST(SensReader, RefusesHeadersThatLie) {
  const auto huge = std::numeric_limits<std::uint64_t>::max();
  EXPECT_THAT(error_of(sens_bytes({.version = 3})), HasSubstr("version 3, only version 4"));
  EXPECT_THAT(error_of(sens_bytes({.name_bytes = huge})), HasSubstr("name claims"));
  EXPECT_NE(error_of(sens_bytes({.name_bytes = 4096})), "no error");  // everything after the name is shifted
  EXPECT_THAT(error_of(sens_bytes({.color_compression = -1})), HasSubstr("colour compression -1 cannot be read"));
  EXPECT_THAT(error_of(sens_bytes({.depth_compression = 2})), HasSubstr("depth compression 2 cannot be read"));
  EXPECT_THAT(error_of(sens_bytes({.depth_shift = 0})), HasSubstr("depth shift 0"));
  EXPECT_THAT(error_of(sens_bytes({.depth_shift = std::numeric_limits<float>::quiet_NaN()})), HasSubstr("depth shift nan"));
  EXPECT_THAT(error_of(sens_bytes({.frames = huge})), HasSubstr("claims 18446744073709551615 frames"));
  EXPECT_THAT(error_of(sens_bytes({.frames = std::uint64_t{1} << 40})), HasSubstr("more than its"));
  EXPECT_THAT(error_of(sens_bytes({.frames = 5, .imu_tail = false})), HasSubstr("in frame 4 of 5"));
  EXPECT_THAT(error_of(sens_bytes({.odd_frame = 1, .odd_bytes = huge})), HasSubstr("frame 1 of 4 claims images of"));
  EXPECT_THAT(error_of(sens_bytes({.odd_frame = 3, .odd_bytes = 60U << 20})), HasSubstr("cut off"));
}

TEST(SensReader, RefusesImageSizesThatWouldTakeAllMemory) {
  std::string bytes = sens_bytes();
  constexpr std::size_t kSizes = kSensHeaderBytes - 8 - 4 - 8;  // depth width and height
  const std::uint32_t huge = 0xFFFFFFFF;
  std::memcpy(bytes.data() + kSizes, &huge, sizeof(huge));
  EXPECT_THAT(error_of(bytes), AllOf(HasSubstr("image sizes"), HasSubstr("not plausible")));
  const std::uint32_t none = 0;
  std::memcpy(bytes.data() + kSizes, &none, sizeof(none));
  EXPECT_THAT(error_of(bytes), HasSubstr("not plausible"));
}

TEST(SensReader, EveryFlippedByteOfTheHeaderIsReadOrRefused) {
  const std::string whole = sens_bytes();
  const fs::path path = write_sens(whole);
  for (std::size_t at = 0; at < kSensHeaderBytes + kFrameHeaderBytes; ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x81);
    write_text(path, bytes);
    try {
      const auto dataset = open_recording(path);
      for (std::size_t i = 0; i < dataset->size(); ++i) dataset->read(i);  // gives a frame or a reason
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("scene.sens")) << at;
    }
  }
}

TEST(SensReader, GivesTheSameFramesToSeveralThreads) {
  const auto dataset = open_recording(write_sens(sens_bytes()));
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int k = 0; k < 40; ++k) {
        const ReadResult result = dataset->read(static_cast<std::size_t>(k % kFrameCount));
        EXPECT_TRUE(result.frame && result.frame->color == color_image(k % kFrameCount));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace panoptic::test
