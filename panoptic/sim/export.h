// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A simulated home as a ScanNet scan on disk, with predictions beside it (docs/simulator.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "panoptic/base/config.h"
#include "panoptic/sim/prediction_noise.h"
#include "panoptic/sim/simulation.h"

namespace panoptic {

struct ExportOptions {
  std::string seed = "1";  // a whole number of 64 bits
  int rooms = 4;
  int frames = 0;                        // 0 = as many as the way takes at 30 Hz
  std::string noise = "kinect";          // sensor_noise_preset
  std::string dynamics = "static";       // dynamics_of
  int jumps = 0;                         // as SimulationOptions
  std::string predictions = "maskrcnn";  // the preset that prediction_noise came from, for people; "none" = no predictions
  PredictionNoise prediction_noise = prediction_noise_preset("maskrcnn");
  int jpeg_quality = 95;
  int truth_stride = 0;  // every how many frames enter the ground-truth mesh; 0 = about 600 frames
};
Fields fields(ExportOptions& options);
// Takes a preset of predictions with its noise, or "none". Throws Error for any other name.
void set_predictions(ExportOptions& options, const std::string& preset);

// The options of the simulation. Throws Error for a seed or a noise that is none.
SimulationOptions simulation_options(const ExportOptions& options);

// Hears how many frames are done; false ends the export.
using ExportWatch = std::function<bool(std::size_t frames_done)>;

// Writes the scan to `folder`, which must be absent or empty. Everything is written to `<folder>.partial` and renamed at the end;
// that one is removed if the watch ends the export (then false is returned) or an Error is thrown (no permission, disk full,
// a folder that holds something). Frames are made and encoded in parallel ahead of writing, a bounded number at a time;
// the files are the same at any number of threads.
bool export_scan(const Simulation& simulation, const ExportOptions& options, const std::filesystem::path& folder,
                 const ExportWatch& watch);

// The number that ScanNet's category map gives the class of the scannet20 label set; 0 for kUnknown.
std::uint16_t scannet_category(ClassId class_id);

}  // namespace panoptic
