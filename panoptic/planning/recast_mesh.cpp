// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/recast_mesh.h"

#include <DetourCrowd.h>
#include <DetourNavMesh.h>
#include <DetourNavMeshBuilder.h>
#include <DetourNavMeshQuery.h>
#include <Recast.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr int kMostCorners = 6;  // of a polygon; Detour holds no more
constexpr float kContourError_cells = 0.5F;
constexpr unsigned short kWalk = 1;  // flag of polygons
constexpr double kHeightStep_m = 0.01;
constexpr double kMostSpots = 64e6;

template <typename T, void (*Free)(T*)>
struct Freed {
  void operator()(T* p) const { Free(p); }
};
template <typename T, void (*Free)(T*)>
using Owned = std::unique_ptr<T, Freed<T, Free>>;

void require(bool done, const char* what) {
  if (!done) throw Error(fmt::format("the navigation mesh: {} failed; the map is too large or too ragged for Recast", what));
}

std::array<float, 3> to_detour(const Vec3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.z()), static_cast<float>(-p.y())};
}
Vec3d from_detour(const float* p) { return {double{p[0]}, -double{p[2]}, double{p[1]}}; }

struct Frame {
  std::array<float, 3> low{};
  std::array<float, 3> high{};
  double height_step_m = kHeightStep_m;
};

// The box of the heights; the row with the highest y is Detour's first.
Frame frame_of(const SolidColumns& columns) {
  float low = std::numeric_limits<float>::infinity();
  float high = -low;
  for (const SolidSpan& span : columns.spans) {
    low = std::min(low, span.low_m);
    high = std::max(high, span.top_m);
  }
  const GroundGrid& g = columns.grid;
  const auto at = [&](int cells) { return static_cast<float>(cells * g.cell_m); };
  Frame frame{{at(g.low.x()), low, -at(g.low.y() + g.size.y())}, {at(g.low.x() + g.size.x()), high, -at(g.low.y())}};
  constexpr double kMostSteps = 8000;  // spans hold 13 bits
  frame.height_step_m = std::max(kHeightStep_m, (double{high} - low) / kMostSteps);
  return frame;
}

void add_spans(rcContext& context, const SolidColumns& columns, const Frame& frame, rcHeightfield& field) {
  const GroundGrid& g = columns.grid;
  for (std::size_t column = 0; column < g.count(); ++column) {
    const Eigen::Vector2i spot = g.at(column) - g.low;
    for (const SolidSpan& span : columns.of(column)) {
      const auto step = [&](float z) { return static_cast<int>(std::floor((double{z} - frame.low[1]) / frame.height_step_m)); };
      const auto low = static_cast<unsigned short>(step(span.low_m));
      const auto top = static_cast<unsigned short>(step(span.top_m) + 1);
      const unsigned char area = span.is_walkable ? RC_WALKABLE_AREA : RC_NULL_AREA;
      require(rcAddSpan(&context, field, spot.x(), g.size.y() - 1 - spot.y(), low, top, area, 0), "a span");
    }
  }
}

struct Polygons {
  Owned<rcPolyMesh, rcFreePolyMesh> flat{rcAllocPolyMesh()};
  Owned<rcPolyMeshDetail, rcFreePolyMeshDetail> detail{rcAllocPolyMeshDetail()};
};

