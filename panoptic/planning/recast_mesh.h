// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A navigation mesh: the one seam to Recast, which makes polygons of walkable spots, and Detour, which finds ways over them.
// Points have z up here; Detour's own axes are (x, z, -y).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/planning/columns.h"

namespace panoptic {

struct FlatTriangles {
  std::vector<Vec3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise from above
};

class RecastMesh {
 public:
  // REQUIRES columns that mark_walkable has seen for this agent. Throws Error if there are more spots or polygons than Recast's
  // numbers hold.
  RecastMesh(const SolidColumns& columns, const AgentSize& agent);
  RecastMesh(RecastMesh&&) noexcept;
  RecastMesh& operator=(RecastMesh&&) noexcept;
  RecastMesh(const RecastMesh&) = delete;
  RecastMesh& operator=(const RecastMesh&) = delete;
  ~RecastMesh();

  // False if nothing is walkable.
  bool has_polygons() const;
  std::size_t polygon_count() const;
  FlatTriangles triangles() const;

  // The corners of the shortest way over the polygons between those nearest to the two points; nothing if there is no way.
  std::optional<std::vector<Vec3d>> way(const Vec3d& from, const Vec3d& to) const;

  // A file of Detour's tiles, as RecastDemo and other programs save them: magic MSET, version 1.
  std::string bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
