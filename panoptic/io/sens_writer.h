// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes ScanNet's .sens stream, version 4: JPEG colour, zlib depth in millimetres.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/frame.h"
#include "panoptic/io/sens_file.h"

namespace panoptic {

// One frame as the stream stores it.
struct SensFrame {
  FrameHeader header;
  std::vector<std::uint8_t> color;
  std::vector<std::uint8_t> depth;
};

// Encodes a frame. Depth is rounded to millimetres; depth beyond 65.535 m counts as no reading. Time in microseconds. May run
// on any thread. REQUIRES a usable frame with one camera for both images (color_from_depth is not stored), time_s >= 0, quality
// 1..100.
SensFrame encode_sens_frame(const Frame& frame, int jpeg_quality);

// Writes to a temporary file beside `path`, so memory does not grow; the final name appears with finish() and without it
// nothing is left. Not thread-safe. Everything throws Error naming the file (no permission, disk full).
class SensWriter {
 public:
  // `camera` is that of the frames, depth and colour alike.
  SensWriter(std::filesystem::path path, const Camera& camera);

  void write(const SensFrame& frame);
  void finish();

  std::uint64_t frames() const { return frames_; }

 private:
  PartialFile file_;
  std::uint64_t count_at_ = 0;  // where the number of frames stands
  std::uint64_t frames_ = 0;
};

}  // namespace panoptic
