// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/room_layout.h"

#include <algorithm>
#include <cmath>

namespace panoptic {
namespace {

constexpr double kCell_m = 0.06;
constexpr double kHead_m = 1.9;             // what hangs higher is in nobody's way
constexpr double kDoorZone_m = 0.85;        // free floor before a doorway
constexpr double kWindowZone_m = 0.35;      // free air before a window
constexpr double kSmallFootprint_m = 0.75;  // chairs and the like: people move them
constexpr double kConnected = 0.9;          // of the floor where a person can stand, the part that is reached from the doors

FloorRect zone_before(const Room& room, const WallHole& hole, double width_m, double depth_m) {
  const WallFace face = wall_face(room.floor, hole.side);
  return {face.at(hole.center_m, depth_m / 2), {width_m / 2, depth_m / 2}, face.along};
}

// The free cells that hang together with the start.
std::vector<std::int32_t> reached_from(std::int32_t start, const std::vector<char>& blocked, int width, int height) {
  std::vector<char> seen = blocked;
  std::vector<std::int32_t> reached = {start};
  seen[static_cast<std::size_t>(start)] = 1;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const std::int32_t x = reached[i] % width;
    const std::int32_t y = reached[i] / width;
    const auto visit = [&](bool inside, std::int32_t cell) {
      if (!inside || seen[static_cast<std::size_t>(cell)] != 0) return;
      seen[static_cast<std::size_t>(cell)] = 1;
      reached.push_back(cell);
    };
    visit(x > 0, reached[i] - 1);
    visit(x + 1 < width, reached[i] + 1);
    visit(y > 0, reached[i] - width);
    visit(y + 1 < height, reached[i] + width);
  }
  return reached;
}

}  // namespace

RoomLayout::RoomLayout(const FloorPlan& plan, std::uint32_t room, const Catalogue& catalogue, Random& random)
    : plan_(plan), room_(room), catalogue_(catalogue), random_(random) {
  const Eigen::AlignedBox2d& floor = plan.rooms[room].floor;
  cells_x_ = static_cast<int>(floor.sizes().x() / kCell_m);
  cells_y_ = static_cast<int>(floor.sizes().y() / kCell_m);
  blocked_.assign(static_cast<std::size_t>(cells_x_) * static_cast<std::size_t>(cells_y_), 0);
  for (const Side side : {Side::kWest, Side::kEast, Side::kSouth, Side::kNorth}) {
    const WallFace face = wall_face(floor, side);
    block({face.at(face.length_m / 2, -0.05), {face.length_m / 2, 0.05}, face.along}, blocked_);
  }
  for (const WallHole& hole : holes()) {
    const bool is_window = hole.kind == Hole::kWindow;
    const double depth_m = is_window ? kWindowZone_m : kDoorZone_m;
    zones_.push_back(
        {zone_before(plan.rooms[room], hole, hole.width_m, depth_m), hole.bottom_m, hole.top_m, false, std::nullopt});
  }
}

std::vector<WallHole> RoomLayout::holes() const {
  std::vector<WallHole> mine;
  std::copy_if(plan_.holes.begin(), plan_.holes.end(), std::back_inserter(mine),
               [&](const WallHole& hole) { return hole.room == room_; });
  return mine;
}

std::vector<std::size_t> RoomLayout::candidates(std::string_view role) {
  std::vector<std::size_t> all = catalogue_.with_role(role);
  random_.shuffle(all);
  return all;
}

std::optional<std::size_t> RoomLayout::find(std::string_view role) const {
  for (std::size_t i = 0; i < placements_.size(); ++i) {
    if (furniture(placements_[i]).role == role) return i;
  }
  return std::nullopt;
}

PlacedFurniture RoomLayout::placement_at(std::size_t index, const Stand& stand) const {
  const Furniture& it = catalogue_.furniture()[index];
  PlacedFurniture placement;
  placement.furniture = index;
  placement.scale = stand.scale;
  const Vec3d size_m = it.size_m.cwiseProduct(stand.scale).cast<double>();
  placement.base = {stand.center, size_m.head<2>() / 2, {-stand.front.y(), stand.front.x()}};
  placement.bottom_m = stand.bottom_m.value_or(it.elevation_m);
  placement.height_m = size_m.z();
  placement.partner = stand.partner;
  return placement;
}

