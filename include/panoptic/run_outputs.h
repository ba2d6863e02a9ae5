// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A mapper's results on disk: the folder that `panoptic run` leaves (docs/outputs.md), and the map file (docs/map_format.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/map_file.h"
#include "panoptic/mapper.h"
#include "panoptic/online.h"
#include "panoptic/options.h"
#include "panoptic/pose_update.h"
#include "panoptic/source.h"
#include "panoptic/tracked_run.h"

namespace panoptic {

// One recording of a list (docs/datasets.md) that was mapped. Its own frame n is frame first_number + n of the run.
struct RunRecording {
  std::string recording;    // as RunSummary
  std::string calibration;  // as RunSummary
  std::string predictions;  // absolute path; empty = none
  Pose world_from_recording = Pose::Identity();
  std::int64_t first_number = 0;
  std::size_t frames = 0;
};

// The recordings of a list, in their order; none if the dataset is not one.
std::vector<RunRecording> recordings_of(const Dataset& dataset);

// Facts about the run that the mapper itself does not know.
struct RunSummary {
  std::string dataset;                   // its description
  std::string recording;                 // what open_dataset takes: an absolute path or "sim:SEED..."
  std::string calibration;               // absolute path of the file that was used; empty = none
  std::vector<RunRecording> recordings;  // of a list
  std::optional<double> pair_tolerance_s;
  RecordingNotes notes;    // of the recording
  std::string predictor;   // what made the labels, or "none"
  bool complete = true;    // false: interrupted or failed, the map holds the frames so far
  std::string stopped_by;  // why, if not complete
  double wall_s = 0;
  std::uint64_t without_prediction = 0;    // frames used that had none, although there was a predictor
  std::optional<OnlineReport> online;      // of an online run
  std::vector<Correction> corrections;     // of poses, in their order
  std::optional<TrackingReport> tracking;  // of a run whose poses were tracked
  bool pictures = true;                    // false: no views/; pictures that an earlier run left there are removed
};

// How much there is in what was written.
struct WrittenMap {
  std::size_t triangles = 0;
  std::size_t labelled_vertices = 0;  // of a class that a prediction gave, not of an object that was found by its shape alone
};

// Writes everything into the folder, each file whole or not at all, report.json last: a report that says "complete" has all
// of its files beside it. Throws Error at the first file that cannot be written; files written by then stay.
WrittenMap write_outputs(const std::filesystem::path& folder, Mapper& mapper, const Options& options, const RunSummary& run);

// Saves the map as it is now: load_map, info, mesh, query, eval, view, merge and diff work on it; a run cannot go on from it.
// `options`: those of the mapper. The file appears whole or not at all, and replaces an older one unless somebody writes that.
// Its frames are those of FrameStatistics::trajectory. Throws Error.
void save_map(const std::filesystem::path& path, const Mapper& mapper, const Options& options);

// All options as TOML that load_options takes back to the same values, with a line of help before each.
std::string to_toml(const Options& options);

// The options of the run that made a map file. Throws Error if they are not as this program writes them.
Options options_of(const SavedMap& saved);

// Upwards in the world of a map file, as the cameras were mostly held; nothing if the file does not say.
std::optional<Vec3d> noted_up(const SavedMap& saved);

}  // namespace panoptic
