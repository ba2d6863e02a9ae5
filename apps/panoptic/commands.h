// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The subcommands. Each returns the process's exit code and throws Error or UsageError.
#pragma once

#include <memory>

#include "apps/panoptic/arguments.h"

namespace panoptic {

inline constexpr const char* kOutOfMemoryAdvice =
    "out of memory; use larger voxels (--set map.voxel_size_m=...) or fewer frames (--frames)";

int run(const Arguments& arguments);
int predict(const Arguments& arguments);
int doctor(const Arguments& arguments);
int check_network(const Arguments& arguments);
int evaluate(const Arguments& arguments);
int evaluate_trajectory(const Arguments& arguments);
int explain(const Arguments& arguments);
int simulate(const Arguments& arguments);
int benchmark(const Arguments& arguments);
int batch(const Arguments& arguments);
int view(const Arguments& arguments);
int export_web(const Arguments& arguments);
int map_info(const Arguments& arguments);
int map_mesh(const Arguments& arguments);
int map_query(const Arguments& arguments);
int map_regularize(const Arguments& arguments);
int map_rebuild(const Arguments& arguments);
int map_merge(const Arguments& arguments);
int map_diff(const Arguments& arguments);
int plan(const Arguments& arguments);

// Loads a map file; what its older format lacks is told in a line on stderr.
struct SavedMap;
SavedMap load_map_and_tell(const std::string& path);
// The surface of its map.
struct Mesh;
Mesh mesh_of(const SavedMap& saved);
// Writes "note: ..." on stderr, if there is anything to say.
void tell_note(const std::string& note);

// Opens the recording that the arguments name. What its files leave open and had to be taken for granted is told, and so is
// what no frame was made of. Without --no-preflight a sample of its frames is checked: what is impossible is refused, what is
// unlikely is told in a line that names the doctor. Throws Error.
class Dataset;
class Predictor;
struct PredictorReport;
std::unique_ptr<Dataset> open_checked(const Arguments& arguments);

// A path, or the name of a recording, as it is found from whatever folder; empty if it is.
std::string absolute_recording(const std::string& recording);

// The same for a run, which tracks the camera if it is asked to, or if the recording has no poses: then its frames have none.
struct OpenedRecording {
  std::unique_ptr<Dataset> dataset;
  std::unique_ptr<Dataset>
      given;  // a tracked recording once more, with its own poses; nullptr: it has none, or its frames have them
  bool is_tracked = false;
  bool frames_have_poses = true;

  const Dataset* given_poses() const { return frames_have_poses ? dataset.get() : given.get(); }
};
OpenedRecording open_to_map(const Arguments& arguments);

// Tells the warnings of a predictor, if there is one, that were not told yet; at the end of a run its notes too, and returns its
// report.
void tell_warnings(Predictor* predictor);
PredictorReport closing_report(Predictor* predictor);

// The range of --frames, or everything. Throws UsageError.
struct FrameRange;
FrameRange frame_range_from(const Arguments& arguments);

// Throws UsageError for options of a run that do not go together.
void require_possible(const Arguments& arguments);

// The truth of "sim:SEED...", from all of its frames. Throws Error.
struct ScanTruth;
ScanTruth simulated_truth(const std::string& simulation);

// The options --bind, --port and --token.
struct ViewerOptions;
ViewerOptions viewer_options_from(const Arguments& arguments);

// "enet.toml + yolo.toml"; empty without networks.
std::string networks_text(const NetworkOptions& options);

}  // namespace panoptic
