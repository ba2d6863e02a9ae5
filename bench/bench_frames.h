// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A recording decoded into memory, so that a measurement measures fusion and nothing else.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/seeded_labels.h"
#include "panoptic/frame.h"
#include "panoptic/labels.h"
#include "panoptic/segmentation.h"
#include "panoptic/source.h"

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
  SeededLabels seeded;
  double resize = 1;  // of images and cameras; labels are made up afterwards
};

// Throws Error if nothing usable is there.
BenchFrames load_bench_frames(const BenchSource& source);

// For programs of others: `folder`/frames.json (cameras, sizes, 4x4 poses row by row), depth.u16 (millimetres, 0 = none) and
// color.rgb, frame after frame. Throws Error if it cannot be written.
void write_raw_frames(const std::filesystem::path& folder, const BenchFrames& recording);

}  // namespace panoptic
