// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The CRF on a wavy sheet of patches with noise: what five iterations take, with the filters built anew each time, and what a
// map's first and later runs take. "agreement" is the share of voxels that get the label of the naive mean field, on a sheet of
// 1,100 voxels of the same kind; with random labels everywhere (noise 100 %) there is nothing right to agree on.
#include <benchmark/benchmark.h>

#include <cmath>

#include "panoptic/crf/regularizer.h"
#include "panoptic/profile.h"
#include "tests/crf/crf_graphs.h"

namespace panoptic {
namespace {

using test::Sheet;

double agreement(const Sheet& like, const MeanFieldSettings& settings) {
  Sheet small = like;
  small.side = 14;
  small.patch = 5;
  const CrfGraph graph = test::sheet_graph(small, 5);
  const auto expected = test::naive_mean_field(graph, settings, 5);
  MeanFieldScratch scratch;
  MeanField field(graph, settings, scratch);
  for (int i = 0; i < 5; ++i) field.iterate();
  double same = 0;
  for (std::size_t v = 0; v < graph.size(); ++v) same += field.best(v).label == test::argmax(expected[v]) ? 1 : 0;
  return same / static_cast<double>(graph.size());
}

// Labels, noise in percent, weights of the paper (1) or the defaults (0).
void mean_field(benchmark::State& state) {
  const Sheet sheet{.side = 112,
                    .thickness = 8,
                    .patch = 15,
                    .labels = static_cast<std::size_t>(state.range(0)),
                    .noise = static_cast<float>(state.range(1)) / 100.0F};
  const MeanFieldSettings settings{state.range(2) != 0 ? 10.0F : 4.0F, state.range(2) != 0 ? 15.0F : 4.0F, 2.083F, 20};
  const CrfGraph graph = test::sheet_graph(sheet, 5);
  std::size_t bytes = 0;
  MeanFieldScratch scratch;
  for (auto _ : state) {
    MeanField field(graph, settings, scratch, {.parallel = true});
    for (int i = 0; i < 5; ++i) field.iterate();
    benchmark::DoNotOptimize(field.best(0));
    bytes = field.memory_bytes();
  }
  state.counters["voxels"] = static_cast<double>(graph.size());
  state.counters["MB"] = static_cast<double>(bytes) / 1e6;
  state.counters["agreement"] = agreement(sheet, settings);
}
BENCHMARK(mean_field)
    ->ArgNames({"labels", "noise", "paper"})
    ->ArgsProduct({{8, 20, 100}, {20}, {0, 1}})
    ->Args({20, 100, 1})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

// A map that holds the sheet, `thickness` voxels deep.
VoxelMap sheet_map(const Sheet& sheet) {
  VoxelMap map({});
  const CrfGraph graph = test::sheet_graph(sheet, 5);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const GridPoint& p = graph.points[i];
    const int depth = p.z - static_cast<int>(std::lround(0.35 * p.x + 6 * std::sin(0.11 * p.y)));
    VoxelBlock& block = map.block(map.allocate({p.x >> 4, p.y >> 4, p.z >> 4}));
    const auto channel = [&](std::size_t c) { return static_cast<std::uint16_t>(256 * graph.colors[i][c]); };
    block.set(voxel_offset(p.x & 15, p.y & 15, p.z & 15),
              {(static_cast<float>(depth) - 3.5F) * map.voxel_size_m(), 10, 10 * (2 * graph.probabilities[i] - 1), 10,
               graph.labels[i], channel(0), channel(1), channel(2)});
  }
  return map;
}

// Share of the blocks that changed in percent, all voxels and weights as in the paper (1) or the defaults (0).
void whole_map(benchmark::State& state) {
  RegularizerOptions options;
  if (state.range(1) != 0) {
    options.w1 = 10;
    options.w2 = 15;
    options.band_voxels = 4;
  }
  std::size_t blocks = 0;
  for (auto _ : state) {
    VoxelMap map = sheet_map({.side = 212, .thickness = 8, .patch = 15, .labels = 60, .noise = 0.2F});
    Regularizer regularizer(options, map);
    blocks = map.block_count();
    if (state.range(0) < 100) {
      regularizer.run(map);
      map.begin_epoch();
      for (Slot slot = 0; slot < blocks * static_cast<std::size_t>(state.range(0)) / 100; ++slot) map.mark_changed(slot);
    }
    const Stopwatch stopwatch;
    benchmark::DoNotOptimize(regularizer.run(map));
    state.SetIterationTime(stopwatch.seconds());
  }
  state.counters["blocks"] = static_cast<double>(blocks);
  state.counters["peak_MB"] = peak_rss_mb();
}
BENCHMARK(whole_map)
    ->ArgNames({"changed", "paper"})
    ->ArgsProduct({{100, 30}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseManualTime();

}  // namespace
}  // namespace panoptic

BENCHMARK_MAIN();
