// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Ways over the floor of a map, for an agent of some size. Metres, in the z-up frame of the map (planning.h).
//   const UpFrame frame = up_frame(map);
//   const NavigationMesh floor(map, frame, {.radius_m = 0.3});
//   const Path path = floor.path({0, 0, 0}, {4, 2, 0});
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/labels.h"
#include "panoptic/map.h"
#include "panoptic/planning.h"

namespace panoptic {

struct Path {
  bool found = false;
  double length_m = 0;
  std::vector<Vec3d> points_m;  // where the agent's feet go, start and goal included
  std::string why_not;          // if it was not found
};

// The object or class that a node of scene.glb is called after: "chair_31", "floor". An object that was merged into another
// one is that one. Throws Error if the map has no such node.
PanopticId node_named(const PanopticMap& map, std::string_view name);

// The floor on which an agent may stand, as polygons. A copy of what it needs: the map may change afterwards.
class NavigationMesh {
 public:
  // Throws Error if the agent's size is out of range, or the map too large.
  NavigationMesh(const PanopticMap& map, const UpFrame& frame, const AgentSize& agent = {});
  NavigationMesh(NavigationMesh&&) noexcept;
  NavigationMesh& operator=(NavigationMesh&&) noexcept;
  NavigationMesh(const NavigationMesh&) = delete;
  NavigationMesh& operator=(const NavigationMesh&) = delete;
  ~NavigationMesh();

  double area_m2() const;       // on which the agent's centre may be
  std::size_t islands() const;  // parts of it without a way between them
  std::size_t polygon_count() const;
  // True if the agent's centre may be above or at most 2 m below this point: a point of the agent's body, or its feet.
  bool is_walkable(const Vec3d& point_m) const;

  // The way between two places. They may be nearer to an obstacle than the agent's radius: the nearest place to stand counts.
  // Throws Error if one is in an obstacle, or where no floor was seen.
  Path path(const Vec3d& from_m, const Vec3d& to_m) const;
  // The way to a place next to an object or a class of stuff, without a wall or another thing between, at most 1.5 m away.
  // Throws Error if the start is no place to stand, or the object has no surface.
  Path path_to(const Vec3d& from_m, PanopticId goal) const;

  // The polygons as triangles.
  struct Triangles {
    std::vector<Vec3f> vertices_m;
    std::vector<std::array<std::uint32_t, 3>> corners;  // counter-clockwise from above
  };
  Triangles triangles() const;
  std::string detour_bytes() const;  // of a file as RecastDemo saves it; its axes are (x, z, -y)

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
