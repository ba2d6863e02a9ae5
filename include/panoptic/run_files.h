// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The files of a run (docs/outputs.md) read back, for whoever scores, shows or explains it. Every function takes the folder, and
// throws Error that names the file if it is absent, or the place in the file where a value is not as documented.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/mesh.h"
#include "panoptic/objects.h"

namespace panoptic {

// report.json.
struct RunReport {
  struct Stage {
    std::uint64_t count = 0;
    double mean_ms = 0;
    double p50_ms = 0;
    double p95_ms = 0;
  };

  std::string dataset;
  std::string recording;    // empty: not written down, by an early version
  std::string calibration;  // empty: none
  std::optional<double> pair_tolerance_s;
  bool tracked = false;  // its poses were found by the run
  std::string predictor;
  bool complete = true;
  std::string stopped_by;
  std::uint64_t frames_used = 0;
  std::uint64_t frames_skipped = 0;
  std::uint64_t without_prediction = 0;
  double wall_s = 0;
  double peak_rss_mb = 0;
  std::map<std::string, Stage> stages;
  Vec3d up = Vec3d::Zero();
  LabelSet labels;
  double voxel_size_m = 0;
};

// An object of objects.json.
struct RunObject {
  struct Votes {
    std::int64_t first_frame = 0;
    std::vector<std::pair<std::string, std::uint64_t>> of_class;  // the most frequent first
  };
  struct View {
    std::int64_t frame = 0;
    std::string class_name;
    double score = 0;
    std::uint64_t visible_px = 0;
    PixelBox box;
  };

  PanopticId id = PanopticId::kUnknown;
  ClassId class_id = ClassId::kUnknown;
  std::string class_name;
  std::vector<std::pair<std::string, double>> probabilities;  // the most probable first
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
  std::uint64_t observations = 0;
  std::uint64_t vertices = 0;
  Vec3d min_m = Vec3d::Zero();
  Vec3d max_m = Vec3d::Zero();
  Vec3d size_m = Vec3d::Zero();  // of the oriented box
  double area_m2 = 0;
  std::uint64_t frames_per_bin = 0;
  std::vector<Votes> votes;          // by bin, in order; none in the file of an early version
  std::vector<View> best_views;      // the best first; none in the file of an early version
  std::vector<std::string> history;  // what object maintenance did to it, a line each
};

struct RunObjects {
  std::vector<RunObject> objects;                // in the file's order
  std::map<PanopticId, PanopticId> merged_into;  // which object an id that was merged away went to
};

RunReport read_run_report(const std::filesystem::path& folder);
RunObjects read_run_objects(const std::filesystem::path& folder);
Mesh read_run_mesh(const std::filesystem::path& folder);
// Where the camera was; none if there is no trajectory.txt.
std::vector<Vec3d> read_run_path(const std::filesystem::path& folder);

}  // namespace panoptic
