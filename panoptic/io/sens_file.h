// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The bytes of a .sens stream: header, frame headers, and blobs at their places. See docs/datasets.md.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/base/os.h"

namespace panoptic {

constexpr std::uint64_t kMaxSensBlobBytes = std::uint64_t{64} << 20;

enum class ColorCompression : std::int32_t { kRaw = 0, kPng = 1, kJpeg = 2 };
enum class DepthCompression : std::int32_t { kRaw = 0, kZlib = 1 };

using Matrix16 = std::array<float, 16>;

struct FrameHeader {
  Matrix16 pose{};
  std::uint64_t color_time_us = 0;
  std::uint64_t depth_time_us = 0;
  std::uint64_t color_bytes = 0;
  std::uint64_t depth_bytes = 0;
};
static_assert(sizeof(FrameHeader) == 16 * sizeof(float) + 4 * sizeof(std::uint64_t), "read as it is stored");

// The fields before the frames, in the order of the file.
struct StreamHeader {
  Matrix16 color_intrinsic{};
  Matrix16 color_extrinsic{};
  Matrix16 depth_intrinsic{};
  Matrix16 depth_extrinsic{};
  ColorCompression color_compression{};
  DepthCompression depth_compression{};
  std::uint32_t color_width = 0;
  std::uint32_t color_height = 0;
  std::uint32_t depth_width = 0;
  std::uint32_t depth_height = 0;
  float depth_shift = 0;  // raw / depth_shift = metres
  std::uint64_t frame_count = 0;
};

// The open file: reads at given places, from any thread.
class SensFile {
 public:
  explicit SensFile(const std::filesystem::path& path);  // throws Error

  const std::string& name() const { return name_; }
  std::uint64_t size() const { return size_; }

  // Both read at an offset; false, or nothing, if the file ends earlier. Throws FileError if the disk fails.
  bool read(std::uint64_t offset, void* to, std::uint64_t bytes) const;
  std::optional<std::vector<std::uint8_t>> read(std::uint64_t offset, std::uint64_t bytes) const;

 private:
  std::string name_;
  os::File file_;
  std::uint64_t size_ = 0;
};

// The contents of a file: header, and where every frame's header begins.
struct SensIndex {
  StreamHeader header;
  std::vector<std::uint64_t> frame_offsets;
};

// Walks over the frame headers without reading images and checks every size against the file's before memory is taken.
// Throws Error for a file that is cut off, lies about its sizes, or uses a compression that cannot be read.
SensIndex read_sens_index(const SensFile& file);

}  // namespace panoptic
