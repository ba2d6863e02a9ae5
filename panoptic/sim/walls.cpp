// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/walls.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "panoptic/sim/random.h"
#include "panoptic/sim/surface_textures.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kPurpose = 0x3a115;
constexpr Rgb kWhite{255, 255, 255};
constexpr Rgb kCeilingColor{236, 235, 230};
constexpr Rgb kRevealColor{228, 226, 220};
constexpr Rgb kOutsideColor{196, 182, 164};

struct Interval {
  double low = 0;
  double high = 0;
};

// Four corners, counter-clockwise for who looks at the front, and their texture coordinates in metres.
struct Quad {
  std::array<Vec3d, 4> corners;
  std::array<Eigen::Vector2d, 4> uvs_m;
};

void append(const Quad& quad, std::uint32_t material, SceneModel& model) {
  const auto first = static_cast<std::uint32_t>(model.positions.size());
  for (std::size_t i = 0; i < 4; ++i) {
    model.positions.emplace_back(quad.corners[i].cast<float>());
    model.uvs.emplace_back((quad.uvs_m[i] / kTextureSide_m).cast<float>());
  }
  model.triangles.push_back({first, first + 1, first + 2});
  model.triangles.push_back({first, first + 2, first + 3});
  model.material_of.insert(model.material_of.end(), 2, material);
}

// A horizontal rectangle, seen from above or from below.
Quad horizontal(const Eigen::AlignedBox2d& box, double z_m, bool faces_up) {
  const Eigen::Vector2d& low = box.min();
  const Eigen::Vector2d& high = box.max();
  std::array<Eigen::Vector2d, 4> corners = {low, Eigen::Vector2d(high.x(), low.y()), high, Eigen::Vector2d(low.x(), high.y())};
  if (!faces_up) std::reverse(corners.begin(), corners.end());
  Quad quad;
  for (std::size_t i = 0; i < 4; ++i) {
    quad.corners[i] = Vec3d(corners[i].x(), corners[i].y(), z_m);
    quad.uvs_m[i] = corners[i];
  }
  return quad;
}

// A rectangle that stands on the line from `right` to `left` of who looks at its front.
Quad upright(const Eigen::Vector2d& left, const Eigen::Vector2d& right, Interval z_m) {
  const double width_m = (right - left).norm();
  Quad quad;
  quad.corners = {Vec3d(left.x(), left.y(), z_m.low), Vec3d(right.x(), right.y(), z_m.low), Vec3d(right.x(), right.y(), z_m.high),
                  Vec3d(left.x(), left.y(), z_m.high)};
  quad.uvs_m = {Eigen::Vector2d(0, z_m.low), Eigen::Vector2d(width_m, z_m.low), Eigen::Vector2d(width_m, z_m.high),
                Eigen::Vector2d(0, z_m.high)};
  return quad;
}

// A wall's face less its holes: columns between the holes, and what is below and above each.
void append_face(const WallFace& face, std::vector<WallHole> holes, double height_m, std::uint32_t material, SceneModel& model) {
  std::sort(holes.begin(), holes.end(), [](const WallHole& a, const WallHole& b) { return a.center_m < b.center_m; });
  const auto add = [&](Interval along_m, Interval z_m) {
    if (along_m.high - along_m.low < 1e-6 || z_m.high - z_m.low < 1e-6) return;
    Quad quad = upright(face.at(along_m.low), face.at(along_m.high), z_m);
    for (Eigen::Vector2d& uv_m : quad.uvs_m) uv_m.x() += along_m.low;  // the pattern runs on across holes
    append(quad, material, model);
  };
  double done_m = 0;
  for (const WallHole& hole : holes) {
    add({done_m, hole.low_m()}, {0, height_m});
    add({hole.low_m(), hole.high_m()}, {0, hole.bottom_m});
    add({hole.low_m(), hole.high_m()}, {hole.top_m, height_m});
    done_m = hole.high_m();
  }
  add({done_m, face.length_m}, {0, height_m});
}

// The four sides of a hole through a wall that is `depth_m` thick; without the bottom for doorways, whose floor is floor.
void append_reveal(const WallFace& face, const WallHole& hole, double depth_m, std::uint32_t material, SceneModel& model) {
  const Eigen::Vector2d left = face.at(hole.low_m());
  const Eigen::Vector2d right = face.at(hole.high_m());
  const Eigen::Vector2d outward = -face.inward * depth_m;
  append(upright(left, left + outward, {hole.bottom_m, hole.top_m}), material, model);
  append(upright(right + outward, right, {hole.bottom_m, hole.top_m}), material, model);
  Eigen::AlignedBox2d box(left.cwiseMin(right), left.cwiseMax(right));
  box.extend(left + outward);
  append(horizontal(box, hole.top_m, false), material, model);
  if (hole.kind == Hole::kWindow) append(horizontal(box, hole.bottom_m, true), material, model);
}

