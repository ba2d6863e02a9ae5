// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the triangle that a ray meets and the one nearest to a point: the one seam to Embree.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "panoptic/sim/surfaces.h"

namespace panoptic {

constexpr int kPacketRays = 16;
constexpr std::uint32_t kNoTriangle = UINT32_MAX;

// Rays from one point. Directions need not be of unit length: distances are in units of their length.
struct RayPacket {
  Vec3f origin = Vec3f::Zero();
  alignas(64) std::array<float, kPacketRays> x{};
  alignas(64) std::array<float, kPacketRays> y{};
  alignas(64) std::array<float, kPacketRays> z{};
  float max_distance = 0;
  bool coherent = false;  // the rays run side by side, as neighbouring pixels' do; a hint for speed
};

// u and v are the weights of a triangle's second and third corner.
struct PacketHits {
  alignas(64) std::array<float, kPacketRays> distance;
  alignas(64) std::array<float, kPacketRays> u;
  alignas(64) std::array<float, kPacketRays> v;
  alignas(64) std::array<std::uint32_t, kPacketRays> triangle;  // kNoTriangle: nothing is hit
};

struct RayHit {
  float distance = 0;
  std::uint32_t triangle = kNoTriangle;
};

struct NearestTriangle {
  double distance_m = 0;
  std::uint32_t triangle = kNoTriangle;
};

// Triangles are hit from both sides, and no ray slips through between two that share an edge. Threads: const functions may run
// side by side.
class RayTracer {
 public:
  // The surfaces must outlive the tracer. Throws Error if Embree refuses.
  explicit RayTracer(const Surfaces& surfaces);
  // Traces only these triangles, in ascending order; hits have their numbers in `surfaces`.
  RayTracer(const Surfaces& surfaces, std::vector<std::uint32_t> chosen);
  ~RayTracer();
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  void trace(const RayPacket& rays, PacketHits& hits) const;
  RayHit trace(const Vec3f& origin, const Vec3f& direction, float max_distance) const;

  // The triangle with the point nearest to p, at the same distance the one with the lowest number; nothing beyond max_m.
  std::optional<NearestTriangle> nearest(const Vec3d& p, double max_m) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
