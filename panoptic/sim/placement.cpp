// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/placement.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace panoptic {
namespace {

constexpr std::size_t kCandidates = 4;  // of a role that are tried before it is left out
constexpr int kTries = 8;               // places along a wall
constexpr double kHead_m = 1.9;

FreeZone front_zone(const PlacedFurniture& placement, double front_m, double sides_m) {
  const Vec3d half_m(placement.base.half_m.x() + sides_m, placement.base.half_m.y(), 0);
  FreeZone zone;
  zone.area.axis = placement.base.axis;
  zone.area.half_m = {half_m.x(), half_m.y() + front_m / 2};
  zone.area.center = placement.base.center + placement.front() * (front_m / 2);
  zone.high_m = kHead_m;
  zone.admits_small = true;
  return zone;
}

std::optional<std::size_t> stand_at_wall(RoomLayout& layout, std::size_t furniture, const WallFace& face, double center_m,
                                         const AgainstWall& rule) {
  const Vec3d size_m = layout.catalogue().furniture()[furniture].size_m.cast<double>();
  Stand stand;
  stand.front = face.inward;
  stand.center = face.at(center_m, rule.gap_m + size_m.y() / 2);
  if (rule.free_front_m <= 0 && rule.free_sides_m <= 0) return layout.place(furniture, stand);
  PlacedFurniture probe;
  probe.base = {stand.center, size_m.head<2>() / 2, face.along};
  return layout.place(furniture, stand, front_zone(probe, rule.free_front_m, rule.free_sides_m));
}

// Places along the wall to try: both corners, then anywhere.
std::vector<double> centers_along(RoomLayout& layout, const WallFace& face, double width_m, const AgainstWall& rule) {
  if (rule.center_m) return {*rule.center_m};
  const double low_m = width_m / 2 + rule.gap_m + rule.free_sides_m;
  const double high_m = face.length_m - low_m;
  if (high_m < low_m) return {};
  std::vector<double> centers = {low_m, high_m};
  if (layout.random().chance(0.5)) std::swap(centers[0], centers[1]);
  if (rule.in_corner) return centers;
  for (int i = 0; i < kTries; ++i) centers.push_back(layout.random().uniform(low_m, high_m));
  // Furniture that needs free sides looks better in the middle of the wall.
  if (rule.free_sides_m > 0) std::rotate(centers.begin(), centers.begin() + 2, centers.end());
  return centers;
}

}  // namespace

std::optional<std::size_t> against_wall(RoomLayout& layout, std::string_view role, const AgainstWall& rule) {
  std::vector<std::size_t> candidates = layout.candidates(role);
  candidates.resize(std::min(candidates.size(), kCandidates));
  std::vector<Side> sides = {Side::kWest, Side::kEast, Side::kSouth, Side::kNorth};
  layout.random().shuffle(sides);
  if (rule.side) sides = {*rule.side};
  for (const std::size_t furniture : candidates) {
    const double width_m = layout.catalogue().furniture()[furniture].size_m.x();
    for (const Side side : sides) {
      const WallFace face = wall_face(layout.room().floor, side);
      for (const double center_m : centers_along(layout, face, width_m, rule)) {
        if (const auto placed = stand_at_wall(layout, furniture, face, center_m, rule)) return placed;
      }
    }
  }
  return std::nullopt;
}

std::optional<std::size_t> beside(RoomLayout& layout, std::string_view role, std::size_t neighbour, bool on_the_left,
                                  double gap_m) {
  const PlacedFurniture next_to = layout.placements()[neighbour];
  for (const std::size_t furniture : layout.candidates(role)) {
    const Vec3d half_m = layout.catalogue().furniture()[furniture].size_m.cast<double>() / 2;
    const double aside_m = next_to.base.half_m.x() + half_m.x() + gap_m;
    const double back_m = next_to.base.half_m.y() - half_m.y();
    Stand stand;
    stand.front = next_to.front();
    stand.center = next_to.base.center + next_to.base.axis * (on_the_left ? -aside_m : aside_m) - stand.front * back_m;
    if (const auto placed = layout.place(furniture, stand)) return placed;
  }
  return std::nullopt;
}

std::optional<std::size_t> in_the_open(RoomLayout& layout, std::string_view role, double free_around_m) {
  std::vector<std::size_t> candidates = layout.candidates(role);
  candidates.resize(std::min(candidates.size(), kCandidates));
  for (const std::size_t furniture : candidates) {
    const Furniture& it = layout.catalogue().furniture()[furniture];
    for (int i = 0; i < 4 * kTries; ++i) {
      Eigen::Vector2d share;  // one after the other: the order in which arguments are evaluated is the compiler's choice
      share.y() = layout.random().uniform(0.15, 0.85);
      share.x() = layout.random().uniform(0.15, 0.85);
      Stand stand;
      stand.center = layout.room().floor.min() + layout.room().floor.sizes().cwiseProduct(share);
      stand.front = layout.random().chance(0.5) ? Eigen::Vector2d(1, 0) : Eigen::Vector2d(0, -1);
      const FloorRect base{stand.center, it.size_m.head<2>().cast<double>() / 2, {-stand.front.y(), stand.front.x()}};
      if (!layout.is_free(grown(base, free_around_m), 0, kHead_m)) continue;
      if (const auto placed = layout.place(furniture, stand)) return placed;
    }
  }
  return std::nullopt;
}

