// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/ray_tracer.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {
namespace {

static_assert(sizeof(Vec3f) == 3 * sizeof(float));

alignas(64) constexpr std::array<int, kPacketRays> kAllValid{-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};

void check(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  throw Error(fmt::format("Embree cannot build the scene (error {}); is there enough memory?", static_cast<int>(error)));
}

template <typename Item>
void fill_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, const std::vector<Item>& items) {
  auto* buffer = static_cast<Item*>(rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), items.size()));
  if (buffer != nullptr) std::copy(items.begin(), items.end(), buffer);
}

struct Query {
  const Surfaces& surfaces;
  const std::vector<std::uint32_t>& chosen;
  Vec3d p;
  double best_squared;
  std::uint32_t best = kNoTriangle;
};

bool visit_triangle(RTCPointQueryFunctionArguments* arguments) {
  Query& query = *static_cast<Query*>(arguments->userPtr);
  const std::uint32_t id = query.chosen.empty() ? arguments->primID : query.chosen[arguments->primID];
  std::array<Vec3d, 3> corners;
  for (int i = 0; i < 3; ++i) corners[i] = query.surfaces.positions[query.surfaces.triangles[id][i]].cast<double>();
  const Vec3d weights = nearest_weights(corners, query.p);
  const Vec3d point = weights.x() * corners[0] + weights.y() * corners[1] + weights.z() * corners[2];
  const double squared = (point - query.p).squaredNorm();
  if (squared > query.best_squared || (squared == query.best_squared && id > query.best)) return false;
  query.best_squared = squared;
  query.best = id;
  // A little larger than the distance, so that rounding hides no triangle at the same distance.
  arguments->query->radius = static_cast<float>(std::sqrt(squared) * (1 + 1e-6) + 1e-6);
  return true;
}

// One thread would suffice to build the tree, but Embree's "threads=1" holds back all of the program's TBB loops for as long as
// the device lives. Embree's own threads are not compiled for the thread sanitizer, which takes them for races; there
// parallel_for does without TBB.
#ifdef __SANITIZE_THREAD__
constexpr const char* kDeviceOptions = "threads=1";
#else
constexpr const char* kDeviceOptions = "";
#endif

}  // namespace

struct RayTracer::State {
  explicit State(const Surfaces& surfaces_in) : surfaces(surfaces_in), device(rtcNewDevice(kDeviceOptions)) {
    if (device == nullptr) throw Error("Embree does not start on this machine; it needs a CPU with SSE2");
    scene = rtcNewScene(device);
  }
  ~State() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  std::uint32_t triangle(std::uint32_t primitive) const { return chosen.empty() ? primitive : chosen[primitive]; }
  void build(const std::vector<std::array<std::uint32_t, 3>>& triangles);

  const Surfaces& surfaces;
  std::vector<std::uint32_t> chosen;  // by primitive; empty: all triangles
  RTCDevice device;
  RTCScene scene = nullptr;
};

void RayTracer::State::build(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
  if (!triangles.empty()) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    fill_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, surfaces.positions);
    fill_buffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    check(device);
  }
  rtcCommitScene(scene);
  check(device);
}

RayTracer::RayTracer(const Surfaces& surfaces) : state_(std::make_unique<State>(surfaces)) { state_->build(surfaces.triangles); }

RayTracer::RayTracer(const Surfaces& surfaces, std::vector<std::uint32_t> chosen) : state_(std::make_unique<State>(surfaces)) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (const std::uint32_t triangle : chosen) triangles.push_back(surfaces.triangles[triangle]);
  state_->chosen = std::move(chosen);
  state_->build(triangles);
}

RayTracer::~RayTracer() = default;

void RayTracer::trace(const RayPacket& rays, PacketHits& hits) const {
  RTCIntersectContext context{};
  rtcInitIntersectContext(&context);
  context.flags = rays.coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  RTCRayHit16 packet;  // NOLINT(cppcoreguidelines-pro-type-member-init): hot; what is read is set
  for (int i = 0; i < kPacketRays; ++i) {
    packet.ray.org_x[i] = rays.origin.x();
    packet.ray.org_y[i] = rays.origin.y();
    packet.ray.org_z[i] = rays.origin.z();
    packet.ray.dir_x[i] = rays.x[i];
    packet.ray.dir_y[i] = rays.y[i];
    packet.ray.dir_z[i] = rays.z[i];
    packet.ray.tnear[i] = 0;
    packet.ray.tfar[i] = rays.max_distance;
    packet.ray.time[i] = 0;
    packet.ray.mask[i] = ~0U;
    packet.ray.id[i] = 0;
    packet.ray.flags[i] = 0;
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  rtcIntersect16(kAllValid.data(), state_->scene, &context, &packet);
  for (int i = 0; i < kPacketRays; ++i) {
    const bool hit = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    hits.triangle[i] = hit ? state_->triangle(packet.hit.primID[i]) : kNoTriangle;
    hits.distance[i] = packet.ray.tfar[i];
    hits.u[i] = packet.hit.u[i];
    hits.v[i] = packet.hit.v[i];
  }
}

RayHit RayTracer::trace(const Vec3f& origin, const Vec3f& direction, float max_distance) const {
  RTCIntersectContext context{};
  rtcInitIntersectContext(&context);
  RTCRayHit ray{};
  ray.ray.org_x = origin.x();
  ray.ray.org_y = origin.y();
  ray.ray.org_z = origin.z();
  ray.ray.dir_x = direction.x();
  ray.ray.dir_y = direction.y();
  ray.ray.dir_z = direction.z();
  ray.ray.tfar = max_distance;
  ray.ray.mask = ~0U;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(state_->scene, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {max_distance, kNoTriangle};
  return {ray.ray.tfar, state_->triangle(ray.hit.primID)};
}

std::optional<NearestTriangle> RayTracer::nearest(const Vec3d& p, double max_m) const {
  RTCPointQuery search{};
  search.x = static_cast<float>(p.x());
  search.y = static_cast<float>(p.y());
  search.z = static_cast<float>(p.z());
  // The single-precision centre is a little off: by less than this for a home.
  search.radius = static_cast<float>(max_m * (1 + 1e-6) + 1e-5);
  RTCPointQueryContext context{};
  rtcInitPointQueryContext(&context);
  Query query{state_->surfaces, state_->chosen, p, max_m * max_m};
  rtcPointQuery(state_->scene, &search, &context, visit_triangle, &query);
  if (query.best == kNoTriangle) return std::nullopt;
  return NearestTriangle{std::sqrt(query.best_squared), query.best};
}

}  // namespace panoptic