// The floor within an opening that people walk through.
Quad threshold(const WallFace& face, const WallHole& hole, double depth_m) {
  Eigen::AlignedBox2d box(face.at(hole.low_m()).cwiseMin(face.at(hole.high_m())),
                          face.at(hole.low_m()).cwiseMax(face.at(hole.high_m())));
  box.extend(face.at(hole.center_m, -depth_m));
  return horizontal(box, 0, true);
}

std::uint32_t add_material(Material material, Scene& scene) {
  scene.materials.push_back(material);
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

std::uint32_t add_textured(SurfaceFinish surface, const std::vector<Rgb>& colors, Random& random, Scene& scene) {
  const std::uint64_t seed = random.bits();
  scene.textures.push_back(surface_texture(surface, random.pick(colors), seed));
  return add_material({kWhite, static_cast<std::int32_t>(scene.textures.size() - 1)}, scene);
}

std::uint32_t wall_material(RoomKind kind, Random& random, Scene& scene) {
  static const std::vector<Rgb> kPaints = {{228, 222, 208}, {214, 220, 212}, {222, 214, 216},
                                           {206, 214, 224}, {232, 216, 190}, {224, 224, 222}};
  static const std::vector<Rgb> kPapers = {{208, 190, 166}, {176, 194, 188}, {190, 176, 196}, {204, 196, 150}};
  static const std::vector<Rgb> kTileColors = {{222, 228, 230}, {196, 214, 218}, {226, 220, 206}};
  if (kind == RoomKind::kBathroom) return add_textured(SurfaceFinish::kTiles, kTileColors, random, scene);
  const bool has_paper = kind != RoomKind::kKitchen && random.chance(0.35);
  if (has_paper) return add_textured(SurfaceFinish::kStripes, kPapers, random, scene);
  return add_textured(SurfaceFinish::kPlaster, kPaints, random, scene);
}

std::uint32_t floor_material(RoomKind kind, Random& random, Scene& scene) {
  static const std::vector<Rgb> kWoods = {{150, 104, 66}, {178, 132, 88}, {112, 76, 50}, {190, 160, 122}};
  static const std::vector<Rgb> kTileColors = {{148, 140, 128}, {120, 124, 128}, {176, 160, 140}};
  static const std::vector<Rgb> kCarpets = {{120, 110, 104}, {92, 104, 124}, {138, 120, 92}};
  if (kind == RoomKind::kBathroom || (kind == RoomKind::kKitchen && random.chance(0.7))) {
    return add_textured(SurfaceFinish::kTiles, kTileColors, random, scene);
  }
  const bool has_carpet = (kind == RoomKind::kBedroom || kind == RoomKind::kOffice) && random.chance(0.4);
  if (has_carpet) return add_textured(SurfaceFinish::kCarpet, kCarpets, random, scene);
  return add_textured(SurfaceFinish::kPlanks, kWoods, random, scene);
}

void add_object(SceneModel model, ClassId class_id, Scene& scene) {
  if (model.triangles.empty()) return;
  SceneObject object;
  object.model = static_cast<std::uint32_t>(scene.models.size());
  object.class_id = class_id;
  object.name = model.name;
  scene.models.push_back(std::move(model));
  scene.objects.push_back(std::move(object));
}

SceneModel named(const char* name) {
  SceneModel model;
  model.name = name;
  return model;
}

struct PlainMaterials {
  std::uint32_t ceiling = 0;
  std::uint32_t reveal = 0;
  std::uint32_t outside = 0;
};

struct StuffClasses {
  ClassId wall = ClassId::kUnknown;
  ClassId floor = ClassId::kUnknown;
};

struct Fabric {
  const FloorPlan& plan;
  double height_m = 0;
  PlainMaterials plain;
  StuffClasses classes;
};

void add_room(const Fabric& fabric, std::uint32_t room, Random& random, Scene& scene) {
  const auto& [plan, height_m, plain, classes] = fabric;
  const Room& it = plan.rooms[room];
  const std::uint32_t wall_paint = wall_material(it.kind, random, scene);
  const std::uint32_t flooring = floor_material(it.kind, random, scene);
  SceneModel walls = named("wall");
  SceneModel floor = named("floor");
  SceneModel ceiling = named("ceiling");
  SceneModel reveals = named("window reveal");
  append(horizontal(it.floor, 0, true), flooring, floor);
  append(horizontal(it.floor, height_m, false), plain.ceiling, ceiling);
  for (const Side side : {Side::kWest, Side::kEast, Side::kSouth, Side::kNorth}) {
    const WallFace face = wall_face(it.floor, side);
    std::vector<WallHole> holes;
    for (const WallHole& hole : plan.holes) {
      if (hole.room != room || hole.side != side) continue;
      holes.push_back(hole);
      // A doorway's reveal and threshold belong to the first of its rooms.
      const bool is_mine = hole.kind != Hole::kDoorway || plan.doorways[hole.doorway].room_a == room;
      const double depth_m = hole.kind == Hole::kDoorway ? kInnerWall_m : kOuterWall_m;
      if (is_mine) append_reveal(face, hole, depth_m, plain.reveal, hole.kind == Hole::kWindow ? reveals : walls);
      if (is_mine && hole.kind != Hole::kWindow) append(threshold(face, hole, depth_m), flooring, floor);
    }
    append_face(face, std::move(holes), height_m, wall_paint, walls);
  }
  add_object(std::move(walls), classes.wall, scene);
  add_object(std::move(floor), classes.floor, scene);
  add_object(std::move(ceiling), ClassId::kUnknown, scene);
  add_object(std::move(reveals), ClassId::kUnknown, scene);
}

// The outer walls as the street sees them: they keep the sun out.
void add_outside(const Fabric& fabric, Scene& scene) {
  const FloorPlan& plan = fabric.plan;
  const Eigen::AlignedBox2d outside(plan.inside.min().array() - kOuterWall_m, plan.inside.max().array() + kOuterWall_m);
  SceneModel walls = named("outer wall");
  for (const Side side : {Side::kWest, Side::kEast, Side::kSouth, Side::kNorth}) {
    const WallFace within = wall_face(outside, side);
    const WallFace face{within.at(within.length_m), -within.along, -within.inward, within.length_m};
    std::vector<WallHole> holes;
    for (WallHole hole : plan.holes) {
      if (hole.side != side || hole.kind == Hole::kDoorway) continue;
      const Eigen::Vector2d center = wall_face(plan.rooms[hole.room].floor, side).at(hole.center_m);
      hole.center_m = (center - face.start).dot(face.along);
      holes.push_back(hole);
    }
    append_face(face, std::move(holes), fabric.height_m, fabric.plain.outside, walls);
  }
  add_object(std::move(walls), fabric.classes.wall, scene);
}

// One lamp below the middle of the ceiling, two in long rooms.
void add_lamps(const Room& room, double height_m, Random& random, Scene& scene) {
  const Eigen::Vector2d size_m = room.floor.sizes();
  const int count = size_m.prod() > 20 ? 2 : 1;
  const int axis = size_m.x() > size_m.y() ? 0 : 1;
  const double warmth = random.uniform(0.72, 0.92);
  const double power = 0.8 + size_m.prod() / count / 16;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector2d at = room.floor.center();
    at[axis] = room.floor.min()[axis] + size_m[axis] * (i + 0.5) / count;
    const Vec3d radiance = power * Vec3d(1.0, (1 + warmth) / 2, warmth);
    scene.lamps.push_back({Vec3d(at.x(), at.y(), height_m - 0.15).cast<float>(), radiance.cast<float>()});
  }
}

}  // namespace

void add_fabric(const FloorPlan& plan, double wall_height_m, std::uint64_t seed, Scene& scene) {
  const LabelSet labels = load_label_set("scannet20");
  const StuffClasses classes{labels.find("wall")->id, labels.find("floor")->id};
  const PlainMaterials plain{add_material({kCeilingColor, -1}, scene), add_material({kRevealColor, -1}, scene),
                             add_material({kOutsideColor, -1}, scene)};
  const Fabric fabric{plan, wall_height_m, plain, classes};
  for (std::uint32_t room = 0; room < plan.rooms.size(); ++room) {
    Random random(seed, kPurpose, room);
    add_room(fabric, room, random, scene);
    add_lamps(plan.rooms[room], wall_height_m, random, scene);
  }
  add_outside(fabric, scene);
  Random random(seed, kPurpose, plan.rooms.size());
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const double height = random.uniform(0.5, 1.1);
  scene.towards_sun = Vec3d(std::cos(azimuth), std::sin(azimuth), height).normalized().cast<float>();
}

}  // namespace panoptic
