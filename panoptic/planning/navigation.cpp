// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/navigation.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/io/glb_parts.h"
#include "panoptic/planning/ground.h"

namespace panoptic {

PanopticId node_named(const PanopticMap& map, std::string_view name) {
  for (const LabelClass& c : map.labels.classes()) {
    if (glb_node_name(LabelSet::id_of_class(c.id), c.id, map.labels) == name) return LabelSet::id_of_class(c.id);
  }
  const std::size_t line = name.rfind('_');
  std::uint32_t id = 0;
  if (line != std::string_view::npos) {
    const auto [end, error] = std::from_chars(name.data() + line + 1, name.data() + name.size(), id);
    if (error != std::errc() || end != name.data() + name.size()) id = 0;
  }
  const PanopticId survivor = map.objects.survivor(PanopticId{id});
  const Object* object = map.objects.find(survivor);
  if (object != nullptr) {
    const std::string own_name = glb_node_name(survivor, map.class_of(survivor), map.labels);
    if (own_name == name || survivor != PanopticId{id}) return survivor;
    throw Error(fmt::format("there is no '{}' in the map; its object {} is called '{}'", name, id, own_name));
  }
  throw Error(
      fmt::format("there is no '{}' in the map: names are those of the nodes in scene.glb, like chair_31 or floor", name));
}

struct NavigationMesh::State {
  State(const PanopticMap& map, const UpFrame& frame, const AgentSize& agent)
      : ground(ground_of(map, frame, surface_samples(map.voxels), agent)), mesh(ground.columns, agent) {}

  Ground ground;
  RecastMesh mesh;
};

NavigationMesh::NavigationMesh(const PanopticMap& map, const UpFrame& frame, const AgentSize& agent) {
  check(agent);
  state_ = std::make_unique<State>(map, frame, agent);
}

NavigationMesh::NavigationMesh(NavigationMesh&&) noexcept = default;
NavigationMesh& NavigationMesh::operator=(NavigationMesh&&) noexcept = default;
NavigationMesh::~NavigationMesh() = default;

double NavigationMesh::area_m2() const { return walkable_area_m2(state_->ground.columns); }
std::size_t NavigationMesh::islands() const { return island_count(state_->ground.columns); }
std::size_t NavigationMesh::polygon_count() const { return state_->mesh.polygon_count(); }

bool NavigationMesh::is_walkable(const Vec3d& point_m) const {
  const GroundGrid& grid = state_->ground.columns.grid;
  const auto spot = grid.around(point_m.head<2>());
  if (!point_m.allFinite() || !grid.contains(spot)) return false;
  const std::span<const SolidSpan> spans = std::as_const(state_->ground.columns).of(grid.index(spot));
  return std::any_of(spans.begin(), spans.end(), [&](const SolidSpan& span) {
    constexpr double kBelow_m = 2;
    constexpr double kAbove_m = 0.3;
    return span.is_walkable && span.top_m <= point_m.z() + kAbove_m && span.top_m >= point_m.z() - kBelow_m;
  });
}

Path NavigationMesh::path(const Vec3d& from_m, const Vec3d& to_m) const {
  return path_between(state_->ground, state_->mesh, from_m, to_m);
}

Path NavigationMesh::path_to(const Vec3d& from_m, PanopticId goal) const {
  return path_beside(state_->ground, state_->mesh, from_m, goal);
}

NavigationMesh::Triangles NavigationMesh::triangles() const {
  FlatTriangles flat = state_->mesh.triangles();
  return {std::move(flat.vertices), std::move(flat.triangles)};
}

std::string NavigationMesh::detour_bytes() const { return state_->mesh.bytes(); }

}  // namespace panoptic
