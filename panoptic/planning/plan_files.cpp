// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/plan_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <map>
#include <set>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/outputs.h"

namespace panoptic {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

constexpr Rgb kUnseen = {255, 255, 255};
constexpr Rgb kUnnamed = {128, 128, 128};

Rgb semantic_color(ClassId id, const LabelSet& labels) {
  const LabelClass* found = labels.find(id);
  return found == nullptr ? kUnnamed : found->color;
}

// A NumPy file of version 1: the header's length is a multiple of 64.
std::string npy_header(const Eigen::Vector3i& size) {
  constexpr std::size_t kBefore = 10;
  constexpr std::size_t kMultiple = 64;
  std::string text =
      fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}, {}), }}", size.z(), size.y(), size.x());
  text.append(kMultiple - (kBefore + text.size() + 1) % kMultiple, ' ');
  text.push_back('\n');
  std::string header("\x93NUMPY\x01\x00", 8);
  header.push_back(static_cast<char>(text.size() & 0xFF));
  header.push_back(static_cast<char>(text.size() >> 8));
  return header + text;
}

Json color_json(const Rgb& color) { return {color.r, color.g, color.b}; }

Json origin_json(const GroundGrid& grid) { return {grid.low.x() * grid.cell_m, grid.low.y() * grid.cell_m}; }

Json agent_json(const AgentSize& agent) {
  return {{"radius_m", agent.radius_m}, {"height_m", agent.height_m}, {"climb_m", agent.climb_m}};
}

}  // namespace

Json to_json(const Pose& pose) {
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({pose(r, 0), pose(r, 1), pose(r, 2), pose(r, 3)});
  return rows;
}

Json to_json(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }

void write_esdf(const Folder& folder, const DistanceField& field, const DistanceField::Values& values) {
  PartialFile file(folder / "esdf.npy");
  file.append(npy_header(values.size));
  file.append({reinterpret_cast<const char*>(values.distance_m.data()), values.distance_m.size() * sizeof(float)});
  file.commit();
  write_json_file(folder / "esdf.json", {{"origin_m", to_json(values.origin_m)},
                                         {"cell_m", field.cell_m()},
                                         {"cap_m", field.cap_m()},
                                         {"shape_zyx", {values.size.z(), values.size.y(), values.size.x()}},
                                         {"world_from_grid", to_json(Pose(field.grid_from_world().inverse()))}});
}

void write_occupancy(const Folder& folder, const std::string& name, const OccupancyGrid& grid) {
  write_file(folder / (name + ".pgm"), pgm_bytes(grid));
  write_file(folder / (name + ".yaml"), map_server_yaml(grid.grid, name + ".pgm"));
}

std::string grid_name(const HeightBand& band) { return fmt::format("grid_{:g}_{:g}", band.low_m, band.high_m); }

void write_semantic(const Folder& folder, const SemanticGrid& semantic, const LabelSet& labels, const UpFrame& frame) {
  const GroundGrid& grid = semantic.grid;
  Image<Rgb> image(grid.size.x(), grid.size.y(), kUnseen);
  std::map<ClassId, std::size_t> cells;
  for (std::size_t i = 0; i < grid.count(); ++i) {
    if (semantic.is_seen[i] == 0) continue;
    const Eigen::Vector2i at = grid.at(i) - grid.low;
    image(at.x(), grid.size.y() - 1 - at.y()) = semantic_color(semantic.class_at[i], labels);
    ++cells[semantic.class_at[i]];
  }
  write_png(folder / "semantic.png", image);
  Json classes = Json::array();
  for (const auto& [id, count] : cells) {
    classes.push_back({{"id", number(id)},
                       {"name", labels.name_of(id)},
                       {"color", color_json(semantic_color(id, labels))},
                       {"area_m2", static_cast<double>(count) * grid.cell_m * grid.cell_m}});
  }
  write_json_file(folder / "legend.json", {{"image", "semantic.png"},
                                           {"cell_m", grid.cell_m},
                                           {"origin_m", origin_json(grid)},
                                           {"unseen_color", color_json(kUnseen)},
                                           {"classes", classes},
                                           {"world_from_grid", to_json(Pose(frame.grid_from_world.inverse()))}});
}

void write_navigation(const Folder& folder, const Ground& ground, const RecastMesh& mesh, const LabelSet& labels) {
  write_file(folder / "navmesh.bin", mesh.bytes());
  const LabelClass* floor = labels.find("floor");
  const ClassId id = floor == nullptr ? ClassId::kUnknown : floor->id;
  const FlatTriangles flat = mesh.triangles();
  Mesh shown;
  for (const Vec3f& at : flat.vertices) {
    shown.vertices.push_back({at, Vec3f::UnitZ(), Rgb{120, 200, 120}, id, LabelSet::id_of_class(id)});
  }
  shown.triangles = flat.triangles;
  write_glb(folder / "navmesh.glb", shown, labels, Vec3d::UnitZ());
  write_json_file(folder / "navmesh.json", {{"agent", agent_json(ground.agent)},
                                            {"cell_m", ground.columns.grid.cell_m},
                                            {"walkable_m2", walkable_area_m2(ground.columns)},
                                            {"islands", island_count(ground.columns)},
                                            {"polygons", mesh.polygon_count()},
                                            {"triangles", flat.triangles.size()},
                                            {"floor_is_labelled", ground.frame.floor_is_labelled},
                                            {"world_from_grid", to_json(Pose(ground.frame.grid_from_world.inverse()))}});
}

std::string wall_bytes(const std::vector<WallMesh>& walls) {
  std::string bytes;
  for (const WallMesh& wall : walls) bytes += wall.mesh.bytes();
  return bytes;
}

Json walls_json(const std::vector<WallMesh>& walls, const UpFrame& frame) {
  const Pose world_from_grid = frame.grid_from_world.inverse();
  std::size_t offset = 0;
  Json list = Json::array();
  for (const WallMesh& wall : walls) {
    const std::size_t bytes = wall.mesh.bytes().size();
    const Pose grid_from_wall = wall.wall_from_grid.inverse();
    list.push_back({{"offset", offset},
                    {"bytes", bytes},
                    {"area_m2", wall.area_m2},
                    {"polygons", wall.mesh.polygon_count()},
                    {"grid_from_wall", to_json(grid_from_wall)},
                    {"world_from_wall", to_json(Pose(world_from_grid * grid_from_wall))}});
    offset += bytes;
  }
  return {{"agent", agent_json(kInsect)}, {"walls", list}, {"world_from_grid", to_json(world_from_grid)}};
}

void write_walls(const Folder& folder, const std::vector<WallMesh>& walls, const UpFrame& frame) {
  write_file(folder / "walls.bin", wall_bytes(walls));
  write_json_file(folder / "walls.json", walls_json(walls, frame));
}

void write_path(const Folder& folder, const Path& path, const Journey& journey, const UpFrame& frame) {
  Json points = Json::array();
  for (const Vec3d& p : path.points_m) points.push_back(to_json(p));
  Json json = {{"found", path.found}, {"length_m", path.length_m}, {"points", points}};
  json["from"] = to_json(Vec3d(frame.grid_from_world * journey.from_m));
  if (journey.to_m) json["to"] = to_json(Vec3d(frame.grid_from_world * *journey.to_m));
  if (!journey.to_object.empty()) json["to_object"] = journey.to_object;
  if (!path.found) json["why_not"] = path.why_not;
  json["world_from_grid"] = to_json(Pose(frame.grid_from_world.inverse()));
  write_json_file(folder / "path.json", json);
}

}  // namespace panoptic
