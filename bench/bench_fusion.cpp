// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The stages of the fusion side one by one, and the loops inside them, on a ball in a corner of two walls and a floor, seen at
// 640x480. On one thread, so that a kernel's time is its own; panoptic-bench measures whole runs on all of them.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>
#include <utility>

#include "panoptic/fusion/band_touch.h"
#include "panoptic/fusion/depth_tiles.h"
#include "panoptic/fusion/integrator.h"
#include "panoptic/fusion/label_tracker.h"
#include "panoptic/fusion/ray_fusion.h"
#include "panoptic/fusion/ray_walk.h"
#include "panoptic/fusion/reference_labels.h"
#include "panoptic/meshing/mesher.h"
#include "panoptic/parallel.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

constexpr float kBandVoxels = 4;
constexpr int kFrames = 6;
constexpr std::size_t kChunks = 32;

// The colour camera stands 4 cm beside the depth camera, as real ones do.
Frame corner(int index) {
  const test::Surface scene = test::nearest_of({test::sphere({0, 0, 0}, 0.5), test::plane(Vec3d::UnitY(), 0.5),
                                                test::plane(Vec3d::UnitX(), 1.2), test::plane(Vec3d::UnitZ(), 1.2)});
  const double angle = 3.5 + 0.1 * index;
  const Vec3d eye(2 * std::cos(angle), -0.9, 2 * std::sin(angle));
  Frame frame = test::render(scene, test::small_camera(640, 480), test::look_at(eye, {0, 0, 0}), index);
  frame.color_from_depth.translation() = Vec3d(-0.04, 0, 0);
  return frame;
}

// Tiles of segments, every fourth of them a wall.
Segmentation tiles(int count) {
  Segmentation result{Image<std::uint16_t>(640, 480), {}};
  const int side = std::max(1, static_cast<int>(std::lround(std::sqrt(count))));
  for (int s = 0; s < side * side; ++s) {
    const ClassId class_id{static_cast<std::uint16_t>(s % 4 == 3 ? 1 : 3)};
    result.segments.push_back({class_id, 0.9F, {{class_id, 1.0F}}});
  }
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u)
      result.segment_at(u, v) = static_cast<std::uint16_t>(1 + u * side / 640 + v * side / 480 * side);
  }
  return result;
}

// The scene mapped, and the last frame with what the map says of it.
struct World {
  World(int voxel_mm, int segment_count)
      : segments(tiles(segment_count)),
        map({static_cast<float>(voxel_mm) * 1e-3F, kBandVoxels}),
        labels(test::test_labels()),
        objects(labels.first_thing()),
        tracker({}, labels),
        registration({}) {
    Integrator integrator({}, map, labels.first_thing());
    for (int i = 0; i < kFrames; ++i) {
      frame = corner(i);
      registered = registration.apply(frame, segments);
      reference_labels(map, frame, registered, reference);
      ids = tracker.assign(registered, segments.segments, reference, i, objects);
      integrator.integrate(frame, registered, ids, map);
    }
  }

  FrameView view() const {
    const Camera& c = frame.depth_camera;
    return {{registered.depth.data(),
             registered.color.data(),
             ids.data(),
             c.width,
             c.height,
             static_cast<float>(c.fx),
             static_cast<float>(c.fy),
             static_cast<float>(c.cx),
             static_cast<float>(c.cy),
             {}},
            c,
            frame.world_from_camera.linear().cast<float>(),
            frame.world_from_camera.translation(),
            registered.farthest_m};
  }
  Band band() const { return {map.truncation_m(), map.voxel_size_m()}; }

  Segmentation segments;
  VoxelMap map;
  LabelSet labels;
  ObjectRegistry objects;
  LabelTracker tracker;
  Registration registration;
  Frame frame;
  RegisteredFrame registered;
  std::vector<LabelSlot> reference;
  std::vector<LabelSlot> ids;
};

// All benchmarks run on one thread.
World& world(int voxel_mm, int segment_count = 9) {
  set_thread_count(1);
  static std::map<std::pair<int, int>, World> worlds;
  const std::pair key(voxel_mm, segment_count);
  const auto found = worlds.find(key);
  if (found != worlds.end()) return found->second;
  return worlds.emplace(std::piecewise_construct, std::tuple(key), std::tuple(voxel_mm, segment_count)).first->second;
}

void registration(benchmark::State& state) {
  World& w = world(24);
  for (auto _ : state) benchmark::DoNotOptimize(w.registration.apply(w.frame, w.segments).readings);
}

