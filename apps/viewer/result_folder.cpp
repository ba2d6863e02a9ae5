// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/result_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/map/block_key.h"
#include "panoptic/run_files.h"
#include "panoptic/voxel_map.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

// One on every grid edge that the cells of a block have.
constexpr std::size_t kMostVerticesOfBlock = std::size_t{3} * (kBlockSide + 1) * (kBlockSide + 1) * (kBlockSide + 1);

RunState state_of(const RunReport& report) {
  RunState run;
  run.frames_used = report.frames_used;
  run.frames_done = report.frames_used + report.frames_skipped;
  run.frames_total = run.frames_done;
  const bool has_labels = report.predictor != "none";
  if (has_labels) run.frames_labelled = report.frames_used - std::min(report.frames_used, report.without_prediction);
  run.elapsed_s = report.wall_s;
  run.memory_mb = report.peak_rss_mb;
  run.finished = true;
  run.stopped_by = report.stopped_by;
  for (const auto& [name, stage] : report.stages) run.stages[name] = {stage.count, stage.p50_ms, stage.p95_ms, stage.mean_ms};
  return run;
}

SnapshotObject snapshot_object(const RunObject& from, const LabelSet& labels, const fs::path& folder) {
  SnapshotObject object;
  object.id = from.id;
  object.class_id = from.class_id;
  for (const auto& [name, p] : from.probabilities) {
    const LabelClass* label = labels.find(name);
    if (label == nullptr) {
      throw Error(fmt::format("{}: a probability of '{}', no class of report.json", (folder / "objects.json").string(), name));
    }
    object.probabilities.push_back({label->id, static_cast<float>(p)});
  }
  std::ranges::sort(object.probabilities, {}, &ClassProbability::class_id);
  object.first_frame = from.first_frame;
  object.last_frame = from.last_frame;
  object.observations = from.observations;
  object.vertices = from.vertices;
  object.min_m = from.min_m.cast<float>();
  object.max_m = from.max_m.cast<float>();
  return object;
}

// At most kMaxPathPoints of the points, evenly.
std::vector<Vec3f> thinned(const std::vector<Vec3d>& path) {
  const std::size_t stride = (path.size() + kMaxPathPoints - 1) / kMaxPathPoints;
  std::vector<Vec3f> points;
  for (std::size_t i = 0; i < path.size(); i += stride) points.emplace_back(path[i].cast<float>());
  return points;
}

// The block of the cell that holds the triangle. A cell spans from a voxel's centre to the next one's; a vertex may lie on its
// wall, whence the tolerance. Nothing if the triangle does not fit.
std::optional<BlockIndex> block_of(const std::array<Vec3d, 3>& corners, double voxel_size_m) {
  constexpr double kTolerance_voxels = 1e-3;
  const Vec3d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]) / voxel_size_m;
  const Vec3d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]) / voxel_size_m;
  const Eigen::Array3d block = ((low.array() - 0.5 + kTolerance_voxels) / kBlockSide).floor();
  const bool fits = (block.abs() <= kMaxBlockCoordinate).all() && (high.array() < (block + 2) * kBlockSide - 1).all();
  if (!fits) return std::nullopt;
  return BlockIndex{static_cast<std::int32_t>(block.x()), static_cast<std::int32_t>(block.y()),
                    static_cast<std::int32_t>(block.z())};
}

// The chunk's form of a vertex that is already smooth: inside its block, so that nobody looks for others on the same edge.
ChunkVertex chunk_vertex(const MeshVertex& v) {
  ChunkVertex vertex{};
  vertex.position = v.position;
  vertex.area_normal = v.normal;
  vertex.color = v.color;
  vertex.panoptic_id = v.panoptic_id;
  vertex.corner_x = vertex.corner_y = vertex.corner_z = 1;
  vertex.confidence = 255;
  return vertex;
}

}  // namespace

std::vector<SnapshotChunk> cut_into_chunks(const Mesh& mesh, double voxel_size_m) {
  std::map<std::uint64_t, std::vector<std::size_t>> triangles_of;  // by packed block index
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto corner = [&](std::size_t c) -> Vec3d { return mesh.vertices[mesh.triangles[t][c]].position.cast<double>(); };
    const auto block = block_of({corner(0), corner(1), corner(2)}, voxel_size_m);
    if (!block) throw Error(fmt::format("triangle {} is no surface of voxels of {} m", t, voxel_size_m));
    triangles_of[pack(*block)].push_back(t);
  }
  std::vector<SnapshotChunk> chunks;
  std::unordered_map<std::uint32_t, std::uint32_t> place_of;
  for (const auto& [block, triangles] : triangles_of) {
    auto chunk = std::make_shared<MeshChunk>();
    place_of.clear();
    for (const std::size_t t : triangles) {
      std::array<std::uint32_t, 3> corners = mesh.triangles[t];
      for (std::uint32_t& corner : corners) {
        const auto [at, is_new] = place_of.try_emplace(corner, static_cast<std::uint32_t>(chunk->vertices.size()));
        if (is_new) chunk->vertices.push_back(chunk_vertex(mesh.vertices[corner]));
        corner = at->second;
      }
      chunk->triangles.push_back(corners);
    }
    if (chunk->vertices.size() > kMostVerticesOfBlock) {
      throw Error(fmt::format("{} vertices in one block of 16 x 16 x 16 voxels are no surface", chunk->vertices.size()));
    }
    chunks.push_back({unpack(block), 1, std::move(chunk)});
  }
  return chunks;
}

OpenedResult open_result(const fs::path& folder) {
  const RunReport report = read_run_report(folder);
  OpenedResult result;
  SnapshotScene& scene = result.scene;
  scene.title = fs::absolute(folder / "").lexically_normal().parent_path().filename().string();
  scene.dataset = report.dataset;
  scene.labels = report.labels;
  scene.voxel_size_m = static_cast<float>(report.voxel_size_m);
  scene.block_size_m = scene.voxel_size_m * kBlockSide;
  scene.has_confidence = false;

  auto snapshot = std::make_shared<Snapshot>();
  snapshot->revision = 1;
  snapshot->run = state_of(report);
  if (report.up.norm() > 0.5) snapshot->up = report.up.normalized().cast<float>();
  for (const RunObject& object : read_run_objects(folder).objects) {
    if (object.vertices > 0) snapshot->objects.push_back(snapshot_object(object, scene.labels, folder));  // else it is gone
  }
  std::ranges::sort(snapshot->objects, {}, &SnapshotObject::id);
  const Mesh mesh = read_run_mesh(folder);
  try {
    snapshot->chunks = cut_into_chunks(mesh, scene.voxel_size_m);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", (folder / "mesh.ply").string(), e.what()));
  }
  snapshot->path_m = thinned(read_run_path(folder));
  try {
    result.history = read_run_history(folder, scene.labels);
  } catch (const Error& e) {
    result.note = fmt::format("the past is not shown: {}", e.what());
  }
  result.snapshot = std::move(snapshot);
  return result;
}

}  // namespace panoptic
