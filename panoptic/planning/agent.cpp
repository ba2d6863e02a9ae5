// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/agent.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/planning/agent_rules.h"

namespace panoptic {
namespace {

namespace rules = agent_rules;

constexpr double kSameEnd_m = 0.12;
constexpr double kLooksWhereItGoes_m_s = 0.12;
constexpr double kStandsStill_m_s = 0.05;
constexpr double kNearlyThere_m = 0.3;  // if others stand on the place itself
constexpr double kMostFromSpot_m = 0.2;
constexpr double kFacesIt_rad = 0.05;

double wrapped(double angle) { return std::atan2(std::sin(angle), std::cos(angle)); }
double heading_of(const Vec2d& v) { return std::atan2(v.y(), v.x()); }
double ease(double t) {
  const double u = std::clamp(t, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}
Vec3d on_floor(const Vec2d& at) { return {at.x(), at.y(), 0}; }
double apart(const Vec3d& a, const Vec3d& b) { return (a - b).head<2>().norm(); }

WalkRules own_pace(WalkRules walk, std::size_t number) {
  constexpr double kSpread = 0.37;
  const double share = std::fmod(static_cast<double>(number) * kSpread, 1.0);
  walk.speed_m_s *= rules::kSlowestShare + (1 - rules::kSlowestShare) * share;
  return walk;
}

}  // namespace

const char* name_of(AgentState state) {
  switch (state) {
    case AgentState::kStanding:
      return "standing";
    case AgentState::kWalking:
      return "walking";
    case AgentState::kTurning:
      return "turning";
    case AgentState::kSittingDown:
      return "sitting down";
    case AgentState::kSitting:
      return "sitting";
    case AgentState::kLyingDown:
      return "lying down";
    case AgentState::kLying:
      return "lying";
    case AgentState::kGettingUp:
      return "getting up";
    case AgentState::kStandingUp:
      return "standing up";
  }
  return "";
}

std::vector<Vec2d> spots_before(const SittingPlace& place) {
  std::vector<std::pair<double, Vec2d>> spots;
  for (const double distance_m : rules::kSpotDistances_m) {
    for (const double turn_rad : rules::kSpotTurns_rad) {
      spots.emplace_back(distance_m + rules::kTurnCosts_m * std::abs(turn_rad),
                         place.at + distance_m * (Eigen::Rotation2Dd(turn_rad) * place.facing));
    }
  }
  std::stable_sort(spots.begin(), spots.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vec2d> result;
  for (const auto& [cost, at] : spots) result.push_back(at);
  return result;
}

std::vector<SittingPlace> edges_of(const LyingPlace& bed) {
  const Vec2d axis = bed.axis.head<2>();
  const auto edge = [&](const Vec2d& out, double half_m) {
    return SittingPlace{bed.center.head<2>() + std::max(0.0, half_m - rules::kBedEdge_m) * out, out};
  };
  return {edge(quarter_turn(axis), bed.width_m / 2), edge(-quarter_turn(axis), bed.width_m / 2), edge(-axis, bed.length_m / 2)};
}

Agent::Agent(PeopledFloor floor, WalkRules walk, const Vec3d& at, double heading_rad, std::size_t number)
    : floor_(floor),
      walk_(own_pace(walk, number)),
      walker_(floor.crowd.enter(at, walk_)),
      height_m_(rules::kHeights_m[number % rules::kHeights_m.size()]),
      place_(at),
      heading_rad_(heading_rad) {
  if (!walker_) throw Error("there is no room for one more agent");
}

Vec2d Agent::facing() const { return {std::cos(heading_rad_), std::sin(heading_rad_)}; }

bool Agent::takes(const void* seat_or_bed) const {
  return (goal_ && goal_->taken == seat_or_bed) || (next_ && next_->taken == seat_or_bed);
}

bool Agent::is_down() const {
  return state_ != AgentState::kStanding && state_ != AgentState::kWalking && state_ != AgentState::kTurning;
}

bool Agent::is_stuck() const { return state_ == AgentState::kWalking && stuck_s_ > rules::kStuck_s; }

bool Agent::go(const Vec3d& to) {
  const std::optional<Vec3d> at = floor_.mesh.nearest(to, rules::kAnySpotAhead_m);
  return at && is_reached(*at) && begin({.spot = *at, .place = {}});
}

bool Agent::sit(const Seat& seat) {
  const SittingPlace place{seat.position.head<2>(), seat.facing.head<2>()};
  const std::optional<Vec3d> spot = spot_before(place);
  return spot && begin({.taken = &seat, .spot = *spot, .place = place});
}

bool Agent::lie(const LyingPlace& bed) {
  for (const SittingPlace& edge : edges_of(bed)) {
    const std::optional<Vec3d> spot = spot_before(edge);
    if (!spot) continue;
    const Vec2d axis = bed.axis.head<2>();
    return begin({.taken = &bed,
                  .spot = *spot,
                  .place = edge,
                  .is_bed = true,
                  .lying_at = bed.center.head<2>() + rules::kHeadShare * height_m_ * axis,
                  .lying_heading_rad = heading_of(-axis)});
  }
  return false;
}

bool Agent::stand() {
  if (state_ == AgentState::kLying) {
    set(AgentState::kGettingUp);
    return true;
  }
  return state_ == AgentState::kSitting && rise();
}

// Only if nobody stands where it will stand; who comes by then goes around.
bool Agent::rise() {
  if (!floor_.crowd.is_clear(goal_->spot, std::nullopt)) return false;
  walker_ = floor_.crowd.enter(goal_->spot, walk_);
  if (!walker_) return false;
  set(AgentState::kStandingUp);
  return true;
}

bool Agent::is_reached(const Vec3d& at) const {
  const auto way = floor_.mesh.way(is_down() ? goal_->spot : place_, at);
  return way && apart(way->back(), at) < kSameEnd_m;
}

bool Agent::is_clear(const Vec3d& at) const { return floor_.crowd.is_clear(at, walker_); }

std::optional<Vec3d> Agent::spot_before(const SittingPlace& place) const {
  const auto found = [&](const Vec2d& at, double off_m) -> std::optional<Vec3d> {
    const std::optional<Vec3d> near = floor_.mesh.nearest(on_floor(at), off_m);
    return near && is_clear(*near) && is_reached(*near) ? near : std::nullopt;
  };
  for (const Vec2d& at : spots_before(place)) {
    if (auto near = found(at, rules::kSpotOff_m)) return near;
  }
  auto near = found(place.at + rules::kAnySpotAhead_m * place.facing, rules::kAnySpotOff_m);
  return near && apart(*near, on_floor(place.at)) < rules::kAnySpotFarthest_m ? near : std::nullopt;
}

bool Agent::begin(const Goal& goal) {
  if (is_down()) {
    next_ = goal;
    stand();
    return true;
  }
  goal_ = goal;
  floor_.crowd.go(*walker_, goal.spot);
  set(AgentState::kWalking);
  return true;
}

void Agent::set(AgentState state) {
  state_ = state;
  in_state_s_ = 0;
  stuck_s_ = 0;
}

void Agent::update(double passed_s) {
  in_state_s_ += passed_s;
  switch (state_) {
    case AgentState::kStanding:
      on_feet(passed_s, std::nullopt);
      break;
    case AgentState::kWalking:
      walk(passed_s);
      break;
    case AgentState::kTurning:
      turn(passed_s);
      break;
    case AgentState::kSittingDown:
      sit_down();
      break;
    case AgentState::kSitting:
    case AgentState::kLying:
      rest();
      break;
    case AgentState::kLyingDown:
      swing_onto_bed(in_state_s_ / rules::kLieDown_s);
      if (in_state_s_ >= rules::kLieDown_s) set(AgentState::kLying);
      break;
    case AgentState::kGettingUp:
      get_up();
      break;
    case AgentState::kStandingUp:
      stand_up();
      break;
  }
}

// Follows the crowd, looking where it goes or to `heading_rad`. Returns its speed.
double Agent::on_feet(double passed_s, std::optional<double> heading_rad) {
  constexpr double kTurnsAt_s = 9;
  const Vec3d before = place_;
  place_ = floor_.crowd.place(*walker_);
  const Vec2d way = (place_ - before).head<2>();
  walked_m_ += way.norm();
  const double speed = way.norm() / passed_s;
  const double wanted = heading_rad.value_or(speed > kLooksWhereItGoes_m_s ? heading_of(way) : heading_rad_);
  const double most = (heading_rad ? rules::kTurn_rad_s : rules::kTurnWalking_rad_s) * passed_s;
  heading_rad_ =
      wrapped(heading_rad_ + std::clamp(wrapped(wanted - heading_rad_) * std::min(1.0, kTurnsAt_s * passed_s), -most, most));
  return speed;
}

void Agent::walk(double passed_s) {
  const double speed = on_feet(passed_s, std::nullopt);
  const double left_m = apart(place_, goal_->spot);
  stuck_s_ = speed < kStandsStill_m_s ? stuck_s_ + passed_s : std::max(0.0, stuck_s_ - 2 * passed_s);
  if (left_m < rules::kArrived_m || (left_m < kNearlyThere_m && stuck_s_ > 1)) {
    arrive(left_m);
  } else if (stuck_s_ > rules::kPatience_s) {
    give_up();
  }
}

void Agent::arrive(double left_m) {
  if (goal_->taken != nullptr && left_m > kMostFromSpot_m) return give_up();
  floor_.crowd.stop(*walker_);
  goal_->spot = place_;
  if (goal_->taken != nullptr) return set(AgentState::kTurning);
  goal_.reset();
  set(AgentState::kStanding);
}

void Agent::give_up() {
  ++gave_up_;
  floor_.crowd.stop(*walker_);
  goal_.reset();
  set(AgentState::kStanding);
}

void Agent::turn(double passed_s) {
  constexpr double kAtLeast_s = 0.35;
  constexpr double kAtMost_s = 4;
  const double facing_rad = heading_of(goal_->place.facing);
  on_feet(passed_s, facing_rad);
  const bool done = std::abs(wrapped(facing_rad - heading_rad_)) < kFacesIt_rad;
  if ((!done && in_state_s_ < kAtMost_s) || in_state_s_ < kAtLeast_s) return;
  goal_->spot = place_;
  set(AgentState::kSittingDown);
}

// The feet stay where they are; the pelvis goes back over the seat.
void Agent::between_seat_and_spot(double share) {
  const double back = ease(share);
  place_ = goal_->spot + back * (on_floor(goal_->place.at) - goal_->spot);
  heading_rad_ = heading_of(goal_->place.facing);
}

void Agent::swing_onto_bed(double share) {
  constexpr double kMovesFaster = 1.25;
  constexpr double kTurnsFaster = 1.4;
  const Vec2d from = goal_->place.at;
  const double facing_rad = heading_of(goal_->place.facing);
  place_ = on_floor(from + ease(kMovesFaster * share) * (goal_->lying_at - from));
  heading_rad_ = wrapped(facing_rad + wrapped(goal_->lying_heading_rad - facing_rad) * ease(kTurnsFaster * share));
}

void Agent::sit_down() {
  between_seat_and_spot(in_state_s_ / rules::kSitDown_s);
  if (in_state_s_ < rules::kSitDown_s) return;
  floor_.crowd.leave(*std::exchange(walker_, std::nullopt));
  set(goal_->is_bed ? AgentState::kLyingDown : AgentState::kSitting);
}

void Agent::rest() {
  if (next_) stand();
}

void Agent::get_up() {
  swing_onto_bed(1 - in_state_s_ / rules::kLieDown_s);
  if (in_state_s_ >= rules::kLieDown_s) rise();  // or waits on the edge
}

void Agent::stand_up() {
  between_seat_and_spot(1 - in_state_s_ / rules::kSitDown_s);
  if (in_state_s_ < rules::kSitDown_s) return;
  place_ = floor_.crowd.place(*walker_);
  goal_.reset();
  set(AgentState::kStanding);
  if (const auto next = std::exchange(next_, std::nullopt)) begin(*next);
}

}  // namespace panoptic
