// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/lighting.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr float kLatticeStep_m = 0.05F;  // sun patches and the shadows below furniture are that sharp
constexpr float kLift_m = 0.002F;        // rays start above their surface
constexpr float kScatterReach_m = 1.5F;  // beyond it nothing darkens a place
constexpr float kScattered = 0.5F;       // light from everywhere in a room, with nothing near
constexpr float kBounce = 0.65F;         // of that light comes back from what is near, times its colour
constexpr float kTouching_m = 0.025F;    // what is closer touches
constexpr float kLampSize_m = 0.25F;     // what is closer to a lamp than this is the lamp
constexpr float kLampRadius_m = 0.12F;   // of the part that shines: shadows are that soft
constexpr float kFaintest = 0.004F;      // light of a lamp that is not worth a ray
constexpr float kOutside_m = 100.0F;
const Vec3f kSunlight(2.6F, 2.4F, 2.0F);
constexpr std::size_t kMostPlaces = std::size_t{1} << 31;

// Light as 3 x 16 bits in steps of 1/2048, a bit that says it is known, and one that says the place is hidden.
constexpr std::uint64_t kKnown = std::uint64_t{1} << 63U;
constexpr std::uint64_t kHidden = std::uint64_t{1} << 62U;
std::uint64_t packed(const Vec3f& light, bool is_hidden) {
  const auto bits = [](float l) { return static_cast<std::uint64_t>(std::clamp(l * 2048 + 0.5F, 0.0F, 65535.0F)); };
  return kKnown | (is_hidden ? kHidden : 0) | bits(light.x()) | bits(light.y()) << 16U | bits(light.z()) << 32U;
}

Vec3f facing(const Vec3f& normal, const Vec3f& towards) { return normal.dot(towards) < 0 ? Vec3f(-normal) : normal; }

Vec3f any_across(const Vec3f& normal) {
  return unit(normal.cross(std::abs(normal.z()) < 0.9F ? Vec3f(Vec3f::UnitZ()) : Vec3f(Vec3f::UnitX())));
}

// Directions above the plane z = 0, dense where the cosine is large: points of a sunflower in the unit disc, lifted. The
// same for every place, so that what error they make is smooth.
constexpr int kScatterRays = 32;
static_assert(kScatterRays % kPacketRays == 0);
const std::array<Vec3f, kScatterRays>& scatter_directions() {
  static const std::array<Vec3f, kScatterRays> kDirections = [] {
    std::array<Vec3f, kScatterRays> directions;
    for (int i = 0; i < kScatterRays; ++i) {
      const double squared_radius = (i + 0.5) / kScatterRays;
      const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
      const double radius = std::sqrt(squared_radius);
      directions[i] = Vec3d(radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1 - squared_radius)).cast<float>();
    }
    return directions;
  }();
  return kDirections;
}

// The weights of a triangle's corners at a point of its plane z = 0, inside or not.
Vec3d plane_weights(const std::array<Vec3d, 3>& corners, const Vec3d& p) {
  Eigen::Matrix2d edges;
  edges << (corners[1] - corners[0]).head<2>(), (corners[2] - corners[0]).head<2>();
  const Eigen::Vector2d uv = edges.inverse() * (p - corners[0]).head<2>();
  return {1 - uv.x() - uv.y(), uv.x(), uv.y()};
}

}  // namespace

Lighting::Light Lighting::unpacked(std::uint64_t bits) {
  const auto light = [&](unsigned shift) { return static_cast<float>((bits >> shift) & 0xffffU); };
  return {Vec3f(light(0), light(16), light(32)) * (1.0F / 2048), (bits & kHidden) != 0 ? 0.0F : 1.0F};
}

Vec3f Lighting::mean(std::initializer_list<Share> shares) {
  constexpr float kLeast = 1e-3F;  // where all is hidden, what is there counts after all
  Vec3f sum = Vec3f::Zero();
  float weights = 0;
  for (const Share& share : shares) {
    const float weight = share.share * (share.light.weight + kLeast);
    sum += weight * share.light.rgb;
    weights += weight;
  }
  return weights > 0 ? Vec3f(sum / weights) : Vec3f(Vec3f::Zero());
}

