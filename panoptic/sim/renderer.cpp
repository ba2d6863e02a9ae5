// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/sim/figure_light.h"
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

// A tile of neighbouring pixels as rays.
RayPacket packet_at(const PixelRays& pixels, int u0, int v0) {
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
  return rays;
}

std::vector<std::uint32_t> present_triangles(const Surfaces& surfaces, const Presence& presence) {
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t t = 0; t < surfaces.triangles.size(); ++t) {
    if (presence[surfaces.origins[t].object] != 0) chosen.push_back(t);
  }
  return chosen;
}

}  // namespace

struct Renderer::State {
  // The surfaces that can be hit, and how they are lit, while certain objects are there.
  struct Furnished {
    Furnished(const Scene& scene, const Surfaces& surfaces, std::vector<std::uint32_t> chosen, const std::vector<Vec3f>& albedos)
        : tracer(surfaces, std::move(chosen)), lighting(scene, surfaces, tracer, albedos) {}

    RayTracer tracer;
    Lighting lighting;
  };

  State(const Scene& scene_in, const std::vector<Presence>& presences);

  const Furnished& world(std::size_t presence) const {
    PANOPTIC_ASSERT(presence < worlds.size());
    return *worlds[presence];
  }
  bool everything_stays() const { return worlds.size() == 1; }
  void render_tile(const Furnished& world, const PixelRays& pixels, const Eigen::Vector2i& at, Rendering& into) const;
  void paint(const Furnished& world, const FigureLayer& layer, const std::vector<Figure>& figures, const PixelRays& pixels,
             Rendering& into) const;
  Vec3f color_at(const Furnished& world, std::uint32_t triangle, const Eigen::Vector2f& uv, bool from_behind,
                 float footprint_m) const;

