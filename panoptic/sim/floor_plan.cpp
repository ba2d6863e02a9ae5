// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/floor_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "panoptic/error.h"
#include "panoptic/sim/random.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kPurpose = 0x0f100a;
constexpr int kMostRooms = 8;
constexpr int kAttempts = 2000;
constexpr double kDoorTop_m = 2.05;
constexpr double kCorner_m = 0.12;  // between an opening and the end of its wall, at least
constexpr std::array kSides = {Side::kWest, Side::kEast, Side::kSouth, Side::kNorth};

struct AreaRange {
  double low_m2;
  double high_m2;
};

AreaRange area_range(RoomKind kind) {
  switch (kind) {
    case RoomKind::kLivingRoom:
      return {19, 28};
    case RoomKind::kKitchen:
      return {10, 15};
    case RoomKind::kBedroom:
      return {12, 18};
    case RoomKind::kBathroom:
      return {8.3, 10};
    case RoomKind::kOffice:
      return {10, 15};
  }
  return {10, 15};
}

std::vector<RoomKind> kinds_of(int rooms) {
  using enum RoomKind;
  const std::vector<RoomKind> order =
      rooms == 2   ? std::vector{kLivingRoom, kBedroom}
      : rooms == 3 ? std::vector{kLivingRoom, kBedroom, kBathroom}
                   : std::vector{kLivingRoom, kBedroom, kKitchen, kBathroom, kOffice, kBedroom, kBathroom, kOffice};
  return {order.begin(), order.begin() + rooms};
}

// The cost of reaching further rooms through this one: nobody wants to cross a bathroom.
double crossing_cost(RoomKind kind) {
  switch (kind) {
    case RoomKind::kLivingRoom:
      return 0;
    case RoomKind::kKitchen:
      return 1;
    case RoomKind::kOffice:
      return 3;
    case RoomKind::kBedroom:
      return 9;
    case RoomKind::kBathroom:
      return 100;
  }
  return 0;
}

// Cuts `box` among the rooms in proportion to the areas they wish for.
void divide(const Eigen::AlignedBox2d& box, std::span<const std::uint32_t> order, const std::vector<double>& wishes_m2,
            Random& random, std::vector<Room>& rooms) {
  if (order.size() == 1) {
    rooms[order[0]].floor = box;
    return;
  }
  const std::size_t cut = 1 + random.index(order.size() - 1);
  double first_m2 = 0;
  double all_m2 = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    all_m2 += wishes_m2[order[i]];
    if (i < cut) first_m2 += wishes_m2[order[i]];
  }
  const Eigen::Vector2d size_m = box.sizes();
  const int axis = size_m.x() > size_m.y() ? 0 : 1;
  const double share_m = (size_m[axis] - kInnerWall_m) * first_m2 / all_m2;
  Eigen::AlignedBox2d low = box;
  Eigen::AlignedBox2d high = box;
  low.max()[axis] = box.min()[axis] + share_m;
  high.min()[axis] = box.min()[axis] + share_m + kInnerWall_m;
  divide(low, order.subspan(0, cut), wishes_m2, random, rooms);
  divide(high, order.subspan(cut), wishes_m2, random, rooms);
}

bool is_fine_room(const FloorPlan& plan, std::uint32_t room) {
  const auto& [kind, floor] = plan.rooms[room];
  const Eigen::Vector2d size_m = floor.sizes();
  const double least_m = kind == RoomKind::kBathroom ? 2.3 : 2.7;
  if (size_m.minCoeff() < least_m || size_m.maxCoeff() / size_m.minCoeff() > 2.1) return false;
  if (const double area_m2 = size_m.prod(); area_m2 < 8 || area_m2 > 40) return false;
  const auto outer = std::count_if(kSides.begin(), kSides.end(), [&](Side side) { return plan.is_outer(room, side); });
  return kind == RoomKind::kBathroom || outer > 0;
}

// The stretch of wall that two rooms share.
struct SharedWall {
  std::uint32_t room_a = 0;
  std::uint32_t room_b = 0;
  int normal = 0;       // axis across the wall
  double middle_m = 0;  // of the wall, on that axis
  double low_m = 0;     // along the wall
  double high_m = 0;
};

std::optional<SharedWall> shared_wall(const FloorPlan& plan, std::uint32_t a, std::uint32_t b) {
  const auto& p = plan.rooms[a].floor;
  const auto& q = plan.rooms[b].floor;
  for (int normal = 0; normal < 2; ++normal) {
    const int along = 1 - normal;
    const double low_m = std::max(p.min()[along], q.min()[along]);
    const double high_m = std::min(p.max()[along], q.max()[along]);
    if (high_m - low_m < 1.4) continue;
    if (std::abs(q.min()[normal] - p.max()[normal] - kInnerWall_m) < 1e-6) {
      return SharedWall{a, b, normal, p.max()[normal] + kInnerWall_m / 2, low_m, high_m};
    }
    if (std::abs(p.min()[normal] - q.max()[normal] - kInnerWall_m) < 1e-6) {
      return SharedWall{a, b, normal, q.max()[normal] + kInnerWall_m / 2, low_m, high_m};
    }
  }
  return std::nullopt;
}

