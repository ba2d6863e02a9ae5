// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "panoptic/parallel.h"
#include "panoptic/sim/lighting.h"
#include "panoptic/sim/ray_tracer.h"
#include "panoptic/sim/surfaces.h"
#include "panoptic/sim/textures.h"

namespace panoptic {
namespace {

// A packet sees a tile of neighbouring pixels.
constexpr int kTileWidth = 4;
constexpr int kTileHeight = kPacketRays / kTileWidth;

// Data that colour needs of a triangle beyond its material, or of a material.
struct Paint {
  Vec3f color = Vec3f::Ones();  // linear
  std::int32_t texture = -1;
};

// Turns pixels into rays in the world whose length is one metre of planar depth.
struct PixelRays {
  PixelRays(const Camera& camera, const Pose& world_from_camera)
      : origin(world_from_camera.translation().cast<float>()),
        per_u((world_from_camera.linear().col(0) / camera.fx).cast<float>()),
        per_v((world_from_camera.linear().col(1) / camera.fy).cast<float>()),
        first((world_from_camera.linear() * back_project(camera, 0, 0, 1)).cast<float>()) {}

  Vec3f direction(int u, int v) const { return first + static_cast<float>(u) * per_u + static_cast<float>(v) * per_v; }

  Vec3f origin;
  Vec3f per_u;
  Vec3f per_v;
  Vec3f first;
};

// Brighter towards the horizon; below it a street in haze.
Vec3f sky(const Vec3f& direction) {
  const float up = direction.z() / direction.norm();
  const float blue = std::clamp(up * 2, 0.0F, 1.0F);
  if (up < 0) return Vec3f(0.75F, 0.76F, 0.74F) + std::min(1.0F, -up * 6) * Vec3f(-0.3F, -0.28F, -0.34F);
  return Vec3f(2.2F, 2.4F, 2.7F) + blue * Vec3f(-1.3F, -1.0F, -0.4F);
}

// Texels of the original texture per metre on the surface; 0 for a triangle without area.
float texel_density(const SceneModel& model, std::size_t triangle, const Texture& texture, float world_area2) {
  const auto& [a, b, c] = model.triangles[triangle];
  const Eigen::Vector2f edge_b = model.uvs[b] - model.uvs[a];
  const Eigen::Vector2f edge_c = model.uvs[c] - model.uvs[a];
  const float area2 =
      std::abs(edge_b.x() * edge_c.y() - edge_b.y() * edge_c.x()) * static_cast<float>(texture.width() * texture.height());
  return world_area2 > 0 ? std::sqrt(area2 / world_area2) : 0;
}

}  // namespace

struct Renderer::State {
  explicit State(const Scene& scene_in);

  void render_tile(const PixelRays& pixels, int u0, int v0, Rendering& into) const;
  Vec3f color_at(std::uint32_t triangle, const Eigen::Vector2f& uv, bool from_behind, float footprint_m) const;

  const Scene& scene;
  Surfaces surfaces;
  std::vector<Texture> textures;
  std::vector<Paint> paints;  // per material
  RayTracer tracer;
  std::vector<Vec3f> normals;    // per triangle, unit length
  std::vector<float> densities;  // per triangle, texels per metre
  Lighting lighting;