  const Scene& scene;
  Surfaces surfaces;
  std::vector<Texture> textures;
  std::vector<Paint> paints;     // per material
  std::vector<Vec3f> normals;    // per triangle, unit length
  std::vector<float> densities;  // per triangle, texels per metre
  std::vector<std::unique_ptr<Furnished>> worlds;
  Presence stays;  // per object: it is there at the end

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

Renderer::State::State(const Scene& scene_in, const std::vector<Presence>& presences)
    : scene(scene_in), surfaces(flatten(scene)), textures(textures_of(scene)), paints(paints_of(scene)), stays(presences.back()) {
  measure_triangles();
  const std::vector<Vec3f> albedo = albedos();
  for (const Presence& presence : presences) {
    PANOPTIC_ASSERT(presence.size() == scene.objects.size());
    worlds.push_back(std::make_unique<Furnished>(scene, surfaces, present_triangles(surfaces, presence), albedo));
  }
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

Vec3f Renderer::State::color_at(const Furnished& world, std::uint32_t triangle, const Eigen::Vector2f& uv, bool from_behind,
                                float footprint_m) const {
  const SurfaceOrigin& origin = surfaces.origins[triangle];
  const SceneModel& model = scene.models[scene.objects[origin.object].model];
  const Paint& paint = paints[model.material_of[origin.triangle]];
  Vec3f color = paint.color;
  if (paint.texture >= 0) {
    const auto& [a, b, c] = model.triangles[origin.triangle];
    const Eigen::Vector2f at = (1 - uv.x() - uv.y()) * model.uvs[a] + uv.x() * model.uvs[b] + uv.y() * model.uvs[c];
    color = color.cwiseProduct(textures[paint.texture].sample(at, footprint_m * densities[triangle]));
  }
  return color.cwiseProduct(world.lighting.at(triangle, uv.x(), uv.y(), from_behind ? LitSide::kBack : LitSide::kFront));
}

void Renderer::State::render_tile(const Furnished& world, const PixelRays& pixels, const Eigen::Vector2i& at,
                                  Rendering& into) const {
  const int u0 = at.x();
  const int v0 = at.y();
  const RayPacket rays = packet_at(pixels, u0, v0);
  PacketHits hits{};
  world.tracer.trace(rays, hits);
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
    into.color(u, v) = tone_mapped(color_at(world, triangle, {hits.u[i], hits.v[i]}, towards > 0, footprint_m));
    if (!into.fate.empty() && stays[surfaces.origins[triangle].object] == 0) into.fate(u, v) = Fate::kGoes;
  }
}

void Renderer::State::paint(const Furnished& world, const FigureLayer& layer, const std::vector<Figure>& figures,
                            const PixelRays& pixels, Rendering& into) const {
  std::vector<FigureLight> lights;
  for (const Figure& figure : figures) lights.emplace_back(figure, scene, world.tracer);
  for (int v = 0; v < into.depth.height(); ++v) {
    for (int u = 0; u < into.depth.width(); ++u) {
      const FigureLayer::Pixel& pixel = layer.pixels(u, v);
      if (pixel.depth_m <= 0 || (into.depth(u, v) > 0 && into.depth(u, v) <= pixel.depth_m)) continue;
      const Figure& figure = figures[pixel.figure];
      const Limb& limb = figure.limbs[pixel.limb];
      const Vec3f direction = pixels.direction(u, v);
      const Vec3f point = pixels.origin + pixel.depth_m * direction;
      const Vec3f normal = normal_at(limb, point);
      into.depth(u, v) = pixel.depth_m;
      into.class_id(u, v) = figure.class_id;
      into.instance(u, v) = figure.instance;
      into.cos_incidence(u, v) = std::min(1.0F, std::abs(normal.dot(direction)) / direction.norm());
      into.color(u, v) = tone_mapped(linear_from_srgb(limb.color).cwiseProduct(lights[pixel.figure].at(point, normal)));
      into.fate(u, v) = Fate::kMoves;
    }
  }
}

Renderer::Renderer(const Scene& scene) : Renderer(scene, {Presence(scene.objects.size(), 1)}) {}

Renderer::Renderer(const Scene& scene, const std::vector<Presence>& presences)
    : state_(std::make_unique<State>(scene, presences)) {}

Renderer::~Renderer() = default;

Rendering Renderer::render(const Camera& camera, const Pose& world_from_camera, const Moment& moment) const {
  const int width = camera.width;
  const int height = camera.height;
  Rendering rendering{Image<float>(width, height), Image<Rgb>(width, height), Image<ClassId>(width, height),
                      Image<std::uint16_t>(width, height), Image<float>(width, height)};
  if (!state_->everything_stays() || !moment.figures.empty()) rendering.fate = Image<Fate>(width, height);
  const State::Furnished& world = state_->world(moment.presence);
  const PixelRays pixels(camera, world_from_camera);
  const auto bands = static_cast<std::size_t>((height + kTileHeight - 1) / kTileHeight);
  parallel_for(bands, [&](std::size_t band) {
    const int v = static_cast<int>(band) * kTileHeight;
    for (int u = 0; u < width; u += kTileWidth) state_->render_tile(world, pixels, {u, v}, rendering);
  });
  if (!moment.figures.empty()) {
    state_->paint(world, draw_figures(moment.figures, camera, world_from_camera), moment.figures, pixels, rendering);
  }
  return rendering;
}

Glance Renderer::look(const Camera& camera, const Pose& world_from_camera, std::size_t presence) const {
  const PixelRays pixels(camera, world_from_camera);
  const State::Furnished& world = state_->world(presence);
  Glance glance{Image<float>(camera.width, camera.height), Image<std::uint32_t>(camera.width, camera.height)};
  PacketHits hits{};
  for (int v0 = 0; v0 < camera.height; v0 += kTileHeight) {
    for (int u0 = 0; u0 < camera.width; u0 += kTileWidth) {
      world.tracer.trace(packet_at(pixels, u0, v0), hits);
      for (int i = 0; i < kPacketRays; ++i) {
        const int u = u0 + i % kTileWidth;
        const int v = v0 + i / kTileWidth;
        if (u >= camera.width || v >= camera.height || hits.triangle[i] == kNoTriangle) continue;
        glance.depth(u, v) = hits.distance[i];
        glance.object(u, v) = state_->surfaces.origins[hits.triangle[i]].object;
      }
    }
  }
  return glance;
}

std::optional<SurfacePoint> Renderer::nearest(const Vec3d& world_point, double max_m) const {
  const auto found = state_->worlds.back()->tracer.nearest(world_point, max_m);
  if (!found) return std::nullopt;
  const SceneObject& object = state_->scene.objects[state_->surfaces.origins[found->triangle].object];
  return SurfacePoint{found->distance_m, object.class_id, object.instance};
}

}  // namespace panoptic