// How far along the face of a room's wall a point on the floor is.
double along_wall_m(const FloorPlan& plan, std::uint32_t room, Side side, const Eigen::Vector2d& point) {
  const WallFace face = wall_face(plan.rooms[room].floor, side);
  return (point - face.start).dot(face.along);
}

void add_doorway(const SharedWall& wall, Random& random, FloorPlan& plan) {
  Doorway doorway;
  doorway.room_a = wall.room_a;
  doorway.room_b = wall.room_b;
  doorway.width_m = 0.8 + 0.05 * random.integer(0, 4);
  // Near one end, so that the leaf opens against the wall around the corner and most of this wall stays free for furniture.
  const double margin_m = std::min(random.uniform(kCorner_m, 0.35), (wall.high_m - wall.low_m - doorway.width_m) / 2);
  const double offset_m = margin_m + doorway.width_m / 2;
  doorway.center[wall.normal] = wall.middle_m;
  doorway.center[1 - wall.normal] = random.chance(0.5) ? wall.low_m + offset_m : wall.high_m - offset_m;
  for (const std::uint32_t room : {wall.room_a, wall.room_b}) {
    const bool wall_is_above = plan.rooms[room].floor.center()[wall.normal] < wall.middle_m;
    const Side side =
        wall.normal == 0 ? (wall_is_above ? Side::kEast : Side::kWest) : (wall_is_above ? Side::kNorth : Side::kSouth);
    plan.holes.push_back({Hole::kDoorway, room, side, along_wall_m(plan, room, side, doorway.center), doorway.width_m, 0,
                          kDoorTop_m, static_cast<std::uint32_t>(plan.doorways.size())});
  }
  plan.doorways.push_back(doorway);
}

// A tree of doorways that grows from the living room (room 0) by the cheapest crossing, and sometimes one more for a loop.
// False if a room cannot be reached without crossing a bathroom.
bool connect(Random& random, FloorPlan& plan) {
  std::vector<SharedWall> walls;
  for (std::uint32_t a = 0; a < plan.rooms.size(); ++a) {
    for (std::uint32_t b = a + 1; b < plan.rooms.size(); ++b) {
      if (const auto wall = shared_wall(plan, a, b)) walls.push_back(*wall);
    }
  }
  std::vector<char> is_reached(plan.rooms.size(), 0);
  is_reached[0] = 1;
  const auto crosses = [&](const SharedWall& wall) {
    return crossing_cost(plan.rooms[is_reached[wall.room_a] != 0 ? wall.room_a : wall.room_b].kind);
  };
  for (std::size_t reached = 1; reached < plan.rooms.size(); ++reached) {
    const SharedWall* best = nullptr;
    for (const SharedWall& wall : walls) {
      if (is_reached[wall.room_a] == is_reached[wall.room_b]) continue;
      if (best == nullptr || crosses(wall) < crosses(*best)) best = &wall;
    }
    if (best == nullptr || crosses(*best) >= crossing_cost(RoomKind::kBathroom)) return false;
    is_reached[best->room_a] = is_reached[best->room_b] = 1;
    add_doorway(*best, random, plan);
  }
  if (!random.chance(0.6)) return true;
  for (const SharedWall& wall : walls) {
    const double cost = crossing_cost(plan.rooms[wall.room_a].kind) + crossing_cost(plan.rooms[wall.room_b].kind);
    const bool is_taken = std::any_of(plan.doorways.begin(), plan.doorways.end(), [&](const Doorway& doorway) {
      return doorway.room_a == wall.room_a && doorway.room_b == wall.room_b;
    });
    if (is_taken || cost > 12) continue;
    add_doorway(wall, random, plan);
    break;
  }
  return true;
}

bool add_entrance(Random& random, FloorPlan& plan) {
  std::vector<Side> sides(kSides.begin(), kSides.end());
  random.shuffle(sides);
  for (const Side side : sides) {
    if (!plan.is_outer(0, side)) continue;
    const double length_m = wall_face(plan.rooms[0].floor, side).length_m;
    const double width_m = 0.95;
    const double offset_m = random.uniform(kCorner_m, 0.4) + width_m / 2;
    plan.holes.push_back(
        {Hole::kEntrance, 0, side, random.chance(0.5) ? offset_m : length_m - offset_m, width_m, 0, kDoorTop_m, 0});
    return true;
  }
  return false;
}