Lighting::Lighting(const Scene& scene, const Surfaces& surfaces, const RayTracer& tracer, std::vector<Vec3f> albedos)
    : scene_(scene), surfaces_(surfaces), tracer_(tracer), albedos_(std::move(albedos)) {
  for (const SceneModel& model : scene.models) models_.push_back(places_of(model));
  std::uint32_t triangles = 0;
  const ClassId window = load_label_set("scannet20").find("window")->id;
  for (const SceneObject& object : scene.objects) {
    lets_sun_in_.push_back(object.class_id == window);
    first_place_.push_back(static_cast<std::uint32_t>(places_));
    places_ += models_[object.model].owners.size();
    first_triangle_.push_back(triangles);
    triangles += static_cast<std::uint32_t>(scene.models[object.model].triangles.size());
  }
  lattice_of_.assign(surfaces.triangles.size(), -1);
  for (std::uint32_t t = 0; t < surfaces.triangles.size() && places_ < kMostPlaces; ++t) add_lattice(t);
  if (places_ >= kMostPlaces) throw Error(fmt::format("the scene is too large to be lit: more than {} places", kMostPlaces));
  light_ = std::make_unique<std::atomic<std::uint64_t>[]>(2 * places_);
}

void Lighting::add_lattice(std::uint32_t triangle) {
  constexpr float kRightAngle = 0.01F;  // cosine
  std::array<Vec3f, 3> corners;
  for (int i = 0; i < 3; ++i) corners[i] = surfaces_.positions[surfaces_.triangles[triangle][i]];
  const auto edge = [&](int i) -> Vec3f { return corners[(i + 1) % 3] - corners[i]; };
  int first = 0;
  for (int i = 1; i < 3; ++i) {
    if (edge(i).norm() > edge(first).norm()) first = i;
  }
  if (!(edge(first).norm() > 2 * kLatticeStep_m)) return;
  Lattice lattice;
  lattice.is_clamped = true;
  // The right angle, if there is one, is opposite to the longest edge.
  const int apex = (first + 2) % 3;
  if (std::abs(unit(edge(apex)).dot(unit(edge((apex + 2) % 3)))) < kRightAngle) {
    first = apex;
    lattice.is_clamped = false;
  }
  const float width_m = edge(first).norm();
  const Vec3f x = edge(first) / width_m;
  const Vec3f to_third = corners[(first + 2) % 3] - corners[first];
  const Vec3f y = unit(to_third - to_third.dot(x) * x);
  const float height_m = to_third.dot(y);
  const auto steps = [](float length_m) { return std::max(1.0F, std::ceil(std::min(length_m, 1e6F) / kLatticeStep_m)); };
  const Eigen::Vector2f per_m(steps(width_m) / width_m, height_m > 0 ? steps(height_m) / height_m : 0);
  const auto coordinates = [&](const Vec3f& v) { return Eigen::Vector2f(v.dot(x) * per_m.x(), v.dot(y) * per_m.y()); };
  lattice.first = static_cast<std::uint32_t>(places_);
  lattice.columns = static_cast<std::uint32_t>(steps(width_m)) + 1;
  lattice.rows = static_cast<std::uint32_t>(steps(height_m)) + 1;
  lattice.origin = coordinates(corners[0] - corners[first]);
  lattice.along_u = coordinates(corners[1] - corners[0]);
  lattice.along_v = coordinates(corners[2] - corners[0]);
  lattice_of_[triangle] = static_cast<std::int32_t>(lattices_.size());
  lattices_.push_back(lattice);
  places_ += std::size_t{lattice.columns} * lattice.rows;
}

Vec3f Lighting::at(std::uint32_t triangle, float u, float v, LitSide side) const {
  const std::int32_t lattice = lattice_of_[triangle];
  return lattice < 0 ? at_corners(triangle, u, v, side) : at_lattice(lattices_[lattice], triangle, {u, v}, side);
}

template <typename MakePlace>
Lighting::Light Lighting::remembered(std::uint32_t place, LitSide side, const MakePlace& make_place) const {
  std::atomic<std::uint64_t>& light = light_[2 * std::size_t{place} + (side == LitSide::kBack ? 1 : 0)];
  std::uint64_t bits = light.load(std::memory_order_relaxed);
  if ((bits & kKnown) == 0) {
    const Light arrived = arriving(make_place());
    bits = packed(arrived.rgb, arrived.weight <= 0);
    light.store(bits, std::memory_order_relaxed);
  }
  return unpacked(bits);
}

