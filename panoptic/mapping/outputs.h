// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The files that a run leaves on disk: mesh.ply, scene.glb, views/*.png, objects.json, trajectory.txt, report.json,
// options.toml (docs/outputs.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "panoptic/base/json.h"
#include "panoptic/mapper.h"
#include "panoptic/online.h"
#include "panoptic/source.h"

namespace panoptic {

// Facts about the run that the mapper itself does not know.
struct RunSummary {
  std::string dataset;      // its description
  std::string recording;    // what open_dataset takes: an absolute path or "sim:SEED..."
  std::string calibration;  // absolute path of the file that was used; empty = none
  std::optional<double> pair_tolerance_s;
  RecordingNotes notes;    // of the recording
  std::string predictor;   // what made the labels, or "none"
  bool complete = true;    // false: interrupted or failed, the map holds the frames so far
  std::string stopped_by;  // why, if not complete
  double wall_s = 0;
  std::uint64_t without_prediction = 0;  // frames used that had none, although there was a predictor
  std::optional<OnlineReport> online;    // of an online run
  bool pictures = true;                  // false: no views/; pictures that an earlier run left there are removed
};

// The two reports as JSON; `mesh` is the mapper's.
Json objects_json(const Mapper& mapper, const Mesh& mesh);
Json report_json(const Mapper& mapper, const Options& options, const RunSummary& run, const Mesh& mesh);

// How much there is in what was written.
struct WrittenMap {
  std::size_t triangles = 0;
  std::size_t labelled_vertices = 0;  // of a class that a prediction gave, not of an object that was found by its shape alone
};

// Writes everything into the folder, each file whole or not at all, report.json last: a report that says "complete" has all
// of its files beside it. Throws Error at the first file that cannot be written; files written by then stay.
WrittenMap write_outputs(const std::filesystem::path& folder, Mapper& mapper, const Options& options, const RunSummary& run);

}  // namespace panoptic
