// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_frames.h"

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "bench/seeded_labels.h"
#include "panoptic/base/error.h"
#include "panoptic/base/parallel.h"
#include "panoptic/predict/predictor_files.h"
#include "panoptic/session/open_dataset.h"

namespace panoptic {
namespace {

constexpr const char* kSeededLabelSet = "indoor";

std::size_t image_bytes(const BenchFrame& f) {
  return f.frame.depth.size() * sizeof(float) + f.frame.color.size() * sizeof(Rgb) +
         f.segmentation.segment_at.size() * sizeof(std::uint16_t);
}

}  // namespace

BenchFrames load_bench_frames(const BenchSource& source) {
  const auto dataset = open_dataset(source.recording, source.calibration);
  const auto predictor = source.predictions.empty() ? nullptr : make_file_predictor(source.predictions);
  BenchFrames result{dataset->description(), predictor ? predictor->labels() : load_label_set(kSeededLabelSet), {}, 0};
  FrameStream stream(*dataset, source.range);
  while (std::optional<ReadResult> read = stream.next()) {
    if (!read->frame || why_unusable(*read->frame)) continue;
    BenchFrame& f = result.frames.emplace_back();
    f.frame = std::move(*read->frame);
    if (predictor) f.segmentation = predictor->predict(f.frame);
  }
  if (result.frames.empty()) throw Error(fmt::format("{}: no frame is usable; panoptic doctor says why", source.recording));
  if (!predictor) {
    parallel_for(result.frames.size(), [&](std::size_t i) {
      BenchFrame& f = result.frames[i];
      f.segmentation = seeded_labels(f.frame, result.labels, source.seed);
    });
  }
  for (const BenchFrame& f : result.frames) result.bytes += image_bytes(f);
  return result;
}

}  // namespace panoptic
