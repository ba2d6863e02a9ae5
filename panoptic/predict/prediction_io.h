// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Predictions on disk: a folder with predictions.json and, per frame, a 16-bit PNG and a JSON file (docs/predictions.md).
// Predictions are read exactly as they were written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "panoptic/labels.h"
#include "panoptic/segmentation.h"

namespace panoptic {

// Not thread-safe. Files are whole or absent; a frame's JSON comes last, so an interrupted run leaves only whole frames.
class PredictionWriter {
 public:
  // Creates the folder. `producer` tells a person what made the predictions. Throws Error if the folder cannot be written or
  // already holds predictions: frames of two runs must not mix.
  PredictionWriter(std::filesystem::path folder, LabelSet labels, std::string producer);

  // An empty segmentation (no prediction for the frame) writes nothing. Throws Error if the image differs in size from the
  // first one, if the segmentation contradicts itself or the label set, or if a file cannot be written.
  void write(std::int64_t frame_index, const Segmentation& segmentation);

 private:
  std::filesystem::path folder_;
  LabelSet labels_;
  std::string producer_;
  int width_ = 0;  // 0 until the first frame
  int height_ = 0;
};

struct PredictionFolder {
  std::filesystem::path path;
  LabelSet labels;
  int width = 0;
  int height = 0;
};

// Reads predictions.json. Throws Error if it is absent or wrong.
PredictionFolder open_predictions(const std::filesystem::path& folder);

// The prediction of one frame; empty where the folder has none. Throws Error naming the file if it is damaged or contradicts
// predictions.json.
Segmentation read_prediction(const PredictionFolder& folder, std::int64_t frame_index);

// The bytes of a PNG file after a look at its header: width and height as given, or at most 16384 each where 0 is
// given. Throws Error otherwise, before an image is allocated. Also for readers of other formats.
std::string read_png_bytes(const std::filesystem::path& path, int width, int height);

}  // namespace panoptic
