// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A recording decoded into memory, so that a measurement measures fusion and nothing else.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/seeded_labels.h"
#include "panoptic/frame.h"
#include "panoptic/labels.h"
#include "panoptic/predictor.h"
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

// The predictions that the source or its list of recordings names; nullptr: labels are made up.
std::unique_ptr<Predictor> predictor_of(const BenchSource& source, const Dataset& dataset);
LabelSet labels_of(const Predictor* predictor);

// Throws Error if nothing usable is there.
BenchFrames load_bench_frames(const BenchSource& source);

// Gives one frame after the other; nothing at the end.
using NextFrame = std::function<std::optional<BenchFrame>()>;

// The recording again and again without end, with numbers and time stamps that go on. It must outlive the result.
NextFrame again_and_again(const BenchFrames& recording);

// The usable frames of the dataset, read as they are asked for. Both must outlive the result.
NextFrame streamed(const BenchSource& source, const Dataset& dataset, Predictor* predictor);

// For programs of others: `folder`/frames.json (cameras, sizes, 4x4 poses row by row), depth.u16 (millimetres, 0 = none) and
// color.rgb, frame after frame. Throws Error if it cannot be written.
void write_raw_frames(const std::filesystem::path& folder, const BenchFrames& recording);

}  // namespace panoptic