Vec3f Lighting::at_corners(std::uint32_t triangle, float u, float v, LitSide side) const {
  return mean({{at_corner(triangle, 0, side), 1 - u - v}, {at_corner(triangle, 1, side), u}, {at_corner(triangle, 2, side), v}});
}

Lighting::Light Lighting::at_corner(std::uint32_t triangle, int corner, LitSide side) const {
  const SurfaceOrigin& origin = surfaces_.origins[triangle];
  const ModelPlaces& model = models_[scene_.objects[origin.object].model];
  const std::uint32_t place = model.corner_at[origin.triangle][corner];
  // Triangles share the place, and it may not matter which of them is seen first.
  const auto& [owner, owner_corner] = model.owners[place];
  return remembered(first_place_[origin.object] + place, side, [&, owner = owner, corner_of_owner = owner_corner] {
    return place_at(first_triangle_[origin.object] + owner, Vec3d::Unit(corner_of_owner), side);
  });
}

Vec3f Lighting::at_lattice(const Lattice& lattice, std::uint32_t triangle, const Eigen::Vector2f& uv, LitSide side) const {
  const Eigen::Vector2f at = lattice.origin + uv.x() * lattice.along_u + uv.y() * lattice.along_v;
  const float x = std::clamp(at.x(), 0.0F, static_cast<float>(lattice.columns - 1));
  const float y = std::clamp(at.y(), 0.0F, static_cast<float>(lattice.rows - 1));
  const std::uint32_t column = std::min(static_cast<std::uint32_t>(x), lattice.columns - 2);
  const std::uint32_t row = std::min(static_cast<std::uint32_t>(y), lattice.rows - 2);
  const float right = x - static_cast<float>(column);
  const float up = y - static_cast<float>(row);
  const auto node = [&](std::uint32_t i, std::uint32_t j) { return at_node(lattice, triangle, {column + i, row + j}, side); };
  return mean({{node(0, 0), (1 - right) * (1 - up)},
               {node(1, 0), right * (1 - up)},
               {node(0, 1), (1 - right) * up},
               {node(1, 1), right * up}});
}

Lighting::Light Lighting::at_node(const Lattice& lattice, std::uint32_t triangle, const std::array<std::uint32_t, 2>& node,
                                  LitSide side) const {
  const auto make_place = [&] {
    const Vec3d at(node[0], node[1], 0);
    const auto corner = [](const Eigen::Vector2f& p) { return Vec3d(p.x(), p.y(), 0); };
    const std::array<Vec3d, 3> corners{corner(lattice.origin), corner(lattice.origin + lattice.along_u),
                                       corner(lattice.origin + lattice.along_v)};
    return place_at(triangle, lattice.is_clamped ? nearest_weights(corners, at) : plane_weights(corners, at), side);
  };
  return remembered(lattice.first + node[1] * lattice.columns + node[0], side, make_place);
}

Lighting::Place Lighting::place_at(std::uint32_t triangle, const Vec3d& weights, LitSide side) const {
  constexpr float kInwards_m = 0.004F;  // away from the edges, where neighbouring surfaces begin
  const SurfaceOrigin& origin = surfaces_.origins[triangle];
  const SceneObject& object = scene_.objects[origin.object];
  const auto& normals = models_[object.model].normals[origin.triangle];
  std::array<Vec3f, 3> corners;
  for (int i = 0; i < 3; ++i) corners[i] = surfaces_.positions[surfaces_.triangles[triangle][i]];
  const Vec3f at = weights.cast<float>();
  Vec3f smooth = Vec3f::Zero();
  Place place{Vec3f::Zero(), Vec3f::Zero(), Vec3f::Zero()};
  for (int i = 0; i < 3; ++i) {
    place.point += at[i] * corners[i];
    smooth += at[i] * normals[i];
  }
  const Vec3f inwards = (corners[0] + corners[1] + corners[2]) / 3 - place.point;
  place.point += std::min(kInwards_m, 0.1F * inwards.norm()) * unit(inwards);
  const float sign = side == LitSide::kBack ? -1.0F : 1.0F;
  place.surface = sign * unit((corners[1] - corners[0]).cross(corners[2] - corners[0]));
  place.normal = facing(unit(world_from_object_normal(object) * smooth), place.surface);
  return place;
}

