// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/prediction_things.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "panoptic/sim/hallucinations.h"
#include "panoptic/sim/prediction_classes.h"
#include "panoptic/sim/visible_things.h"

namespace panoptic {
namespace {

// A cut through the world: points p of the camera's frame with normal . p >= offset_m are on the first side.
struct Cut {
  Vec3d normal = Vec3d::UnitX();
  double offset_m = 0;
};

// One thing, or a part of it, or two things taken for one.
struct Finding {
  const VisibleThing* thing = nullptr;
  const VisibleThing* merged = nullptr;
  std::optional<Cut> cut;  // the part on its first side
};

double miss_chance(const Observation& o, const VisibleThing& thing) {
  const PredictionNoise& n = o.noise;
  double found = 1 - static_cast<double>(n.missed);
  if (n.small_px > 0) {
    const double ratio = thing.area_px / static_cast<double>(n.small_px);
    found *= 1 - 1 / (1 + ratio * std::sqrt(ratio));
  }
  if (n.far_m > 0) found *= 1 - 1 / (1 + std::pow(static_cast<double>(n.far_m) / thing.center_m.z(), 4));
  const double box_px = (thing.x1 - thing.x0) + (thing.y1 - thing.y0) + 2;
  found *= 1 - static_cast<double>(n.truncated) * std::min(1.0, 2 * thing.border_px / box_px);
  return 1 - found;
}

// Upright or level, through the middle of what is seen, at the same angle in every frame.
Cut cut_through(const Observation& o, const VisibleThing& thing) {
  const double angle = 2 * std::numbers::pi * o.fixed_chance(Effect::kSplit, thing.instance);
  const bool level = o.fixed_chance(Effect::kFavourite, thing.instance) < 0.4;
  const Vec3d in_world = level ? Vec3d(0, 0, 1) : Vec3d(std::cos(angle), std::sin(angle), 0);
  const Vec3d normal = o.frame.true_world_from_camera.linear().transpose() * in_world;
  return {normal, normal.dot(thing.center_m)};
}

// Which things are found, and how they are divided.
std::vector<Finding> findings_of(const Observation& o, const std::vector<VisibleThing>& things) {
  std::vector<const VisibleThing*> partner(things.size(), nullptr);
  std::vector<bool> gone(things.size(), false);
  if (o.noise.merged > 0) {
    for (const auto& [a, b] : touching_pairs(o.frame.rendering, things)) {
      const std::uint64_t key = std::uint64_t{things[a].instance} << 16U | things[b].instance;
      if (gone[a] || gone[b] || partner[a] != nullptr || partner[b] != nullptr) continue;
      if (o.chance(Effect::kMerged, key) >= static_cast<double>(o.noise.merged)) continue;
      partner[a] = &things[b];
      gone[b] = true;
    }
  }
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < things.size(); ++i) {
    const VisibleThing& thing = things[i];
    if (gone[i] || o.chance(Effect::kMissed, thing.instance) < miss_chance(o, thing)) continue;
    Finding whole{&thing, partner[i], std::nullopt};
    if (partner[i] != nullptr || o.chance(Effect::kSplit, thing.instance) >= static_cast<double>(o.noise.split)) {
      findings.push_back(whole);
      continue;
    }
    whole.cut = cut_through(o, thing);
    findings.push_back(whole);
    whole.cut = Cut{-whole.cut->normal, -whole.cut->offset_m};
    findings.push_back(whole);
  }
  return findings;
}

struct Mask {
  Instance instance;
  int area_px = 0;
  int shared_px = 0;  // with the thing
};

bool on_side(const Cut& cut, const Camera& camera, int u, int v, float depth) {
  return cut.normal.dot(back_project(camera, u, v, static_cast<double>(depth))) >= cut.offset_m;
}

// The true mask, looked up where the field says.
Mask draw_mask(const Observation& o, const DisplacementField& field, const Finding& finding) {
  constexpr float kMostOfSize = 0.2F;
  constexpr float kReach = 3;
  const Rendering& r = o.frame.rendering;
  const VisibleThing& a = *finding.thing;
  const VisibleThing& b = finding.merged != nullptr ? *finding.merged : a;
  const float size_px = std::sqrt(static_cast<float>(a.area_px));
  const float deviation_px = std::min(o.noise.boundary_px + o.noise.boundary_share * size_px, kMostOfSize * size_px);
  const int margin = static_cast<int>(std::ceil(kReach * deviation_px));
  const int x0 = std::max(std::min(a.x0, b.x0) - margin, 0);
  const int y0 = std::max(std::min(a.y0, b.y0) - margin, 0);
  const int x1 = std::min(std::max(a.x1, b.x1) + margin + 1, r.instance.width());
  const int y1 = std::min(std::max(a.y1, b.y1) + margin + 1, r.instance.height());
  Mask mask{{{}, x0, y0, Image<std::uint8_t>(x1 - x0, y1 - y0, std::uint8_t{0})}};
  for (int v = y0; v < y1; ++v) {
    for (int u = x0; u < x1; ++u) {
      const auto [from_u, from_v] = field.source(u, v, deviation_px);
      const std::uint16_t instance = r.instance(from_u, from_v);
      if (instance != a.instance && instance != b.instance) continue;
      if (finding.cut && !on_side(*finding.cut, o.frame.frame.color_camera, from_u, from_v, r.depth(from_u, from_v))) continue;
      mask.instance.mask(u - x0, v - y0) = 1;
      ++mask.area_px;
      if (r.instance(u, v) == a.instance) ++mask.shared_px;
    }
  }
  return mask;
}

ClassId class_given(const Observation& o, const VisibleThing& thing) {
  constexpr double kFavourite = 0.7;  // how often a thing is taken for the same other class
  if (o.chance(Effect::kConfused, thing.instance) >= static_cast<double>(o.noise.confused)) return thing.class_id;
  const double for_ever = o.fixed_chance(Effect::kWhich, thing.instance);
  const std::uint64_t now =
      hash_bits(o.seed, hash_bits(static_cast<std::uint64_t>(Effect::kWhich), thing.instance), o.frame_number());
  const bool favourite = unit_interval(mix_bits(now)) < kFavourite;
  return pick_mistake(thing.class_id, favourite ? for_ever : unit_interval(now), o.labels);
}

// Correct as the metrics have it: of the right class and with an IoU above one half.
bool is_correct(const Mask& mask, const VisibleThing& thing, ClassId given) {
  return given == thing.class_id && 3 * mask.shared_px > mask.area_px + thing.area_px;
}

}  // namespace

std::vector<Instance> noisy_things(const Observation& o, const DisplacementField& field) {
  const std::vector<VisibleThing> things = visible_things(o.frame.rendering, o.frame.frame.color_camera);
  std::vector<Instance> found = hallucinations(o);
  for (const Finding& finding : findings_of(o, things)) {
    const VisibleThing& thing = *finding.thing;
    Mask mask = draw_mask(o, field, finding);
    if (mask.area_px == 0) continue;
    const ClassId given = class_given(o, thing);
    Random random(o.seed, hash_bits(static_cast<std::uint64_t>(Effect::kScore), found.size()), o.frame_number());
    const float score = draw_score(is_correct(mask, thing, given), o.noise, random);
    mask.instance.segment = to_segment(thing.class_id, given, score, o.labels);
    found.push_back(std::move(mask.instance));
  }
  return found;
}

}  // namespace panoptic
