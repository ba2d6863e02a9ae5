// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The furniture of one room in its places, and whether something more may stand there: nothing runs into anything else or the
// walls, doorways and windows stay free, and a person reaches every doorway and nearly all free floor.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "panoptic/sim/catalogue.h"
#include "panoptic/sim/floor_plan.h"
#include "panoptic/sim/floor_rect.h"
#include "panoptic/sim/random.h"

namespace panoptic {

constexpr double kWay_m = 0.64;  // the width of the way that stays free through a room

// A piece of furniture in its place.
struct PlacedFurniture {
  std::size_t furniture = 0;  // index into the catalogue
  FloorRect base;             // its x axis is the furniture's
  double bottom_m = 0;
  Vec3f scale = Vec3f::Ones();
  double height_m = 0;                 // scaled
  std::optional<std::size_t> partner;  // the placement that it may run into or stands on: a chair's table, a lamp's desk

  double top_m() const { return bottom_m + height_m; }
  Eigen::Vector2d front() const { return -base.across(); }  // the direction that it faces
};

// The place where something is to stand; `front` is the direction that it faces.
struct Stand {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d front = -Eigen::Vector2d::UnitY();
  std::optional<double> bottom_m;  // default: the furniture's own elevation
  Vec3f scale = Vec3f::Ones();
  std::optional<std::size_t> partner;
};

// Floor (or air) that is to stay free: before doors, windows, wardrobes. Chairs may stand where furniture keeps the floor free,
// and so may what belongs to the furniture (its partner).
struct FreeZone {
  FloorRect area;
  double low_m = 0;
  double high_m = 0;
  bool admits_small = false;
  std::optional<std::size_t> owner;  // the placement that keeps it free; set by place()
};

class RoomLayout {
 public:
  // Reserves what doorways and windows need. The references must outlive the layout.
  RoomLayout(const FloorPlan& plan, std::uint32_t room, const Catalogue& catalogue, Random& random);

  const Room& room() const { return plan_.rooms[room_]; }
  std::vector<WallHole> holes() const;  // of this room
  const Catalogue& catalogue() const { return catalogue_; }
  const Furniture& furniture(const PlacedFurniture& placement) const { return catalogue_.furniture()[placement.furniture]; }
  const std::vector<PlacedFurniture>& placements() const { return placements_; }
  Random& random() { return random_; }

  // The furniture of a role in random order; empty if there is none.
  std::vector<std::size_t> candidates(std::string_view role);
  std::optional<std::size_t> find(std::string_view role) const;  // the first placement of that role

  // Puts furniture there if it may stand there and `zone`, which it keeps free, is free; returns the index of the placement.
  std::optional<std::size_t> place(std::size_t furniture, const Stand& stand, const std::optional<FreeZone>& zone = std::nullopt);
  // Puts furniture there without any check: doors and windows, which are part of the walls.
  std::size_t build_in(std::size_t furniture, const Stand& stand);
  void reserve(const FreeZone& zone) { zones_.push_back(zone); }

  bool is_free(const FloorRect& area, double low_m, double high_m, std::optional<std::size_t> partner = std::nullopt) const;

 private:
  PlacedFurniture placement_at(std::size_t index, const Stand& stand) const;
  bool keeps_zones_free(const PlacedFurniture& placement) const;
  bool keeps_ways(const PlacedFurniture& placement) const;
  void block(const FloorRect& rect, std::vector<char>& blocked) const;

  const FloorPlan& plan_;
  std::uint32_t room_;
  const Catalogue& catalogue_;
  Random& random_;
  std::vector<PlacedFurniture> placements_;
  std::vector<FreeZone> zones_;
  // Cells whose middle is less than half a way from something on the floor.
  int cells_x_ = 0;
  int cells_y_ = 0;
  std::vector<char> blocked_;
};

}  // namespace panoptic