namespace {

// A seat on one side of a table: `outward` from its middle, `aside_m` along that side.
bool seat(RoomLayout& layout, std::size_t chair, std::size_t table, const Eigen::Vector2d& outward, double aside_m) {
  const PlacedFurniture at = layout.placements()[table];
  const Vec3d size_m = layout.catalogue().furniture()[chair].size_m.cast<double>();
  const double reach_m =
      std::abs(outward.dot(at.base.axis)) * at.base.half_m.x() + std::abs(outward.dot(at.base.across())) * at.base.half_m.y();
  const double below_m = layout.random().uniform(0.05, 0.22);  // how far the seat is pushed in
  const double turn = layout.random().uniform(-0.16, 0.16);
  Stand stand;
  stand.front = Eigen::Rotation2Dd(turn) * -outward;
  stand.center =
      at.base.center + outward * (reach_m + size_m.y() / 2 - below_m) + Eigen::Vector2d(-outward.y(), outward.x()) * aside_m;
  stand.partner = table;
  return layout.place(chair, stand).has_value();
}

}  // namespace

int chairs_at(RoomLayout& layout, std::string_view role, std::size_t table, int most) {
  const std::vector<std::size_t> chairs = layout.candidates(role);
  if (chairs.empty()) return 0;
  const PlacedFurniture at = layout.placements()[table];
  const double width_m = layout.catalogue().furniture()[chairs[0]].size_m.x() + 0.12;
  int placed = 0;
  for (const bool is_long_side : {at.base.half_m.x() >= at.base.half_m.y(), at.base.half_m.x() < at.base.half_m.y()}) {
    const Eigen::Vector2d outward = is_long_side ? at.base.across() : at.base.axis;
    const double side_m = 2 * (is_long_side ? at.base.half_m.x() : at.base.half_m.y());
    const int seats = std::max(1, static_cast<int>(side_m / width_m));
    for (int i = 0; i < seats; ++i) {
      const double aside_m = ((i + 0.5) / seats - 0.5) * side_m;
      for (const double sign : {1.0, -1.0}) {
        if (placed < most && seat(layout, chairs[0], table, sign * outward, aside_m)) ++placed;
      }
    }
  }
  return placed;
}

std::optional<std::size_t> chair_before(RoomLayout& layout, std::string_view role, std::size_t desk) {
  const PlacedFurniture at = layout.placements()[desk];
  for (const std::size_t chair : layout.candidates(role)) {
    if (seat(layout, chair, desk, at.front(), layout.random().uniform(-0.1, 0.1))) return layout.placements().size() - 1;
  }
  return std::nullopt;
}

int things_on(RoomLayout& layout, std::string_view role, std::size_t carrier, int most) {
  const PlacedFurniture under = layout.placements()[carrier];
  int placed = 0;
  for (const std::size_t thing : layout.candidates(role)) {
    const Vec3d size_m = layout.catalogue().furniture()[thing].size_m.cast<double>();
    const double radius_m = size_m.head<2>().norm() / 2;
    const Eigen::Vector2d play_m = under.base.half_m.array() - radius_m - 0.01;
    for (int i = 0; placed < most && play_m.minCoeff() > 0 && i < kTries; ++i) {
      const double y_m = layout.random().uniform(-play_m.y(), play_m.y());
      const double x_m = layout.random().uniform(-play_m.x(), play_m.x());
      const Eigen::Vector2d at(x_m, y_m);
      Stand stand;
      stand.center = under.base.center + under.base.axis * at.x() + under.base.across() * at.y();
      stand.front = Eigen::Rotation2Dd(layout.random().uniform(-0.5, 0.5)) * under.front();
      stand.bottom_m = under.top_m();
      stand.partner = carrier;
      if (!layout.place(thing, stand)) continue;
      ++placed;
      break;
    }
  }
  return placed;
}

void furnish(RoomLayout& layout, const std::vector<Room>& home) {
  using enum RoomKind;
  const RoomKind kind = layout.room().kind;
  const auto belongs_here = [&](RoomKind wanted) {
    const bool has_its_own = std::any_of(home.begin(), home.end(), [&](const Room& room) { return room.kind == wanted; });
    return kind == wanted || (kind == kLivingRoom && !has_its_own);
  };
  const bool is_dry = kind != kBathroom && kind != kKitchen;
  if (is_dry) hang_curtains(layout, 0.6);
  if (belongs_here(kKitchen)) furnish_kitchen(layout);
  if (kind == kKitchen) furnish_dining(layout);
  if (belongs_here(kBedroom)) furnish_bedroom(layout);
  if (kind == kLivingRoom) furnish_living_room(layout);
  if (kind == kOffice || (belongs_here(kOffice) && layout.random().chance(0.7))) furnish_office(layout);
  if (kind == kBathroom) furnish_bathroom(layout);
  add_radiators(layout);
  if (kind != kBathroom) hang_curtains(layout, 0.5);
  hang_pictures(layout, kind == kBathroom ? layout.random().integer(0, 1) : layout.random().integer(1, 3));
}

}  // namespace panoptic