// Recast's way from spans to polygons. The agent's size is in the spans already.
Polygons polygons_of(const SolidColumns& columns, const AgentSize& agent, const Frame& frame) {
  rcContext context(false);
  const auto cell_m = static_cast<float>(columns.grid.cell_m);
  const auto step_m = static_cast<float>(frame.height_step_m);
  const int climb = static_cast<int>(std::ceil(agent.climb_m / frame.height_step_m));
  const int headroom = std::max(3, static_cast<int>(std::floor(agent.height_m / frame.height_step_m)) - 1);
  Owned<rcHeightfield, rcFreeHeightField> field(rcAllocHeightfield());
  require(rcCreateHeightfield(&context, *field, columns.grid.size.x(), columns.grid.size.y(), frame.low.data(), frame.high.data(),
                              cell_m, step_m),
          "the height field");
  add_spans(context, columns, frame, *field);
  Owned<rcCompactHeightfield, rcFreeCompactHeightfield> open(rcAllocCompactHeightfield());
  require(rcBuildCompactHeightfield(&context, headroom, climb, *field, *open), "the open height field");
  field.reset();
  require(rcBuildDistanceField(&context, *open), "the distance field");
  const int merged = static_cast<int>(std::ceil(1 / (columns.grid.cell_m * columns.grid.cell_m)));  // regions below 1 m2
  require(rcBuildRegions(&context, *open, 0, 0, merged), "dividing into regions");
  Owned<rcContourSet, rcFreeContourSet> contours(rcAllocContourSet());
  require(rcBuildContours(&context, *open, kContourError_cells, 0, *contours), "the contours");
  Polygons polygons;
  require(rcBuildPolyMesh(&context, *contours, kMostCorners, *polygons.flat), "the polygons");
  const float sample_m = 0.5F;
  require(rcBuildPolyMeshDetail(&context, *polygons.flat, *open, sample_m, 2 * step_m, *polygons.detail), "the heights");
  for (int i = 0; i < polygons.flat->npolys; ++i) polygons.flat->flags[i] = kWalk;
  return polygons;
}

// The tile of Detour that holds all polygons.
dtNavMesh* detour_mesh(const Polygons& polygons, const AgentSize& agent) {
  const rcPolyMesh& flat = *polygons.flat;
  const rcPolyMeshDetail& detail = *polygons.detail;
  dtNavMeshCreateParams p{};
  p.verts = flat.verts, p.vertCount = flat.nverts;
  p.polys = flat.polys, p.polyAreas = flat.areas, p.polyFlags = flat.flags, p.polyCount = flat.npolys, p.nvp = flat.nvp;
  p.detailMeshes = detail.meshes, p.detailVerts = detail.verts, p.detailVertsCount = detail.nverts;
  p.detailTris = detail.tris, p.detailTriCount = detail.ntris;
  p.walkableHeight = static_cast<float>(agent.height_m), p.walkableRadius = static_cast<float>(agent.radius_m);
  p.walkableClimb = static_cast<float>(agent.climb_m);
  std::copy_n(flat.bmin, 3, p.bmin);
  std::copy_n(flat.bmax, 3, p.bmax);
  p.cs = flat.cs, p.ch = flat.ch;
  p.buildBvTree = true;
  unsigned char* data = nullptr;
  int size = 0;
  require(dtCreateNavMeshData(&p, &data, &size), "Detour's tile");
  dtNavMesh* mesh = dtAllocNavMesh();
  if (mesh == nullptr || dtStatusFailed(mesh->init(data, size, DT_TILE_FREE_DATA))) {
    dtFree(data);
    dtFreeNavMesh(mesh);
    require(false, "Detour's mesh");
  }
  return mesh;
}

const dtMeshTile* tile_of(const dtNavMesh& mesh) { return mesh.getTile(0); }

