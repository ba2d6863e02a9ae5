// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/ground_truth.h"

#include <fmt/format.h>

#include <algorithm>

#include "panoptic/meshing/mesher.h"
#include "panoptic/objects.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

const MapOptions kTruthMap{.voxel_size_m = 0.02F};
constexpr double kFarthest_m = 0.05;

// Without what is there for a while only: the truth is the surface at the end, wherever a frame showed it.
Image<float> lasting_depth(const Rendering& rendering) {
  Image<float> depth = rendering.depth;
  for (std::size_t i = 0; i < rendering.fate.size(); ++i) {
    if (rendering.fate[i] != Fate::kStays) depth[i] = 0;
  }
  return depth;
}

void label_vertices(const Renderer& renderer, ScanTruth& truth) {
  constexpr std::size_t kChunk = 2048;
  const std::size_t count = truth.positions.size();
  parallel_for((count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
      const auto surface = renderer.nearest(truth.positions[i].cast<double>(), kFarthest_m);
      if (!surface) continue;
      truth.class_id[i] = surface->class_id;
      truth.instance[i] = surface->class_id == ClassId::kUnknown ? std::uint16_t{0} : surface->instance;
    }
  });
}

}  // namespace

std::string scene_name(std::uint64_t seed) { return fmt::format("scene{:04}_00", seed); }

TruthBuilder::TruthBuilder()
    : map_(kTruthMap, load_label_set("scannet20")),
      registration_(DepthOptions{}),
      integrator_(IntegratorOptions{}, map_.voxels) {}

void TruthBuilder::add(const SimulatedFrame& simulated) {
  Frame frame;
  frame.index = simulated.frame.index;
  frame.depth_camera = frame.color_camera = simulated.frame.depth_camera;
  frame.world_from_camera = simulated.true_world_from_camera;
  frame.depth = lasting_depth(simulated.rendering);
  frame.color = simulated.rendering.color;
  const RegisteredFrame& registered = registration_.apply(frame, {});
  if (registered.readings == 0) return;
  no_votes_.assign(registered.pixel_count() + 1, LabelSlot::kNoVote);
  integrator_.integrate(frame, registered, no_votes_, map_.voxels);
}

ScanTruth TruthBuilder::finish(const Simulation& simulation) const {
  Mesher mesher(MesherOptions{});
  mesher.update(map_);
  Mesh mesh = mesher.assemble(map_);
  ScanTruth truth;
  truth.scene = scene_name(simulation.options().seed);
  for (const MeshVertex& vertex : mesh.vertices) {
    truth.positions.push_back(vertex.position);
    truth.colors.push_back(vertex.color);
  }
  truth.triangles = std::move(mesh.triangles);
  truth.class_id.assign(truth.positions.size(), ClassId::kUnknown);
  truth.instance.assign(truth.positions.size(), 0);
  label_vertices(simulation.renderer(), truth);
  for (std::size_t i = 0; i < truth.instance.size(); ++i) {
    if (truth.instance[i] != 0) truth.names.try_emplace(truth.instance[i], map_.labels.name_of(truth.class_id[i]));
  }
  return truth;
}

ScanTruth ground_truth(const Simulation& simulation, std::size_t stride) {
  TruthBuilder builder;
  for (std::size_t i = 0; i < simulation.size(); i += std::max<std::size_t>(stride, 1)) builder.add(simulation.simulate(i));
  return builder.finish(simulation);
}

}  // namespace panoptic