bool RoomLayout::is_free(const FloorRect& area, double low_m, double high_m, std::optional<std::size_t> partner) const {
  const Eigen::AlignedBox2d box = bounds(area);
  const Eigen::AlignedBox2d& floor = room().floor;
  if ((box.min() - floor.min()).minCoeff() < -1e-6 || (floor.max() - box.max()).minCoeff() < -1e-6) return false;
  for (std::size_t i = 0; i < placements_.size(); ++i) {
    const PlacedFurniture& other = placements_[i];
    const bool is_apart = other.top_m() <= low_m + 1e-3 || other.bottom_m >= high_m - 1e-3;
    if (partner == i || is_apart) continue;
    if (overlap(other.base, area)) return false;
  }
  return true;
}

bool RoomLayout::keeps_zones_free(const PlacedFurniture& placement) const {
  const bool is_small = placement.base.half_m.maxCoeff() * 2 < kSmallFootprint_m;
  return std::none_of(zones_.begin(), zones_.end(), [&](const FreeZone& zone) {
    const bool is_apart = placement.top_m() <= zone.low_m + 1e-3 || placement.bottom_m >= zone.high_m - 1e-3;
    const bool is_admitted = (zone.admits_small && is_small) || (zone.owner && zone.owner == placement.partner);
    return !is_apart && !is_admitted && overlap(zone.area, placement.base);
  });
}

void RoomLayout::block(const FloorRect& rect, std::vector<char>& blocked) const {
  const Eigen::Vector2d& origin = room().floor.min();
  const Eigen::AlignedBox2d box = bounds(grown(rect, kWay_m / 2));
  const auto cell_of = [&](double value, int cells) { return std::clamp(static_cast<int>(value / kCell_m), 0, cells); };
  const int left = cell_of(box.min().x() - origin.x(), cells_x_);
  const int right = cell_of(box.max().x() - origin.x() + kCell_m, cells_x_);
  const int low = cell_of(box.min().y() - origin.y(), cells_y_);
  const int high = cell_of(box.max().y() - origin.y() + kCell_m, cells_y_);
  for (int y = low; y < high; ++y) {
    for (int x = left; x < right; ++x) {
      const Eigen::Vector2d middle = origin + Eigen::Vector2d(x + 0.5, y + 0.5) * kCell_m;
      if (distance_m(rect, middle) < kWay_m / 2)
        blocked[static_cast<std::size_t>(y) * static_cast<std::size_t>(cells_x_) + static_cast<std::size_t>(x)] = 1;
    }
  }
}

bool RoomLayout::keeps_ways(const PlacedFurniture& placement) const {
  if (placement.bottom_m >= kHead_m) return true;
  std::vector<char> blocked = blocked_;
  block(placement.base, blocked);
  const auto free = std::count(blocked.begin(), blocked.end(), 0);
  std::vector<char> is_reached;
  for (const WallHole& hole : holes()) {
    if (hole.kind == Hole::kWindow) continue;
    const Eigen::Vector2d step = wall_face(room().floor, hole.side).at(hole.center_m, kWay_m / 2 + kCell_m) - room().floor.min();
    const auto start = static_cast<std::int32_t>(step.y() / kCell_m) * cells_x_ + static_cast<std::int32_t>(step.x() / kCell_m);
    if (blocked[static_cast<std::size_t>(start)] != 0) return false;
    if (!is_reached.empty()) {
      if (is_reached[static_cast<std::size_t>(start)] == 0) return false;
      continue;
    }
    const auto reached = reached_from(start, blocked, cells_x_, cells_y_);
    if (static_cast<double>(reached.size()) < kConnected * static_cast<double>(free)) return false;
    is_reached.assign(blocked.size(), 0);
    for (const std::int32_t cell : reached) is_reached[static_cast<std::size_t>(cell)] = 1;
  }
  return true;
}

std::optional<std::size_t> RoomLayout::place(std::size_t furniture, const Stand& stand, const std::optional<FreeZone>& zone) {
  const PlacedFurniture placement = placement_at(furniture, stand);
  if (!is_free(placement.base, placement.bottom_m, placement.top_m(), placement.partner)) return std::nullopt;
  const bool stands_on_something = placement.partner && placement.bottom_m > 0.2;
  if (!stands_on_something && !keeps_zones_free(placement)) return std::nullopt;
  if (zone && !is_free(zone->area, zone->low_m, zone->high_m)) return std::nullopt;
  if (!stands_on_something && !keeps_ways(placement)) return std::nullopt;
  if (zone) {
    zones_.push_back(*zone);
    zones_.back().owner = placements_.size();
  }
  return build_in(furniture, stand);
}

std::size_t RoomLayout::build_in(std::size_t furniture, const Stand& stand) {
  placements_.push_back(placement_at(furniture, stand));
  const PlacedFurniture& placement = placements_.back();
  if (placement.bottom_m < kHead_m) block(placement.base, blocked_);
  return placements_.size() - 1;
}

}  // namespace panoptic