template <typename T>
void append_raw(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace

struct RecastMesh::State {
  Owned<dtNavMesh, dtFreeNavMesh> mesh;
  Owned<dtNavMeshQuery, dtFreeNavMeshQuery> query;
};

RecastMesh::RecastMesh(const SolidColumns& columns, const AgentSize& agent) : state_(std::make_unique<State>()) {
  const bool any =
      std::any_of(columns.spans.begin(), columns.spans.end(), [](const SolidSpan& span) { return span.is_walkable; });
  if (!any) return;
  if (static_cast<double>(columns.grid.count()) > kMostSpots) {
    throw Error(fmt::format("the navigation mesh would have {} x {} spots, more than {:.0g}; plan on a part of the map",
                            columns.grid.size.x(), columns.grid.size.y(), kMostSpots));
  }
  const Polygons polygons = polygons_of(columns, agent, frame_of(columns));
  if (polygons.flat->npolys == 0) return;
  state_->mesh.reset(detour_mesh(polygons, agent));
  constexpr int kMostNodes = 65535;
  state_->query.reset(dtAllocNavMeshQuery());
  require(dtStatusSucceed(state_->query->init(state_->mesh.get(), kMostNodes)), "Detour's search");
}

RecastMesh::RecastMesh(RecastMesh&&) noexcept = default;
RecastMesh& RecastMesh::operator=(RecastMesh&&) noexcept = default;
RecastMesh::~RecastMesh() = default;

bool RecastMesh::has_polygons() const { return state_->mesh != nullptr; }

std::size_t RecastMesh::polygon_count() const {
  return has_polygons() ? static_cast<std::size_t>(tile_of(std::as_const(*state_->mesh))->header->polyCount) : 0;
}

FlatTriangles RecastMesh::triangles() const {
  FlatTriangles result;
  if (!has_polygons()) return result;
  const dtMeshTile& tile = *tile_of(std::as_const(*state_->mesh));
  for (int i = 0; i < tile.header->polyCount; ++i) {
    const dtPoly& polygon = tile.polys[i];
    const dtPolyDetail& detail = tile.detailMeshes[i];
    for (unsigned t = 0; t < detail.triCount; ++t) {
      const unsigned char* corners = &tile.detailTris[(detail.triBase + t) * 4];
      std::array<std::uint32_t, 3> triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        const unsigned corner = corners[k];
        const float* at = corner < polygon.vertCount ? &tile.verts[polygon.verts[corner] * 3]
                                                     : &tile.detailVerts[(detail.vertBase + corner - polygon.vertCount) * 3];
        triangle[k] = static_cast<std::uint32_t>(result.vertices.size());
        result.vertices.emplace_back(from_detour(at).cast<float>());
      }
      const Vec3f a = result.vertices[triangle[1]] - result.vertices[triangle[0]];
      const Vec3f b = result.vertices[triangle[2]] - result.vertices[triangle[0]];
      if (a.cross(b).z() < 0) std::swap(triangle[1], triangle[2]);
      result.triangles.push_back(triangle);
    }
  }
  return result;
}

std::optional<std::vector<Vec3d>> RecastMesh::way(const Vec3d& from, const Vec3d& to) const {
  if (!has_polygons()) return std::nullopt;
  constexpr std::array<float, 3> kNear_m = {0.15F, 0.3F, 0.15F};
  constexpr int kMostPolygons = 16384;
  const dtNavMeshQuery& query = *state_->query;
  const dtQueryFilter filter;
  std::array<dtPolyRef, 2> ends{};
  std::array<std::array<float, 3>, 2> places = {to_detour(from), to_detour(to)};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto place = places[i];
    query.findNearestPoly(place.data(), kNear_m.data(), &filter, &ends[i], places[i].data());
    if (ends[i] == 0) return std::nullopt;
  }
  std::vector<dtPolyRef> polygons(kMostPolygons);
  int count = 0;
  query.findPath(ends[0], ends[1], places[0].data(), places[1].data(), &filter, polygons.data(), &count, kMostPolygons);
  if (count == 0 || polygons[static_cast<std::size_t>(count) - 1] != ends[1]) return std::nullopt;
  std::vector<float> corners(static_cast<std::size_t>(kMostPolygons) * 3);
  int found = 0;
  query.findStraightPath(places[0].data(), places[1].data(), polygons.data(), count, corners.data(), nullptr, nullptr, &found,
                         kMostPolygons);
  std::vector<Vec3d> way;
  for (int i = 0; i < found; ++i) way.push_back(from_detour(&corners[static_cast<std::size_t>(i) * 3]));
  if (way.empty()) return std::nullopt;
  return way;
}

std::optional<Vec3d> RecastMesh::nearest(const Vec3d& point, double far_m) const {
  if (!has_polygons()) return std::nullopt;
  const auto far = static_cast<float>(far_m);
  const std::array<float, 3> around = {far, 1, far};
  const std::array<float, 3> at = to_detour(point);
  const dtQueryFilter filter;
  dtPolyRef polygon = 0;
  std::array<float, 3> found{};
  state_->query->findNearestPoly(at.data(), around.data(), &filter, &polygon, found.data());
  if (polygon == 0) return std::nullopt;
  const Vec3d place = from_detour(found.data());
  if ((place - point).head<2>().norm() > far_m) return std::nullopt;
  return place;
}

