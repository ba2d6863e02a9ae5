// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace panoptic {
namespace {

constexpr double kStep_m = 0.62;  // of a person; a foot is put down so far ahead of the other
constexpr double kThigh = 0.245;  // lengths are shares of the height
constexpr double kShin = 0.24;
constexpr double kAnkle = 0.045;
constexpr double kPelvis = 0.062;  // half its thickness

// Limbs in the frame of a body: x to the right, y ahead, z up.
struct Builder {
  const BodyPose& pose;
  std::vector<Limb> limbs = {};

  Vec3d world(const Vec3d& p) const {
    const Eigen::Vector2d ahead(std::cos(pose.heading), std::sin(pose.heading));
    const Eigen::Vector2d right(ahead.y(), -ahead.x());
    const Eigen::Vector2d at = pose.at + p.x() * right + p.y() * ahead;
    return {at.x(), at.y(), p.z()};
  }
  void add(const Vec3d& from, const Vec3d& to, double radius_m, const Rgb& color) {
    limbs.push_back({world(from).cast<float>(), world(to).cast<float>(), static_cast<float>(radius_m), color});
  }
  void ball(const Vec3d& center, double radius_m, const Rgb& color) { add(center, center, radius_m, color); }
};

// A foot's way over a cycle of two steps: it stands while the body passes over it, then swings ahead.
struct FootStep {
  double ahead_m = 0;
  double lift_m = 0;
};
FootStep foot_step(double walked_m, double step_m, double phase) {
  const double cycle = walked_m / (2 * step_m) + phase;
  const double at = 2 * (cycle - std::floor(cycle));  // 0..1 stands, 1..2 swings
  if (at < 1) return {step_m * (0.5 - at), 0};
  return {step_m * (at - 1.5), 0.1 * step_m * std::sin(std::numbers::pi * (at - 1))};
}

// The knee between hip and ankle, bent forwards.
Vec3d knee(const Vec3d& hip, const Vec3d& ankle, double thigh_m, double shin_m) {
  const Vec3d leg = ankle - hip;
  const double length_m = std::min(leg.norm(), 0.9999 * (thigh_m + shin_m));
  const double along_m = (thigh_m * thigh_m - shin_m * shin_m + length_m * length_m) / (2 * length_m);
  const double out_m = std::sqrt(std::max(0.0, thigh_m * thigh_m - along_m * along_m));
  const Vec3d direction = leg.normalized();
  const Vec3d forwards = Vec3d(0, -direction.z(), direction.y()).normalized();
  return hip + along_m * direction + out_m * forwards;
}

struct Legs {
  Vec3d pelvis;                 // its middle
  std::array<Vec3d, 2> ankles;  // right, left
};

Legs legs_of(const Body& body, const BodyPose& pose) {
  const double h = body.height_m;
  const double reach_m = 0.995 * (kThigh + kShin) * h;
  Legs legs;
  double pelvis_m = 0.53 * h;
  for (std::size_t side = 0; side < 2; ++side) {
    const FootStep step = foot_step(pose.walked_m, kStep_m, side == 0 ? 0 : 0.5);
    const double ahead_m = pose.stride * step.ahead_m;
    legs.ankles[side] = {(side == 0 ? 1 : -1) * 0.055 * h, ahead_m, kAnkle * h + pose.stride * step.lift_m};
    if (step.lift_m > 0) continue;
    pelvis_m = std::min(pelvis_m, kAnkle * h + std::sqrt(reach_m * reach_m - ahead_m * ahead_m));
  }
  legs.pelvis = {0, 0, pelvis_m};
  if (pose.down <= 0) return legs;
  const Eigen::Vector2d ahead(std::cos(pose.heading), std::sin(pose.heading));
  const Eigen::Vector2d offset = pose.seat.head<2>() - pose.at;
  const Vec3d seated(0, offset.dot(ahead), pose.seat.z() + kPelvis * h);
  legs.pelvis += pose.down * (seated - legs.pelvis);
  return legs;
}

void add_legs(const Body& body, const Legs& legs, Builder& b) {
  const double h = body.height_m;
  for (std::size_t side = 0; side < 2; ++side) {
    const Vec3d& ankle = legs.ankles[side];
    const Vec3d hip = legs.pelvis + Vec3d(ankle.x(), 0, 0);
    const Vec3d bend = knee(hip, ankle, kThigh * h, kShin * h);
    b.add(hip, bend, 0.046 * h, body.trousers);
    b.add(bend, ankle, 0.034 * h, body.trousers);
    b.add(ankle + Vec3d(0, -0.02 * h, -0.02 * h), ankle + Vec3d(0, 0.1 * h, -0.022 * h), 0.0225 * h, body.shoes);
  }
  b.add(legs.pelvis + Vec3d(-0.05 * h, 0, 0), legs.pelvis + Vec3d(0.05 * h, 0, 0), kPelvis * h, body.trousers);
}

// Arms swing against the legs, or lie on the thighs of who sits.
void add_arms(const Body& body, const BodyPose& pose, const Legs& legs, const Vec3d& neck, Builder& b) {
  const double h = body.height_m;
  for (std::size_t side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1 : -1;
    const Vec3d shoulder = neck + Vec3d(sign * 0.125 * h, 0, -0.05 * h);
    const double swing = -1.1 * legs.ankles[side].y();
    const Vec3d hanging(sign * 0.02 * h, 0.25 * swing + 0.01 * h, -0.17 * h);
    const Vec3d elbow = shoulder + (1 - pose.down) * hanging + pose.down * Vec3d(sign * 0.02 * h, 0.06 * h, -0.16 * h);
    const Vec3d low(0, 0.5 * swing + 0.03 * h, -0.145 * h);
    const Vec3d hand = elbow + (1 - pose.down) * low + pose.down * Vec3d(-sign * 0.05 * h, 0.14 * h, -0.02 * h);
    b.add(shoulder, elbow, 0.03 * h, body.shirt);
    b.add(elbow, hand, 0.023 * h, body.skin);
    b.ball(hand + 0.25 * (hand - elbow), 0.028 * h, body.skin);
  }
}

std::vector<Limb> person(const Body& body, const BodyPose& pose) {
  const double h = body.height_m;
  Builder b{pose};
  const Legs legs = legs_of(body, pose);
  add_legs(body, legs, b);
  // Who sits down or gets up leans forward on the way.
  const double lean_m = 0.12 * h * std::sin(std::numbers::pi * pose.down) + 0.012 * h * pose.stride;
  const Vec3d neck = legs.pelvis + Vec3d(0, lean_m, 0.33 * h);
  for (const double side : {-0.055, 0.055}) {
    const Vec3d out(side * h, 0, 0);
    b.add(legs.pelvis + out + Vec3d(0, 0, 0.05 * h), neck + 1.2 * out + Vec3d(0, 0, -0.07 * h), 0.06 * h, body.shirt);
  }
  b.add(legs.pelvis + Vec3d(0, 0, 0.04 * h), neck + Vec3d(0, 0, -0.06 * h), 0.066 * h, body.shirt);
  b.add(neck + Vec3d(-0.1 * h, 0, -0.045 * h), neck + Vec3d(0.1 * h, 0, -0.045 * h), 0.045 * h, body.shirt);
  add_arms(body, pose, legs, neck, b);
  const Vec3d head = neck + Vec3d(0, 0.012 * h, 0.078 * h);
  b.add(neck + Vec3d(0, 0, -0.02 * h), head, 0.03 * h, body.skin);
  b.add(head + Vec3d(0, 0.008 * h, -0.014 * h), head + Vec3d(0, 0.004 * h, 0.014 * h), 0.05 * h, body.skin);
  b.add(head + Vec3d(0, -0.014 * h, 0), head + Vec3d(0, -0.006 * h, 0.02 * h), 0.052 * h, body.hair);
  for (const double side : {-0.02, 0.02}) b.ball(head + Vec3d(side * h, 0.054 * h, 0.006 * h), 0.006 * h, {30, 26, 24});
  b.ball(head + Vec3d(0, 0.059 * h, -0.01 * h), 0.009 * h, body.skin);
  return b.limbs;
}

// Measures of a pet as shares of the height of its back.
struct PetShape {
  double trunk;
  double trunk_radius;
  double leg_radius;
  double head_radius;
  double snout;
  double tail;
};

void add_pet_legs(const Body& body, const BodyPose& pose, const PetShape& s, double back_m, Builder& b) {
  const double h = body.height_m;
  const double r = s.leg_radius * h;
  for (int leg = 0; leg < 4; ++leg) {
    const bool is_front = leg < 2;
    const double side = leg % 2 == 0 ? 1 : -1;
    const FootStep step = foot_step(pose.walked_m, 0.9 * h, (leg == 0 || leg == 3) ? 0 : 0.5);
    const Vec3d top(side * 0.55 * s.trunk_radius * h, (is_front ? 0.42 : -0.42) * s.trunk * h, back_m);
    const Vec3d standing(top.x(), top.y() + 0.6 * pose.stride * step.ahead_m, r + pose.stride * step.lift_m);
    const Vec3d lying(1.6 * top.x(), top.y() + 0.5 * h, r);
    b.add(top, standing + pose.down * (lying - standing), r, body.hair);
  }
}

std::vector<Limb> pet(const Body& body, const BodyPose& pose) {
  const PetShape s =
      body.kind == BodyKind::kDog ? PetShape{1.25, 0.24, 0.065, 0.2, 0.26, 0.55} : PetShape{1.35, 0.26, 0.06, 0.24, 0.1, 1.0};
  const double h = body.height_m;
  const double r = s.trunk_radius * h;
  Builder b{pose};
  const double back_m = std::lerp(h - r, r, std::clamp(pose.down, 0.0, 1.0));
  const Vec3d front(0, 0.42 * s.trunk * h, back_m);
  const Vec3d rear(0, -0.42 * s.trunk * h, back_m - 0.02 * h);
  b.add(rear, front, r, body.hair);
  add_pet_legs(body, pose, s, back_m, b);
  const Vec3d head = front + Vec3d(0, 0.3 * h, 0.42 * h);
  b.add(front, head, 0.6 * r, body.hair);
  b.ball(head, s.head_radius * h, body.hair);
  b.add(head, head + Vec3d(0, (s.head_radius + s.snout) * h, -0.06 * h), 0.45 * s.head_radius * h, body.skin);
  for (const double side : {-1.0, 1.0}) {
    const Vec3d ear = head + Vec3d(side * 0.75 * s.head_radius * h, 0, 0.85 * s.head_radius * h);
    b.add(ear, ear + Vec3d(0, 0, 0.35 * s.head_radius * h), 0.3 * s.head_radius * h, body.hair);
    b.ball(head + Vec3d(side * 0.4 * s.head_radius * h, 0.88 * s.head_radius * h, 0.2 * s.head_radius * h),
           0.16 * s.head_radius * h, {24, 22, 20});
  }
  b.add(rear, rear + Vec3d(0, -0.6 * s.tail * h, 0.5 * s.tail * h * (1 - 0.9 * pose.down)), 0.25 * r, body.hair);
  return b.limbs;
}

}  // namespace

