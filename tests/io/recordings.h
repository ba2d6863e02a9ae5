// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes small recordings of every format: the same synthetic frames in each, so that what is read back is known.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"
#include "panoptic/io/calibration.h"
#include "panoptic/source.h"

namespace panoptic::test {

constexpr ImageSize kDepthSize{32, 24};
constexpr ImageSize kColorSize{48, 36};
constexpr int kFrameCount = 4;

// Frame i as it is stored. Depth holds a 0 at (0, 0) and a 65535 at (1, 0).
Image<std::uint16_t> raw_depth(int i, ImageSize size = kDepthSize);
Image<Rgb> color_image(int i, ImageSize size = kColorSize);
Eigen::Matrix4d pose_matrix(int i);
Camera depth_camera();
Camera color_camera();

std::string matrix_text(const Eigen::Matrix4d& matrix, const char* row_end = "\n");
std::string intrinsic_text(const Camera& camera);  // 3x3
void write_text(const std::filesystem::path& path, const std::string& text);
void write_depth(const std::filesystem::path& path, const Image<std::uint16_t>& image);  // PNG, PGM by the suffix
void write_color(const std::filesystem::path& path, const Image<Rgb>& image);            // PNG, JPEG by the suffix

// Depth equal to raw / scale, pose as pose_matrix(i), colour within a tolerance (JPEG is lossy).
void expect_frame(const ReadResult& result, int i, double depth_scale, int color_tolerance = 0, ImageSize color = kColorSize);

// The reason why a recording cannot be opened; "no error" if it can.
std::string error_of(const std::filesystem::path& path, const std::filesystem::path& calibration = {});

struct ScannetLayout {
  std::string folder;          // "" or "frames"
  std::string poses = "pose";  // or "poses"
  bool one_intrinsic = false;  // intrinsic.txt instead of intrinsic/*.txt
  std::vector<int> numbers = {0, 9, 10, 200};
};
void write_scannet_export(const std::filesystem::path& root, const ScannetLayout& layout = {});
void write_scannet_cpp_export(const std::filesystem::path& root);
void write_seven_scenes(const std::filesystem::path& folder, const std::string& color_suffix = ".png");
void write_tum(const std::filesystem::path& root);
void write_icl(const std::filesystem::path& root);
void write_replica(const std::filesystem::path& root);
void write_plain_folder(const std::filesystem::path& root);

// A .sens stream; the fields that tests lie about.
struct SensFields {
  std::uint32_t version = 4;
  std::int32_t color_compression = 1;
  std::int32_t depth_compression = 1;
  ImageSize depth = kDepthSize;
  float depth_shift = 1000;
  std::uint64_t frames = kFrameCount;
  std::uint64_t name_bytes = 11;
  Eigen::Matrix4d depth_extrinsic = Eigen::Matrix4d::Identity();
  bool imu_tail = true;
  int lost_frame = -1;  // its pose is -inf
  int odd_frame = -1;   // its depth blob is odd_blob,
  std::string odd_blob;
  std::uint64_t odd_bytes = 0;  // or claims this many bytes
};
std::string sens_bytes(const SensFields& fields = {});
constexpr std::size_t kSensHeaderBytes = 4 + 8 + 11 + 4 * 64 + 8 + 16 + 4 + 8;  // up to the first frame
std::string zlib(const std::string& bytes);

}  // namespace panoptic::test
