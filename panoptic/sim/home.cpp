// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/home.h"

#include <algorithm>
#include <map>

#include "panoptic/sim/placement.h"
#include "panoptic/sim/walls.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kPurpose = 0x403e;
constexpr double kOpenLeaf = 0.6;  // the share of doorways whose door leaf stands there, open

// Models of the catalogue that the scene holds already.
using ModelOf = std::map<std::size_t, std::uint32_t>;

void add_object(const Catalogue& catalogue, const PlacedFurniture& placement, ModelOf& model_of, Home& home) {
  const Furniture& it = catalogue.furniture()[placement.furniture];
  if (!model_of.contains(placement.furniture))
    model_of[placement.furniture] = catalogue.add_model(placement.furniture, home.scene);
  SceneObject object;
  object.model = model_of[placement.furniture];
  object.class_id = it.class_id;
  object.name = it.name;
  object.scale = placement.scale;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.col(0).head<2>() = placement.base.axis;
  axes.col(1).head<2>() = placement.base.across();
  object.world_from_object.linear() = axes;
  object.world_from_object.translation() = Vec3d(placement.base.center.x(), placement.base.center.y(), placement.bottom_m);
  home.scene.objects.push_back(std::move(object));
}

// A leaf or a window that fills its hole.
void fill_hole(RoomLayout& layout, const WallHole& hole, std::string_view role, double behind_m) {
  const std::vector<std::size_t> candidates = layout.candidates(role);
  if (candidates.empty()) return;
  const Furniture& it = layout.catalogue().furniture()[candidates[0]];
  const WallFace face = wall_face(layout.room().floor, hole.side);
  Stand stand;
  stand.front = face.inward;
  stand.center = face.at(hole.center_m, -behind_m);
  stand.bottom_m = hole.bottom_m;
  stand.scale.x() = static_cast<float>(hole.width_m) / it.size_m.x();
  stand.scale.y() = std::min(1.0F, 0.12F / it.size_m.y());
  stand.scale.z() = static_cast<float>(hole.top_m - hole.bottom_m) / it.size_m.z();
  layout.build_in(candidates[0], stand);
}

// The leaf stands at a right angle to the wall, beside the doorway, on the side where the corner is nearer.
void open_leaf(RoomLayout& layout, const WallHole& hole) {
  const std::vector<std::size_t> candidates = layout.candidates("door");
  if (candidates.empty()) return;
  const Furniture& it = layout.catalogue().furniture()[candidates[0]];
  const WallFace face = wall_face(layout.room().floor, hole.side);
  const bool hinge_is_left = hole.low_m() < face.length_m - hole.high_m();
  Stand stand;
  stand.scale.x() = static_cast<float>(hole.width_m) / it.size_m.x();
  stand.scale.y() = std::min(1.0F, 0.06F / it.size_m.y());
  stand.scale.z() = static_cast<float>(hole.top_m) / it.size_m.z();
  const double half_depth_m = it.size_m.y() * stand.scale.y() / 2 + 0.005;
  stand.front = hinge_is_left ? face.along : Eigen::Vector2d(-face.along);
  stand.center = face.at(hinge_is_left ? hole.low_m() - half_depth_m : hole.high_m() + half_depth_m, hole.width_m / 2 + 0.01);
  layout.place(candidates[0], stand);
}

// Which of its two rooms a doorway's leaf swings into; nullopt for a doorway without one.
std::vector<std::optional<std::uint32_t>> leaves(const FloorPlan& plan, std::uint64_t seed) {
  Random random(seed, kPurpose, 1);
  std::vector<std::optional<std::uint32_t>> into;
  for (const Doorway& doorway : plan.doorways) {
    const bool has_leaf = random.chance(kOpenLeaf);
    const std::uint32_t room = random.chance(0.5) ? doorway.room_a : doorway.room_b;
    into.push_back(has_leaf ? std::optional(room) : std::nullopt);
  }
  return into;
}

void add_openings(RoomLayout& layout, std::uint32_t room, const std::vector<std::optional<std::uint32_t>>& leaf_of) {
  for (const WallHole& hole : layout.holes()) {
    switch (hole.kind) {
      case Hole::kWindow:
        fill_hole(layout, hole, "window", kOuterWall_m / 2);
        break;
      case Hole::kEntrance:
        fill_hole(layout, hole, "door", kOuterWall_m / 2);
        break;
      case Hole::kDoorway:
        if (leaf_of[hole.doorway] == room) open_leaf(layout, hole);
        break;
    }
  }
}

}  // namespace

Home make_home(const HomeOptions& options, const Catalogue& catalogue) {
  const FloorPlan plan = make_floor_plan(options);
  Home home;
  home.rooms = plan.rooms;
  home.doorways = plan.doorways;
  add_fabric(plan, home.wall_height_m, options.seed, home.scene);
  const std::size_t stuff = home.scene.objects.size();
  const auto leaf_of = leaves(plan, options.seed);
  ModelOf model_of;
  for (std::uint32_t room = 0; room < plan.rooms.size(); ++room) {
    Random random(options.seed, kPurpose, 16 + room);
    RoomLayout layout(plan, room, catalogue, random);
    add_openings(layout, room, leaf_of);
    furnish(layout, plan.rooms);
    for (const PlacedFurniture& placement : layout.placements()) add_object(catalogue, placement, model_of, home);
  }
  for (std::size_t i = stuff; i < home.scene.objects.size(); ++i) {
    home.scene.objects[i].instance = static_cast<std::uint16_t>(i - stuff + 1);
  }
  return home;
}

}  // namespace panoptic
