// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A recording decoded into memory, so that a measurement measures fusion and nothing else.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/data/frame.h"
#include "panoptic/data/labels.h"
#include "panoptic/data/segmentation.h"
#include "panoptic/io/dataset.h"

namespace panoptic {

struct BenchFrame {
  Frame frame;
  Segmentation segmentation;
};

struct BenchFrames {
  std::string description;
  LabelSet labels;
  std::vector<BenchFrame> frames;
  std::size_t bytes = 0;  // of all images
};

struct BenchSource {
  std::string recording;  // as open_dataset takes it
  std::filesystem::path calibration;
  FrameRange range;
  std::filesystem::path predictions;  // empty: seeded labels
  std::uint64_t seed = 1;
};

// Throws Error if nothing usable is there.
BenchFrames load_bench_frames(const BenchSource& source);

}  // namespace panoptic
