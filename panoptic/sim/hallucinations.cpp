// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/hallucinations.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "panoptic/sim/prediction_classes.h"

namespace panoptic {
namespace {

constexpr double kPlace_m = 0.6;    // the world is divided into cubes; each is a place where something may seem to be
constexpr double kShift_m = 0.237;  // floors and walls stand at round numbers: they must not lie where two cubes meet
constexpr double kSmallest_m = 0.15;
constexpr double kLargest_m = 0.4;
constexpr int kLeast_px = 150;  // networks report nothing smaller

struct Place {
  std::uint64_t key;
  Vec3d center_m;  // world
  double radius_m;

  bool operator<(const Place& other) const { return key < other.key; }
};

Place place_at(const Vec3d& world_point, std::uint64_t seed) {
  const Vec3d shift = Vec3d::Constant(kShift_m);
  const Vec3d cell = ((world_point + shift) / kPlace_m).array().floor();
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) key = hash_bits(key, static_cast<std::uint64_t>(static_cast<std::int64_t>(cell[axis])));
  Random random(seed, static_cast<std::uint64_t>(Effect::kHallucinated), key);
  Vec3d within;  // one after the other: the order in which arguments are evaluated is the compiler's choice
  for (const int axis : {2, 1, 0}) within[axis] = random.uniform();
  const Vec3d center = (cell + within) * kPlace_m - shift;
  return {key, center, random.uniform(kSmallest_m, kLargest_m)};
}

// The places that the frame sees, ascending by key, each once.
std::vector<Place> visible_places(const Observation& o) {
  constexpr int kStep_px = 16;
  const Image<float>& depth = o.frame.rendering.depth;
  std::vector<Place> places;
  for (int v = kStep_px / 2; v < depth.height(); v += kStep_px) {
    for (int u = kStep_px / 2; u < depth.width(); u += kStep_px) {
      if (depth(u, v) <= 0) continue;
      const Vec3d point = back_project(o.frame.frame.color_camera, u, v, static_cast<double>(depth(u, v)));
      places.push_back(place_at(o.frame.true_world_from_camera * point, o.seed));
    }
  }
  std::sort(places.begin(), places.end());
  const auto same = [](const Place& a, const Place& b) { return a.key == b.key; };
  places.erase(std::unique(places.begin(), places.end(), same), places.end());
  return places;
}

// The pixels whose surface lies within the ball.
std::optional<Instance> cut_out(const Observation& o, const Place& place) {
  const Camera& camera = o.frame.frame.color_camera;
  const Image<float>& depth = o.frame.rendering.depth;
  const Vec3d center = o.frame.true_world_from_camera.inverse() * place.center_m;
  if (center.z() < 2 * place.radius_m) return std::nullopt;
  const double reach_px = camera.fx * place.radius_m / (center.z() - place.radius_m) + 1;
  const double u = camera.fx * center.x() / center.z() + camera.cx;
  const double v = camera.fy * center.y() / center.z() + camera.cy;
  const auto low = [&](double middle, int size) { return static_cast<int>(std::clamp(middle - reach_px, 0.0, size * 1.0)); };
  const auto high = [&](double middle, int size) { return static_cast<int>(std::clamp(middle + reach_px, 0.0, size * 1.0)); };
  const int x0 = low(u, depth.width());
  const int y0 = low(v, depth.height());
  Instance instance{{}, x0, y0, Image<std::uint8_t>(high(u, depth.width()) - x0, high(v, depth.height()) - y0, std::uint8_t{0})};
  int area_px = 0;
  for (int y = 0; y < instance.mask.height(); ++y) {
    for (int x = 0; x < instance.mask.width(); ++x) {
      const auto z = static_cast<double>(depth(x0 + x, y0 + y));
      const Vec3d point = back_project(camera, x0 + x, y0 + y, z);
      if (z <= 0 || (point - center).squaredNorm() > place.radius_m * place.radius_m) continue;
      instance.mask(x, y) = 1;
      ++area_px;
    }
  }
  return area_px >= kLeast_px ? std::optional(std::move(instance)) : std::nullopt;
}

}  // namespace

std::vector<Instance> hallucinations(const Observation& o) {
  std::vector<Instance> found;
  if (o.noise.hallucinated <= 0) return found;
  for (const Place& place : visible_places(o)) {
    if (o.chance(Effect::kHallucinated, place.key) >= static_cast<double>(o.noise.hallucinated)) continue;
    std::optional<Instance> instance = cut_out(o, place);
    if (!instance) continue;
    const ClassId class_id = pick_hallucination(o.fixed_chance(Effect::kWhich, place.key), o.labels);
    Random random(o.seed, hash_bits(static_cast<std::uint64_t>(Effect::kScore), place.key), o.frame_number());
    instance->segment = to_segment(class_id, class_id, draw_score(false, o.noise, random), o.labels);
    found.push_back(std::move(*instance));
  }
  return found;
}

}  // namespace panoptic
