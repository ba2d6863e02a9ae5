// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/result_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <unordered_map>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/base/json_value.h"
#include "panoptic/map/block_key.h"
#include "panoptic/outputs.h"
#include "panoptic/profile.h"
#include "panoptic/voxel_map.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMostClass = 65535;
constexpr std::int64_t kMostId = std::numeric_limits<std::uint32_t>::max();
constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
constexpr double kFarthest_m = 1e6;
constexpr double kLongest = 1e12;  // times and rates

// One on every grid edge that the cells of a block have.
constexpr std::size_t kMostVerticesOfBlock = std::size_t{3} * (kBlockSide + 1) * (kBlockSide + 1) * (kBlockSide + 1);

std::uint64_t count_of(const JsonValue& value) { return static_cast<std::uint64_t>(value.integer(0, kMost)); }

Vec3d vector_of(const JsonValue& value) {
  const std::vector<JsonValue> c = value.elements();
  if (c.size() != 3) value.wrong("three numbers");
  return {c[0].number(-kFarthest_m, kFarthest_m), c[1].number(-kFarthest_m, kFarthest_m), c[2].number(-kFarthest_m, kFarthest_m)};
}

Rgb color_in(const JsonValue& value) {
  const std::vector<JsonValue> c = value.elements();
  if (c.size() != 3) value.wrong("three numbers");
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(c[i].integer(0, 255)); };
  return {byte(0), byte(1), byte(2)};
}

LabelSet labels_in(const JsonValue& report, const std::string& file) {
  std::vector<LabelClass> classes;
  for (const JsonValue& entry : report.at("labels").elements()) {
    LabelClass label;
    label.id = static_cast<ClassId>(entry.at("id").integer(0, kMostClass));
    label.name = entry.at("name").text();
    label.is_thing = entry.at("is_thing").boolean();
    label.color = color_in(entry.at("color"));
    classes.push_back(std::move(label));
  }
  const auto name = report.find("label_set");
  try {
    return {name ? name->text() : "labels", std::move(classes)};
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", file, e.what()));
  }
}

RunState run_in(const JsonValue& report) {
  RunState run;
  const JsonValue frames = report.at("frames");
  run.frames_used = count_of(frames.at("used"));
  run.frames_done = run.frames_used + count_of(frames.at("skipped"));
  run.frames_total = run.frames_done;
  const auto unlabelled = frames.find("without_prediction");
  const bool has_labels = !report.find("predictor") || report.at("predictor").text() != "none";
  if (has_labels) run.frames_labelled = run.frames_used - std::min(run.frames_used, unlabelled ? count_of(*unlabelled) : 0);
  run.elapsed_s = report.at("wall_s").number(0, kLongest);
  run.memory_mb = report.at("peak_rss_mb").number(0, kLongest);
  run.finished = true;
  if (const auto stopped_by = report.find("stopped_by")) run.stopped_by = stopped_by->text();
  for (const auto& [name, stage] : report.at("stages").members()) {
    const auto ms = [&, &entry = stage](const char* key) { return entry.at(key).number(0, kLongest); };
    run.stages[name] = {count_of(stage.at("count")), ms("p50_ms"), ms("p95_ms"), ms("mean_ms")};
  }
  return run;
}

