// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One who lives in a map: stands, walks, turns, sits, lies. What the viewer's figures do (apps/viewer/web/src/play/actor.js),
// without limbs. Metres, z up, the floor near z = 0. While it stands and walks the crowd moves it; from the spot before a seat to
// the seat and back it moves by itself.
#pragma once

#include <optional>
#include <vector>

#include "panoptic/base/polygon.h"
#include "panoptic/home_plan.h"
#include "panoptic/planning/recast_mesh.h"

namespace panoptic {

enum class AgentState { kStanding, kWalking, kTurning, kSittingDown, kSitting, kLyingDown, kLying, kGettingUp, kStandingUp };

// "sitting down"
const char* name_of(AgentState state);

// A place to sit down on: a seat, or the edge of a bed.
struct SittingPlace {
  Vec2d at = Vec2d::Zero();
  Vec2d facing = Vec2d::UnitX();
};

// Spots before it where one could stand, the best first.
std::vector<Vec2d> spots_before(const SittingPlace& place);
// The long edges, then the foot.
std::vector<SittingPlace> edges_of(const LyingPlace& bed);

// The floor and those who are on it.
struct PeopledFloor {
  const RecastMesh& mesh;
  RecastCrowd& crowd;
};

class Agent {
 public:
  // `number`: from 0; it decides speed and height of body. Throws Error if there is no room in the crowd.
  Agent(PeopledFloor floor, WalkRules walk, const Vec3d& at, double heading_rad, std::size_t number);

  // Each returns false, and changes nothing, if there is no way. They take what is given by address: it must live as long.
  bool go(const Vec3d& to);
  bool sit(const Seat& seat);
  bool lie(const LyingPlace& bed);
  // Gets up. False if it is not down, or somebody stands where it will.
  bool stand();

  // After a step of the crowd.
  void update(double passed_s);

  AgentState state() const { return state_; }
  Vec3d place() const { return place_; }  // on the floor below its pelvis
  Vec2d facing() const;
  // Whether it is on this seat or bed, or on its way there.
  bool takes(const void* seat_or_bed) const;
  // Whether somebody stands in its way.
  bool is_stuck() const;
  double walked_m() const { return walked_m_; }
  int gave_up() const { return gave_up_; }

 private:
  struct Goal {
    const void* taken = nullptr;  // the seat or bed; none on the floor
    Vec3d spot = Vec3d::Zero();   // where it stands before it
    SittingPlace place;
    bool is_bed = false;
    Vec2d lying_at = Vec2d::Zero();
    double lying_heading_rad = 0;
  };

  bool is_down() const;
  bool is_reached(const Vec3d& at) const;
  bool is_clear(const Vec3d& at) const;
  std::optional<Vec3d> spot_before(const SittingPlace& place) const;
  bool begin(const Goal& goal);
  bool rise();
  void set(AgentState state);
  double on_feet(double passed_s, std::optional<double> heading_rad);
  void walk(double passed_s);
  void arrive(double left_m);
  void give_up();
  void turn(double passed_s);
  void between_seat_and_spot(double share);
  void swing_onto_bed(double share);
  void sit_down();
  void get_up();
  void stand_up();
  void rest();

  PeopledFloor floor_;
  WalkRules walk_;
  std::optional<RecastCrowd::Walker> walker_;
  double height_m_;
  AgentState state_ = AgentState::kStanding;
  Vec3d place_;
  double heading_rad_;
  std::optional<Goal> goal_;
  std::optional<Goal> next_;  // what it was told meanwhile
  double in_state_s_ = 0;
  double stuck_s_ = 0;
  double walked_m_ = 0;
  int gave_up_ = 0;
};

}  // namespace panoptic
