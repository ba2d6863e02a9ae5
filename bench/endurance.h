// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A long run, looked at from time to time: what grows with the frames, and what with the map alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/bench_frames.h"
#include "panoptic/options.h"

namespace panoptic {

struct EnduranceSettings {
  Options options;
  std::size_t frames = 0;  // at most
  std::size_t every = 1000;
  std::filesystem::path save;  // the map is saved there each time, for its size; empty: it is not
};

// How things stood after so many frames. Times are means over the frames since the look before.
struct EnduranceLook {
  std::size_t frames = 0;
  double cpu_ms = 0;                        // of the thread that maps: all that Mapper::add does
  std::map<std::string, double> stages_ms;  // elapsed, a frame
  double rss_mb = 0;                        // of the process
  double map_mb = 0;
  std::size_t blocks = 0;
  std::size_t observed_voxels = 0;
  std::size_t objects = 0;
  std::uint64_t ids_given = 0;
  double file_mb = 0;  // 0: not saved
};

struct EnduranceResult {
  std::vector<EnduranceLook> looks;
  double peak_rss_mb = 0;  // of the process while it maps
  std::uint64_t map_hash = 0;
};

// REQUIRES set_thread_count(1): the time of one thread is all. Throws Error if no frame comes.
EnduranceResult endure(const NextFrame& next, const LabelSet& labels, const EnduranceSettings& settings);

}  // namespace panoptic
