// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The light that arrives at the surfaces of a scene: from the sun, from lamps, and scattered by the room. It does not depend on
// the camera, so every place is computed once: when it is first seen. Places are the corners of small triangles and, on large
// ones, a lattice of points a few centimetres apart, and what is between is interpolated.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <vector>

#include "panoptic/sim/model_places.h"
#include "panoptic/sim/ray_tracer.h"
#include "panoptic/sim/scene.h"
#include "panoptic/sim/surfaces.h"

namespace panoptic {

enum class LitSide : std::uint8_t { kFront, kBack };  // the front is where the corners run counter-clockwise

// Threads: at() may be called side by side. Whoever sees a place first computes it, and all would compute the same, so the
// light depends neither on the order of calls nor on the number of threads.
class Lighting {
 public:
  // All must outlive the lighting. `albedos`: mean colour of every material, linear.
  Lighting(const Scene& scene, const Surfaces& surfaces, const RayTracer& tracer, std::vector<Vec3f> albedos);

  // Linear RGB at the point with weights u, v of the triangle's second and third corner.
  Vec3f at(std::uint32_t triangle, float u, float v, LitSide side) const;

  std::size_t places() const { return places_; }

 private:
  // The lattice of a large triangle. Coordinates of a point are linear in u and v. Columns of a right-angled triangle run along
  // one of its short edges: both halves of a rectangle then have the same nodes, which line up with what stands along walls.
  // Other triangles have theirs along the longest edge, and nodes beyond their edges stand for the nearest point within.
  struct Lattice {
    std::uint32_t first = 0;  // place of column 0, row 0; rows follow each other
    std::uint32_t columns = 0;
    std::uint32_t rows = 0;
    bool is_clamped = false;
    Eigen::Vector2f origin = Eigen::Vector2f::Zero();
    Eigen::Vector2f along_u = Eigen::Vector2f::Zero();
    Eigen::Vector2f along_v = Eigen::Vector2f::Zero();
  };
  // Places that something touches from outside are hidden (weight 0): else they would darken what can be seen beside it.
  struct Light {
    Vec3f rgb = Vec3f::Zero();
    float weight = 0;
  };
  // A node of a lattice or a corner, and how much of its light arrives in between.
  struct Share {
    Light light;
    float share = 0;
  };
  struct Place {
    Vec3f point;
    Vec3f normal;   // unit length, smoothed, on the side that is lit
    Vec3f surface;  // the same of the triangle itself
  };

  static Light unpacked(std::uint64_t bits);
  static Vec3f mean(std::initializer_list<Share> shares);
  void add_lattice(std::uint32_t triangle);
  Place place_at(std::uint32_t triangle, const Vec3d& weights, LitSide side) const;
  Light at_corner(std::uint32_t triangle, int corner, LitSide side) const;
  Vec3f at_corners(std::uint32_t triangle, float u, float v, LitSide side) const;
  Vec3f at_lattice(const Lattice& lattice, std::uint32_t triangle, const Eigen::Vector2f& uv, LitSide side) const;
  Light at_node(const Lattice& lattice, std::uint32_t triangle, const std::array<std::uint32_t, 2>& node, LitSide side) const;
  template <typename MakePlace>
  Light remembered(std::uint32_t place, LitSide side, const MakePlace& make_place) const;
  Light arriving(const Place& place) const;
  Light scattered(const Place& place, const Vec3f& origin) const;
  float share_of(const Lamp& lamp, const Vec3f& origin) const;
  bool sun_reaches(Vec3f origin, const Vec3f& direction) const;

  const Scene& scene_;
  const Surfaces& surfaces_;
  const RayTracer& tracer_;
  std::vector<Vec3f> albedos_;
  std::vector<bool> lets_sun_in_;  // per object: windows
  std::vector<ModelPlaces> models_;
  std::vector<std::uint32_t> first_place_;     // per object
  std::vector<std::uint32_t> first_triangle_;  // per object
  std::vector<std::int32_t> lattice_of_;       // per triangle, index into lattices_ or -1
  std::vector<Lattice> lattices_;
  std::size_t places_ = 0;
  // Per place and side: 0 while unknown, else the light (packed by lighting.cpp).
  std::unique_ptr<std::atomic<std::uint64_t>[]> light_;
};

}  // namespace panoptic
