// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/fusion_run.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bench/process_memory.h"
#include "bench/stage_clock.h"
#include "panoptic/error.h"
#include "panoptic/map.h"
#include "panoptic/mapper.h"
#include "panoptic/meshing/mesher.h"
#include "panoptic/outputs.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

void keep_smallest(const StageTimes& times, StageTimes& smallest) {
  for (const auto& [name, samples] : times) {
    std::vector<double>& kept = smallest[name];
    if (kept.empty()) kept = samples;
    for (std::size_t i = 0; i < std::min(kept.size(), samples.size()); ++i) kept[i] = std::min(kept[i], samples[i]);
  }
}

double timed_ms(const auto& work) {
  const Stopwatch stopwatch;
  work();
  return stopwatch.seconds() * 1e3;
}

// The copies stand side by side, so far apart that they share nothing.
std::optional<Frame> moved_to_copy(const Frame& frame, std::size_t copy) {
  constexpr double kApart_m = 30;
  if (copy == 0) return std::nullopt;
  std::optional<Frame> moved = frame;
  moved->world_from_camera.translation().x() += kApart_m * static_cast<double>(copy);
  moved->index += static_cast<std::int64_t>(copy) * 1000000;
  return moved;
}

// `blocks`: of the map after each copy.
Mapper mapped(const BenchFrames& recording, const BenchSettings& settings, StageTimes& times, std::vector<std::size_t>& blocks) {
  Options options = settings.options;
  options.regularizer.enabled = false;  // runs every ten seconds, and bench_regularizer measures it
  Mapper mapper(options, recording.labels);
  Mesher mesher(options.mesher);
  StageClock clock;
  const std::size_t count = recording.frames.size() * static_cast<std::size_t>(settings.copies);
  for (std::size_t i = 0; i < count; ++i) {
    const BenchFrame& next = recording.frames[i % recording.frames.size()];
    const std::optional<Frame> moved = moved_to_copy(next.frame, i / recording.frames.size());
    const double cpu_before = cpu_seconds(CLOCK_PROCESS_CPUTIME_ID);
    const Outcome outcome = mapper.add(moved ? *moved : next.frame, next.segmentation);
    if (i % recording.frames.size() == recording.frames.size() - 1) blocks.push_back(mapper.map().voxels.block_count());
    if (!outcome.used) continue;
    times["fusion_cpu"].push_back((cpu_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_before) * 1e3);
    for (const auto& [name, ms] : clock.lap_ms(mapper.profile())) times[name].push_back(ms);
    if ((i + 1) % static_cast<std::size_t>(settings.mesh_every) != 0) continue;
    times["mesh_incremental"].push_back(timed_ms([&] { mesher.update(mapper.map()); }));
  }
  return mapper;
}

void finish(Mapper& mapper, const BenchSettings& settings, StageTimes& times, BenchResult& result) {
  Mesh mesh;
  times["mesh_full"].push_back(timed_ms([&] {
    Mesher mesher(settings.options.mesher);
    mesher.update(mapper.map());
    mesh = mesher.assemble(mapper.map());
  }));
  if (!settings.mesh.empty()) write_ply(settings.mesh, mesh);
  result.mesh_triangles = mesh.triangles.size();
  result.blocks = mapper.map().voxels.block_count();
  result.map_bytes = mapper.map().voxels.memory_bytes();
  result.observed_voxels = mapper.map().voxels.observed_voxels();
  const std::uint64_t hash = mapper.map().voxels.hash();
  if (result.map_hash != 0 && hash != result.map_hash) throw Error("two repeats gave different maps: this is a bug, report it");
  result.map_hash = hash;
}

std::vector<CopyTimes> by_copy(const std::vector<double>& fusion_ms, const std::vector<std::size_t>& blocks) {
  std::vector<CopyTimes> copies;
  const std::size_t frames = fusion_ms.size() / blocks.size();
  for (std::size_t c = 0; c < blocks.size(); ++c) {
    const auto first = fusion_ms.begin() + static_cast<std::ptrdiff_t>(c * frames);
    copies.push_back({quantile({first, first + static_cast<std::ptrdiff_t>(frames)}, 0.5), blocks[c]});
  }
  return copies;
}

FrameWork work_of(const BenchFrames& recording, const BenchSettings& settings) {
  constexpr std::size_t kSamples = 10;
  FrameWork work;
  const std::size_t samples = std::min(kSamples, recording.frames.size());
  for (std::size_t s = 0; s < samples; ++s) {
    const BenchFrame& f = recording.frames[recording.frames.size() * s / samples];
    Mapper mapper(settings.options, recording.labels);
    static_cast<void>(mapper.add(f.frame, f.segmentation));
    const double share = 1.0 / static_cast<double>(samples);
    work.pixels += share * static_cast<double>(f.frame.depth.size());
    work.color_pixels += share * static_cast<double>(f.frame.color.size());
    work.touched_voxels += share * static_cast<double>(mapper.map().voxels.block_count()) * kBlockVoxels;
    work.band_voxels += share * static_cast<double>(mapper.map().voxels.observed_voxels());
  }
  return work;
}

}  // namespace

BenchResult run_bench(const BenchFrames& recording, const BenchSettings& settings) {
  BenchResult result;
  std::vector<std::size_t> blocks;
  for (int repeat = 0; repeat < settings.repeats; ++repeat) {
    StageTimes times;
    if (repeat == 0) reset_peak_memory();
    blocks.clear();
    Mapper mapper = mapped(recording, settings, times, blocks);
    if (times["fusion"].empty()) throw Error("no frame could be fused: every one was refused");
    if (repeat == 0) result.peak_rss_mb = peak_memory_mb() - static_cast<double>(recording.bytes) / 1e6;
    finish(mapper, settings, times, result);
    result.repeat_p50_ms.push_back(quantile(times["fusion"], 0.5));
    keep_smallest(times, result.stages);
  }
  result.frames = result.stages["fusion"].size();
  result.copies = by_copy(result.stages["fusion"], blocks);
  result.work = work_of(recording, settings);
  for (const BenchFrame& f : recording.frames) {
    result.segments_mean += static_cast<double>(f.segmentation.segments.size()) / static_cast<double>(recording.frames.size());
  }
  return result;
}

double quantile(std::vector<double> samples, double p) {
  PANOPTIC_ASSERT(!samples.empty());
  std::sort(samples.begin(), samples.end());
  const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(samples.size())));
  return samples[std::clamp(rank, std::size_t{1}, samples.size()) - 1];
}

}  // namespace panoptic