void reference(benchmark::State& state) {
  World& w = world(static_cast<int>(state.range(0)));
  std::vector<LabelSlot> labels;
  for (auto _ : state) reference_labels(w.map, w.frame, w.registered, labels);
}

void tracking(benchmark::State& state) {
  World& w = world(24, static_cast<int>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(w.tracker.assign(w.registered, w.segments.segments, w.reference, kFrames, w.objects).data());
  }
}

void touching(benchmark::State& state) {
  const World& w = world(static_cast<int>(state.range(0)));
  std::array<std::vector<std::uint64_t>, kChunks> keys;
  for (auto _ : state) touch_bands(w.view(), w.band(), w.map.block_size_m(), keys);
}

void integration(benchmark::State& state, const std::string& method) {
  World& w = world(static_cast<int>(state.range(0)));
  VoxelMap map({w.map.voxel_size_m(), kBandVoxels});
  Integrator integrator({method}, map, w.labels.first_thing());
  for (auto _ : state) integrator.integrate(w.frame, w.registered, w.ids, map);
  state.counters["blocks"] = static_cast<double>(map.block_count());
}

// Touching is left out: the blocks of the map are updated by projection, one after the other.
void update_blocks(benchmark::State& state) {
  World& w = world(static_cast<int>(state.range(0)));
  const FrameView view = w.view();
  DepthTiles tiles;
  for (auto _ : state) {
    tiles.build(view.pixels, w.band());
    for (Slot slot = 0; slot < w.map.block_count(); ++slot) {
      const BlockInCamera place = view.in_camera(w.map.index_of(slot), w.map.voxel_size_m());
      integrate_block(view.pixels, place, w.band(), bricks_in_band(view.pixels, tiles, place, w.band()), w.map.block(slot));
    }
  }
  const auto voxels = static_cast<double>(w.map.block_count()) * kBlockVoxels;
  state.counters["per_voxel"] =
      benchmark::Counter(voxels, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void ray_walk(benchmark::State& state) {
  const auto walks = std::make_unique<CellWalks>();
  for (std::size_t k = 0; k < kWalkLanes; ++k) {
    for (std::size_t a = 0; a < 3; ++a) {
      walks->start[a][k] = static_cast<float>(a) + 0.37F * static_cast<float>(k);
      walks->end[a][k] = walks->start[a][k] + 4.9F - 0.31F * static_cast<float>((k * (a + 1)) % 16);
    }
  }
  for (auto _ : state) {
    walk_together(*walks);
    benchmark::ClobberMemory();
  }
}

void ray_collection(benchmark::State& state) {
  const World& w = world(static_cast<int>(state.range(0)));
  RayTable table;
  table.resize(w.registered.pixel_count());
  PassageLists lists;
  for (auto _ : state) {
    lists.clear();
    collect_passages(w.view(), {0, 480}, {w.band(), w.map.voxel_size_m()}, table, lists);
  }
}

void marching_cubes(benchmark::State& state) {
  const World& w = world(static_cast<int>(state.range(0)));
  std::size_t triangles = 0;
  for (auto _ : state) {
    triangles = 0;
    for (Slot slot = 0; slot < w.map.block_count(); ++slot)
      triangles += extract_chunk(w.map, w.objects, slot, 1e-4F).triangles.size();
  }
  state.counters["triangles"] = static_cast<double>(triangles);
}

BENCHMARK(registration)->Unit(benchmark::kMicrosecond);
BENCHMARK(reference)->ArgName("mm")->Arg(24)->Arg(10)->Unit(benchmark::kMicrosecond);
BENCHMARK(tracking)->ArgName("segments")->Arg(9)->Arg(100)->Unit(benchmark::kMicrosecond);
BENCHMARK(touching)->ArgName("mm")->Arg(24)->Arg(10)->Unit(benchmark::kMicrosecond);
BENCHMARK(update_blocks)->ArgName("mm")->Arg(24)->Arg(10)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(integration, projective, "projective")->ArgName("mm")->Arg(24)->Arg(10)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(integration, raycast, "raycast")->ArgName("mm")->Arg(24)->Unit(benchmark::kMicrosecond);
BENCHMARK(ray_walk)->Unit(benchmark::kNanosecond);
BENCHMARK(ray_collection)->ArgName("mm")->Arg(24)->Unit(benchmark::kMicrosecond);
BENCHMARK(marching_cubes)->ArgName("mm")->Arg(24)->Arg(10)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace panoptic

BENCHMARK_MAIN();