std::string RecastMesh::bytes() const {
  constexpr std::int32_t kMagic = 'M' << 24 | 'S' << 16 | 'E' << 8 | 'T';
  constexpr std::int32_t kVersion = 1;
  std::string bytes;
  append_raw(bytes, kMagic);
  append_raw(bytes, kVersion);
  append_raw(bytes, std::int32_t{has_polygons() ? 1 : 0});
  dtNavMeshParams params{};
  if (has_polygons()) params = *state_->mesh->getParams();
  append_raw(bytes, params);
  if (!has_polygons()) return bytes;
  const dtMeshTile* tile = tile_of(std::as_const(*state_->mesh));
  append_raw(bytes, std::uint32_t{state_->mesh->getTileRef(tile)});
  append_raw(bytes, std::int32_t{tile->dataSize});
  bytes.append(reinterpret_cast<const char*>(tile->data), static_cast<std::size_t>(tile->dataSize));
  return bytes;
}

struct RecastCrowd::State {
  Owned<dtCrowd, dtFreeCrowd> crowd{dtAllocCrowd()};
  double radius_m = 0;
};

RecastCrowd::RecastCrowd(const RecastMesh& mesh, std::size_t most_walkers, double radius_m) : state_(std::make_unique<State>()) {
  PANOPTIC_ASSERT(mesh.has_polygons());
  state_->radius_m = radius_m;
  const bool done = state_->crowd->init(static_cast<int>(most_walkers), static_cast<float>(radius_m), mesh.state_->mesh.get());
  require(done, "Detour's crowd");
}

RecastCrowd::RecastCrowd(RecastCrowd&&) noexcept = default;
RecastCrowd& RecastCrowd::operator=(RecastCrowd&&) noexcept = default;
RecastCrowd::~RecastCrowd() = default;

std::optional<RecastCrowd::Walker> RecastCrowd::enter(const Vec3d& at, const WalkRules& rules) {
  dtCrowdAgentParams p{};
  p.radius = static_cast<float>(rules.radius_m), p.height = static_cast<float>(rules.height_m);
  p.maxAcceleration = static_cast<float>(rules.acceleration_m_s2), p.maxSpeed = static_cast<float>(rules.speed_m_s);
  p.collisionQueryRange = static_cast<float>(rules.looks_m);
  p.pathOptimizationRange = static_cast<float>(rules.optimizes_m);
  p.separationWeight = static_cast<float>(rules.separation);
  p.updateFlags = DT_CROWD_ANTICIPATE_TURNS | DT_CROWD_OBSTACLE_AVOIDANCE | DT_CROWD_SEPARATION;
  const int walker = state_->crowd->addAgent(to_detour(at).data(), &p);
  if (walker < 0) return std::nullopt;
  return walker;
}

void RecastCrowd::leave(Walker walker) { state_->crowd->removeAgent(walker); }

void RecastCrowd::go(Walker walker, const Vec3d& to) {
  const dtNavMeshQuery& query = *state_->crowd->getNavMeshQuery();
  dtPolyRef polygon = 0;
  std::array<float, 3> at{};
  query.findNearestPoly(to_detour(to).data(), state_->crowd->getQueryHalfExtents(), state_->crowd->getFilter(0), &polygon,
                        at.data());
  if (polygon != 0) state_->crowd->requestMoveTarget(walker, polygon, at.data());
}

void RecastCrowd::stop(Walker walker) { state_->crowd->resetMoveTarget(walker); }

Vec3d RecastCrowd::place(Walker walker) const { return from_detour(state_->crowd->getAgent(walker)->npos); }

bool RecastCrowd::is_clear(const Vec3d& at, std::optional<Walker> own) const {
  for (int i = 0; i < state_->crowd->getAgentCount(); ++i) {
    if (!state_->crowd->getAgent(i)->active || own == i) continue;
    if ((place(i) - at).head<2>().norm() <= 2 * state_->radius_m) return false;
  }
  return true;
}

void RecastCrowd::step(double seconds) { state_->crowd->update(static_cast<float>(seconds), nullptr); }

}  // namespace panoptic