Lighting::Light Lighting::arriving(const Place& place) const {
  const Vec3f origin = place.point + kLift_m * place.surface;
  Light light = scattered(place, origin);
  if (light.weight <= 0) return light;
  const Vec3f sun = unit(scene_.towards_sun);
  const float sun_cosine = sun.dot(place.normal);
  if (sun_cosine > 0 && sun.dot(place.surface) > 0 && sun_reaches(origin, sun)) light.rgb += sun_cosine * kSunlight;
  for (const Lamp& lamp : scene_.lamps) {
    const Vec3f to_lamp = lamp.position - origin;
    const float distance = to_lamp.norm();
    const Vec3f direction = unit(to_lamp);
    const float strength = std::max(0.0F, direction.dot(place.normal)) / std::max(distance * distance, kLampSize_m);
    if (strength * lamp.radiance.maxCoeff() < kFaintest || direction.dot(place.surface) <= 0) continue;
    light.rgb += strength * share_of(lamp, origin) * lamp.radiance;
  }
  return light;
}

Lighting::Light Lighting::scattered(const Place& place, const Vec3f& origin) const {
  const Vec3f across = any_across(place.normal);
  const Vec3f other = place.normal.cross(across);
  Vec3f sum = Vec3f::Zero();
  int touching = 0;
  RayPacket rays;
  rays.origin = origin;
  rays.max_distance = kScatterReach_m;
  PacketHits hits{};
  for (int begin = 0; begin < kScatterRays; begin += kPacketRays) {
    for (int i = 0; i < kPacketRays; ++i) {
      const Vec3f& local = scatter_directions()[begin + i];
      Vec3f direction = local.x() * across + local.y() * other + local.z() * place.normal;
      const float height = direction.dot(place.surface);
      if (height < 0) direction -= 2 * height * place.surface;  // a smoothed normal leans: stay above the surface
      rays.x[i] = direction.x();
      rays.y[i] = direction.y();
      rays.z[i] = direction.z();
    }
    tracer_.trace(rays, hits);
    for (int i = 0; i < kPacketRays; ++i) {
      if (hits.triangle[i] == kNoTriangle) {
        sum += Vec3f::Ones();
        continue;
      }
      if (hits.distance[i] < kTouching_m) ++touching;
      const SurfaceOrigin& hit = surfaces_.origins[hits.triangle[i]];
      const SceneModel& model = scene_.models[scene_.objects[hit.object].model];
      const float nearness = 1 - hits.distance[i] / kScatterReach_m;
      sum += Vec3f::Constant(1 - nearness) + nearness * kBounce * albedos_[model.material_of[hit.triangle]];
    }
  }
  const bool is_hidden = touching > kScatterRays * 3 / 4;
  return {kScattered / kScatterRays * sum, is_hidden ? 0.0F : 1.0F};
}

// How much of a lamp is to be seen: rays to points of the disc that it shows.
float Lighting::share_of(const Lamp& lamp, const Vec3f& origin) const {
  constexpr int kRays = 4;
  const Vec3f to_lamp = lamp.position - origin;
  const Vec3f across = kLampRadius_m * any_across(unit(to_lamp));
  const Vec3f other = kLampRadius_m * unit(to_lamp.cross(across));
  const std::array<Vec3f, kRays> points{to_lamp + across, to_lamp - across, to_lamp + other, to_lamp - other};
  int arriving = 0;
  for (const Vec3f& point : points) {
    const float reach = point.norm() - kLampSize_m;
    if (reach <= 0 || tracer_.trace(origin, unit(point), reach).triangle == kNoTriangle) ++arriving;
  }
  return static_cast<float>(arriving) / kRays;
}

// Windows have panes of glass, modelled as surfaces like all others, often several one behind the other.
bool Lighting::sun_reaches(Vec3f origin, const Vec3f& direction) const {
  constexpr int kMostPanes = 16;
  constexpr float kPastThePane_m = 1e-3F;
  for (int i = 0; i < kMostPanes; ++i) {
    const RayHit hit = tracer_.trace(origin, direction, kOutside_m);
    if (hit.triangle == kNoTriangle) return true;
    if (!lets_sun_in_[surfaces_.origins[hit.triangle].object]) return false;
    origin += (hit.distance + kPastThePane_m) * direction;
  }
  return false;
}

}  // namespace panoptic
