// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Maps frames that are in memory, several times over, and keeps how long each stage of each frame took.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/bench_frames.h"
#include "panoptic/base/json.h"
#include "panoptic/options.h"
#include "panoptic/profile.h"

namespace panoptic {

struct BenchSettings {
  Options options;
  int repeats = 3;
  int mesh_every = 10;         // frames between two incremental meshes
  int copies = 1;              // the recording is mapped this many times side by side, for a larger map
  std::filesystem::path mesh;  // where the last full mesh is written, if anywhere
};

// Milliseconds, one entry per frame (or per mesh): the smallest of the repeats, which is what the work takes when nothing else
// runs. The work is the same in every repeat, bit for bit.
using StageTimes = std::map<std::string, std::vector<double>>;

// One copy of the recording: what a frame of it took with the map as large as it was at its end.
struct CopyTimes {
  double fusion_p50_ms = 0;
  std::size_t map_blocks = 0;
};

// The amount of work in a frame: means over ten frames, each mapped alone.
struct FrameWork {
  double pixels = 0;
  double color_pixels = 0;
  double touched_voxels = 0;  // of blocks near the surface
  double band_voxels = 0;     // of those, the ones that the frame updates
};

struct BenchResult {
  StageTimes stages;  // the mapper's stages; mesh_incremental, mesh_full; fusion_cpu: time on all threads together
  std::vector<double> repeat_p50_ms;  // the stage "fusion" alone, as each repeat had it
  std::vector<CopyTimes> copies;      // more than one if more were asked for
  FrameWork work;
  std::size_t frames = 0;
  double segments_mean = 0;
  std::size_t blocks = 0;
  std::size_t map_bytes = 0;
  std::size_t observed_voxels = 0;
  std::size_t mesh_triangles = 0;
  double peak_rss_mb = 0;  // of the process while it maps, less the decoded frames
  std::uint64_t map_hash = 0;
};

// Threads as set_thread_count says. Throws Error if repeats give different maps.
BenchResult run_bench(const BenchFrames& recording, const BenchSettings& settings);

// The value that a share p (0..1) of the samples does not exceed. REQUIRES samples.
double quantile(std::vector<double> samples, double p);

}  // namespace panoptic
