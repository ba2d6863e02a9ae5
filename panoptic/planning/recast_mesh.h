// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A navigation mesh: the one seam to Recast, which makes polygons of walkable spots, and Detour, which finds ways over them and
// lets many walk there at once. Points have z up here; Detour's own axes are (x, z, -y).
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

  // The place on the polygons nearest to a point, at most `far_m` away along the floor and a metre up or down; nothing if there
  // is none.
  std::optional<Vec3d> nearest(const Vec3d& point, double far_m) const;

  // A file of Detour's tiles, as RecastDemo and other programs save them: magic MSET, version 1.
  std::string bytes() const;

 private:
  friend class RecastCrowd;
  struct State;
  std::unique_ptr<State> state_;
};

// How one walks among others; metres and seconds.
struct WalkRules {
  double radius_m = 0;
  double height_m = 0;
  double acceleration_m_s2 = 0;
  double speed_m_s = 0;    // at most
  double looks_m = 0;      // how far it heeds others
  double optimizes_m = 0;  // how far ahead it makes its way shorter
  double separation = 0;   // how much it keeps away from others
};

// Walkers on a mesh who avoid each other. The same calls give the same steps. One thread at a time.
class RecastCrowd {
 public:
  using Walker = int;

  // REQUIRES a mesh with polygons, which must live as long.
  RecastCrowd(const RecastMesh& mesh, std::size_t most_walkers, double radius_m);
  RecastCrowd(RecastCrowd&&) noexcept;
  RecastCrowd& operator=(RecastCrowd&&) noexcept;
  RecastCrowd(const RecastCrowd&) = delete;
  RecastCrowd& operator=(const RecastCrowd&) = delete;
  ~RecastCrowd();

  // Somebody who stands there, on the polygons; nothing if there are too many already.
  std::optional<Walker> enter(const Vec3d& at, const WalkRules& rules);
  void leave(Walker walker);

  void go(Walker walker, const Vec3d& to);
  void stop(Walker walker);
  Vec3d place(Walker walker) const;
  // Whether none of the others is nearer than two radii to a place.
  bool is_clear(const Vec3d& at, std::optional<Walker> own) const;

  void step(double seconds);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