std::vector<SnapshotObject> objects_in(const JsonValue& file, const LabelSet& labels) {
  std::vector<SnapshotObject> objects;
  for (const JsonValue& entry : file.at("objects").elements()) {
    SnapshotObject object;
    object.id = static_cast<PanopticId>(entry.at("id").integer(0, kMostId));
    object.class_id = static_cast<ClassId>(entry.at("class_id").integer(0, kMostClass));
    for (const auto& [name, p] : entry.at("probabilities").members()) {
      const LabelClass* label = labels.find(name);
      if (label == nullptr) p.wrong("of a class in report.json");
      object.probabilities.push_back({label->id, static_cast<float>(p.number(0, 1.001))});
    }
    std::sort(object.probabilities.begin(), object.probabilities.end(),
              [](const ClassProbability& a, const ClassProbability& b) { return a.class_id < b.class_id; });
    object.first_frame = entry.at("first_frame").integer(kLeast, kMost);
    object.last_frame = entry.at("last_frame").integer(kLeast, kMost);
    object.observations = count_of(entry.at("observations"));
    object.vertices = count_of(entry.at("vertices"));
    object.min_m = vector_of(entry.at("box").at("min_m")).cast<float>();
    object.max_m = vector_of(entry.at("box").at("max_m")).cast<float>();
    objects.push_back(std::move(object));
  }
  std::sort(objects.begin(), objects.end(), [](const SnapshotObject& a, const SnapshotObject& b) { return a.id < b.id; });
  return objects;
}

// Lines of `time x y z qx qy qz qw`; lines that begin with # are comments.
std::vector<Vec3f> path_in(const fs::path& file) {
  std::vector<Vec3f> path;
  std::istringstream lines(read_file(file));
  std::string line;
  for (int n = 1; std::getline(lines, line); ++n) {
    if (line.empty() || line.starts_with('#')) continue;
    std::istringstream numbers(line);
    std::array<double, 8> v{};
    for (double& value : v) numbers >> value;
    const bool near = std::all_of(v.begin() + 1, v.begin() + 4, [](double c) { return std::abs(c) <= kFarthest_m; });
    if (!numbers || !near) throw Error(fmt::format("{}:{}: expected `time x y z qx qy qz qw`", file.string(), n));
    path.emplace_back(Vec3d(v[1], v[2], v[3]).cast<float>());
  }
  const std::size_t stride = (path.size() + kMaxPathPoints - 1) / kMaxPathPoints;
  for (std::size_t i = 0; stride > 1 && i * stride < path.size(); ++i) path[i] = path[i * stride];
  if (stride > 1) path.resize((path.size() + stride - 1) / stride);
  return path;
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
  const fs::path report_path = folder / "report.json";
  const fs::path objects_path = folder / "objects.json";
  if (!fs::is_regular_file(report_path)) {
    throw Error(fmt::format("{}: no report.json in it; name the folder that panoptic run wrote", folder.string()));
  }
  const Json report_json = read_json_file(report_path);
  const JsonValue report(report_json, report_path.string());
  OpenedResult result;
  SnapshotScene& scene = result.scene;
  scene.title = fs::absolute(folder / "").lexically_normal().parent_path().filename().string();
  scene.dataset = report.at("dataset").text();
  scene.labels = labels_in(report, report_path.string());
  const double voxel_size_m = report.at("options").at("map").at("voxel_size_m").number(1e-4, 100);
  scene.voxel_size_m = static_cast<float>(voxel_size_m);
  scene.block_size_m = scene.voxel_size_m * kBlockSide;
  scene.has_confidence = false;

  auto snapshot = std::make_shared<Snapshot>();
  snapshot->revision = 1;
  snapshot->run = run_in(report);
  const Vec3d up = vector_of(report.at("up"));
  if (up.norm() > 0.5) snapshot->up = up.normalized().cast<float>();
  const Json objects_json = read_json_file(objects_path);
  snapshot->objects = objects_in(JsonValue(objects_json, objects_path.string()), scene.labels);
  const fs::path mesh_path = folder / "mesh.ply";
  try {
    snapshot->chunks = cut_into_chunks(read_ply(mesh_path), scene.voxel_size_m);
  } catch (const Error& e) {
    const std::string what = e.what();
    throw Error(what.find(mesh_path.string()) == std::string::npos ? fmt::format("{}: {}", mesh_path.string(), what) : what);
  }
  if (fs::exists(folder / "trajectory.txt")) snapshot->path_m = path_in(folder / "trajectory.txt");
  result.snapshot = std::move(snapshot);
  return result;
}

}  // namespace panoptic