 private:
  static std::vector<Texture> textures_of(const Scene& scene);
  static std::vector<Paint> paints_of(const Scene& scene);
  std::vector<Vec3f> albedos() const;
  void measure_triangles();
};

std::vector<Texture> Renderer::State::textures_of(const Scene& scene) {
  std::vector<Texture> textures;
  for (const Image<Rgb>& image : scene.textures) textures.emplace_back(image.empty() ? Image<Rgb>(1, 1) : image);
  return textures;
}

std::vector<Paint> Renderer::State::paints_of(const Scene& scene) {
  std::vector<Paint> paints;
  for (const Material& material : scene.materials) paints.push_back({linear_from_srgb(material.color), material.texture});
  return paints;
}

std::vector<Vec3f> Renderer::State::albedos() const {
  std::vector<Vec3f> means;
  for (const Paint& paint : paints) {
    means.push_back(paint.texture < 0 ? paint.color : Vec3f(paint.color.cwiseProduct(textures[paint.texture].mean())));
  }
  return means;
}

Renderer::State::State(const Scene& scene_in)
    : scene(scene_in),
      surfaces(flatten(scene)),
      textures(textures_of(scene)),
      paints(paints_of(scene)),
      tracer(surfaces),
      lighting(scene, surfaces, tracer, albedos()) {
  measure_triangles();
}

void Renderer::State::measure_triangles() {
  for (std::size_t t = 0; t < surfaces.triangles.size(); ++t) {
    const auto& [a, b, c] = surfaces.triangles[t];
    const Vec3f normal = (surfaces.positions[b] - surfaces.positions[a]).cross(surfaces.positions[c] - surfaces.positions[a]);
    const float area2 = normal.norm();
    normals.emplace_back(area2 > 0 ? Vec3f(normal / area2) : Vec3f(Vec3f::Zero()));
    const SurfaceOrigin& origin = surfaces.origins[t];
    const SceneModel& model = scene.models[scene.objects[origin.object].model];
    const std::int32_t texture = paints[model.material_of[origin.triangle]].texture;
    densities.push_back(texture < 0 ? 0 : texel_density(model, origin.triangle, textures[texture], area2));
  }
}

Vec3f Renderer::State::color_at(std::uint32_t triangle, const Eigen::Vector2f& uv, bool from_behind, float footprint_m) const {
  const SurfaceOrigin& origin = surfaces.origins[triangle];
  const SceneModel& model = scene.models[scene.objects[origin.object].model];
  const Paint& paint = paints[model.material_of[origin.triangle]];
  Vec3f color = paint.color;
  if (paint.texture >= 0) {
    const auto& [a, b, c] = model.triangles[origin.triangle];
    const Eigen::Vector2f at = (1 - uv.x() - uv.y()) * model.uvs[a] + uv.x() * model.uvs[b] + uv.y() * model.uvs[c];
    color = color.cwiseProduct(textures[paint.texture].sample(at, footprint_m * densities[triangle]));
  }
  return color.cwiseProduct(lighting.at(triangle, uv.x(), uv.y(), from_behind ? LitSide::kBack : LitSide::kFront));
}

void Renderer::State::render_tile(const PixelRays& pixels, int u0, int v0, Rendering& into) const {
  RayPacket rays;
  rays.origin = pixels.origin;
  rays.max_distance = std::numeric_limits<float>::infinity();
  rays.coherent = true;
  for (int i = 0; i < kPacketRays; ++i) {
    const Vec3f direction = pixels.direction(u0 + i % kTileWidth, v0 + i / kTileWidth);
    rays.x[i] = direction.x();
    rays.y[i] = direction.y();
    rays.z[i] = direction.z();
  }
  PacketHits hits{};
  tracer.trace(rays, hits);
  for (int i = 0; i < kPacketRays; ++i) {
    const int u = u0 + i % kTileWidth;
    const int v = v0 + i / kTileWidth;
    if (u >= into.depth.width() || v >= into.depth.height()) continue;  // the tile hangs over the image's edge
    const Vec3f direction(rays.x[i], rays.y[i], rays.z[i]);
    const std::uint32_t triangle = hits.triangle[i];
    if (triangle == kNoTriangle) {
      into.color(u, v) = tone_mapped(sky(direction));
      continue;
    }
    const float towards = direction.dot(normals[triangle]);
    const float cosine = std::min(1.0F, std::abs(towards) / direction.norm());
    const SceneObject& object = scene.objects[surfaces.origins[triangle].object];
    // Oblique surfaces are blurred by half of what would blur them the long way: between the two ways.
    const float footprint_m = hits.distance[i] * pixels.per_u.norm() / std::sqrt(std::max(cosine, 0.05F));
    into.depth(u, v) = hits.distance[i];
    into.class_id(u, v) = object.class_id;
    into.instance(u, v) = object.instance;
    into.cos_incidence(u, v) = cosine;
    into.color(u, v) = tone_mapped(color_at(triangle, {hits.u[i], hits.v[i]}, towards > 0, footprint_m));
  }
}

Renderer::Renderer(const Scene& scene) : state_(std::make_unique<State>(scene)) {}

Renderer::~Renderer() = default;

Rendering Renderer::render(const Camera& camera, const Pose& world_from_camera) const {
  const int width = camera.width;
  const int height = camera.height;
  Rendering rendering{Image<float>(width, height), Image<Rgb>(width, height), Image<ClassId>(width, height),
                      Image<std::uint16_t>(width, height), Image<float>(width, height)};
  const PixelRays pixels(camera, world_from_camera);
  const auto bands = static_cast<std::size_t>((height + kTileHeight - 1) / kTileHeight);
  parallel_for(bands, [&](std::size_t band) {
    for (int u = 0; u < width; u += kTileWidth) state_->render_tile(pixels, u, static_cast<int>(band) * kTileHeight, rendering);
  });
  return rendering;
}

std::optional<SurfacePoint> Renderer::nearest(const Vec3d& world_point, double max_m) const {
  const auto found = state_->tracer.nearest(world_point, max_m);
  if (!found) return std::nullopt;
  const SceneObject& object = state_->scene.objects[state_->surfaces.origins[found->triangle].object];
  return SurfacePoint{found->distance_m, object.class_id, object.instance};
}

}  // namespace panoptic
