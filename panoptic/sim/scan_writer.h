// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The files of an exported scan that grow with every frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/io/sens_writer.h"
#include "panoptic/predict/prediction_io.h"
#include "panoptic/sim/export.h"
#include "panoptic/sim/ground_truth.h"
#include "panoptic/sim/zip_writer.h"

namespace panoptic {

// A frame ready to be written.
struct ExportedFrame {
  std::size_t position = 0;
  SensFrame sens;
  std::vector<std::uint8_t> label_png;
  std::vector<std::uint8_t> instance_png;
  std::vector<std::uint8_t> moving_png;  // empty where nothing moves
  Segmentation prediction;               // empty: none
  Pose reported_pose = Pose::Identity();
  Pose true_pose = Pose::Identity();
  std::optional<SimulatedFrame> truth;  // where the frame enters the ground truth
};

// Makes a frame of the export, on any thread.
ExportedFrame make_frame(const Simulation& simulation, const ExportOptions& options, std::size_t position);

// Writes frames in their order, one thread at a time.
class ScanWriter {
 public:
  ScanWriter(std::filesystem::path folder, const Simulation& simulation, const ExportOptions& options);

  void write(const ExportedFrame& frame);
  void finish();

 private:
  std::filesystem::path stem(const std::string& suffix) const;

  std::filesystem::path folder_;
  const Simulation& simulation_;
  std::string scene_;
  SensWriter sens_;
  ZipWriter labels_;
  ZipWriter instances_;
  std::optional<PredictionWriter> predictions_;
  TruthBuilder truth_;
  std::string true_poses_;
  bool drifted_ = false;
};

}  // namespace panoptic