// One window in the middle of the free stretch of an outer wall, two in long ones.
void add_windows(Random& random, std::uint32_t room, Side side, FloorPlan& plan) {
  double low_m = 0.4;
  double high_m = wall_face(plan.rooms[room].floor, side).length_m - 0.4;
  for (const WallHole& hole : plan.holes) {
    if (hole.room != room || hole.side != side) continue;
    if (hole.center_m < (low_m + high_m) / 2) {
      low_m = std::max(low_m, hole.high_m() + 0.4);
    } else {
      high_m = std::min(high_m, hole.low_m() - 0.4);
    }
  }
  const bool is_bathroom = plan.rooms[room].kind == RoomKind::kBathroom;
  const int count = !is_bathroom && high_m - low_m > 4.2 ? 2 : 1;
  const double width_m = is_bathroom ? 0.6 : 0.1 * random.integer(10, 16);
  const double sill_m = is_bathroom ? 1.35 : 0.95;
  const double stretch_m = (high_m - low_m) / count;
  if (stretch_m < width_m) return;
  for (int i = 0; i < count; ++i) {
    const double play_m = (stretch_m - width_m) / 2;
    const double center_m = low_m + stretch_m * (i + 0.5) + random.uniform(-0.5, 0.5) * play_m;
    plan.holes.push_back({Hole::kWindow, room, side, center_m, width_m, sill_m, is_bathroom ? 2.0 : 2.2, 0});
  }
}

void add_windows(Random& random, FloorPlan& plan) {
  for (std::uint32_t room = 0; room < plan.rooms.size(); ++room) {
    bool has_window = false;
    for (const Side side : kSides) {
      if (!plan.is_outer(room, side) || (has_window && random.chance(0.6))) continue;
      const std::size_t holes = plan.holes.size();
      add_windows(random, room, side, plan);
      has_window = has_window || plan.holes.size() > holes;
    }
  }
}

std::optional<FloorPlan> attempt(const HomeOptions& options, std::uint64_t counter) {
  Random random(options.seed, kPurpose, counter);
  const std::vector<RoomKind> kinds = kinds_of(options.rooms);
  FloorPlan plan;
  std::vector<double> wishes_m2;
  std::vector<std::uint32_t> order;
  double all_m2 = 0;
  for (std::uint32_t i = 0; i < kinds.size(); ++i) {
    const auto [low_m2, high_m2] = area_range(kinds[i]);
    // Functions without a room of their own go to the living room, which grows for them.
    const double extra_m2 = i > 0 || kinds.size() > 3 ? 0 : (kinds.size() == 1 ? 8 : 5);
    wishes_m2.push_back(random.uniform(low_m2, high_m2) + extra_m2);
    all_m2 += wishes_m2.back();
    order.push_back(i);
    plan.rooms.push_back({kinds[i], {}});
  }
  random.shuffle(order);
  const double aspect = random.uniform(1.0, 1.7);
  const double width_m = std::sqrt(all_m2 * aspect);
  plan.inside = Eigen::AlignedBox2d(Eigen::Vector2d::Zero(), Eigen::Vector2d(width_m, all_m2 / width_m));
  divide(plan.inside, order, wishes_m2, random, plan.rooms);
  for (std::uint32_t i = 0; i < kinds.size(); ++i) {
    if (!is_fine_room(plan, i)) return std::nullopt;
  }
  if (!connect(random, plan) || !add_entrance(random, plan)) return std::nullopt;
  add_windows(random, plan);
  return plan;
}

}  // namespace

WallFace wall_face(const Eigen::AlignedBox2d& floor, Side side) {
  const Eigen::Vector2d& low = floor.min();
  const Eigen::Vector2d& high = floor.max();
  const Eigen::Vector2d size_m = floor.sizes();
  switch (side) {
    case Side::kWest:
      return {low, {0, 1}, {1, 0}, size_m.y()};
    case Side::kEast:
      return {high, {0, -1}, {-1, 0}, size_m.y()};
    case Side::kSouth:
      return {{high.x(), low.y()}, {-1, 0}, {0, 1}, size_m.x()};
    case Side::kNorth:
      return {{low.x(), high.y()}, {1, 0}, {0, -1}, size_m.x()};
  }
  return {};
}

bool FloorPlan::is_outer(std::uint32_t room, Side side) const {
  const Eigen::AlignedBox2d& floor = rooms[room].floor;
  const int axis = side == Side::kWest || side == Side::kEast ? 0 : 1;
  const bool is_high = side == Side::kEast || side == Side::kNorth;
  return is_high ? floor.max()[axis] == inside.max()[axis] : floor.min()[axis] == inside.min()[axis];
}

FloorPlan make_floor_plan(const HomeOptions& options) {
  if (options.rooms < 1 || options.rooms > kMostRooms) {
    throw Error(fmt::format("rooms = {}: a simulated home has 1 to {} rooms", options.rooms, kMostRooms));
  }
  for (std::uint64_t counter = 0; counter < kAttempts; ++counter) {
    if (auto plan = attempt(options, counter)) return *std::move(plan);
  }
  throw Error(fmt::format("seed {} gives no floor plan of {} rooms: choose another seed", options.seed, options.rooms));
}

}  // namespace panoptic