Body random_body(BodyKind kind, Random& random) {
  static const std::vector<Rgb> kSkins = {{236, 188, 158}, {224, 172, 136}, {176, 122, 86}, {118, 78, 54}};
  static const std::vector<Rgb> kHairs = {{46, 34, 26}, {92, 62, 38}, {168, 130, 80}, {120, 116, 112}};
  static const std::vector<Rgb> kShirts = {{70, 100, 160}, {170, 60, 56}, {220, 214, 200}, {72, 120, 84}, {206, 150, 60}};
  static const std::vector<Rgb> kTrousers = {{48, 56, 84}, {50, 52, 56}, {130, 112, 88}, {92, 96, 102}};
  static const std::vector<Rgb> kFurs = {{110, 78, 50}, {196, 156, 104}, {64, 60, 58}, {206, 200, 190}};
  Body body;
  body.kind = kind;
  if (kind == BodyKind::kPerson) {
    body.height_m = random.uniform(1.5, 1.9);
    body.skin = random.pick(kSkins);
    body.hair = random.pick(kHairs);
    body.shirt = random.pick(kShirts);
    body.trousers = random.pick(kTrousers);
    return body;
  }
  body.height_m = kind == BodyKind::kDog ? random.uniform(0.4, 0.58) : random.uniform(0.24, 0.29);
  body.hair = random.pick(kFurs);
  body.skin = {90, 76, 66};
  return body;
}

ClassId class_of(BodyKind kind) {
  if (kind == BodyKind::kPerson) return kPersonClass;
  return kind == BodyKind::kCat ? kCatClass : kDogClass;
}

std::vector<Limb> limbs_of(const Body& body, const BodyPose& pose) {
  return body.kind == BodyKind::kPerson ? person(body, pose) : pet(body, pose);
}

}  // namespace panoptic
