// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Draws a scene as a perfect camera sees it: ray casting with Embree.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"
#include "panoptic/sim/figures.h"
#include "panoptic/sim/scene.h"

namespace panoptic {

// Whether the surface that a pixel shows is there at the end.
enum class Fate : std::uint8_t { kStays, kGoes, kMoves };

// Images of equal size; where no surface is hit (out of a window): depth 0, class kUnknown, instance 0.
struct Rendering {
  Image<float> depth;  // metres, planar z
  Image<Rgb> color;    // textured, lit by sun and lamps, with ambient occlusion; sRGB
  Image<ClassId> class_id;
  Image<std::uint16_t> instance;  // SceneObject::instance
  Image<float> cos_incidence;     // of the angle between the ray and the surface's normal, 0..1
  Image<Fate> fate = {};          // empty where everything stays
};

// The objects of a scene that are there while nothing is moved: one entry per object.
using Presence = std::vector<std::uint8_t>;

// Which of the renderer's presences holds, and who walks about.
struct Moment {
  std::size_t presence = 0;
  std::vector<Figure> figures = {};
};

// Geometry alone, which costs no light.
struct Glance {
  Image<float> depth;           // metres, planar z; 0 where no surface is hit
  Image<std::uint32_t> object;  // index into Scene::objects where one is
};

struct SurfacePoint {
  double distance_m = 0;
  ClassId class_id = ClassId::kUnknown;
  std::uint16_t instance = 0;
};

// Threads: const functions may run side by side; render() itself spreads over parallel_for's threads. The same picture at any
// thread count.
class Renderer {
 public:
  // Builds the acceleration structure and what lighting needs. The scene must outlive the renderer. Throws Error if Embree
  // refuses.
  explicit Renderer(const Scene& scene);
  // The same for a scene whose objects come and go: by default the first presence is drawn, and the last one stays.
  Renderer(const Scene& scene, const std::vector<Presence>& presences);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  Rendering render(const Camera& camera, const Pose& world_from_camera, const Moment& moment = {}) const;
  // Runs on the calling thread.
  Glance look(const Camera& camera, const Pose& world_from_camera, std::size_t presence = 0) const;

  // The nearest surface within max_m that is there at the end, for labelling the ground-truth mesh.
  std::optional<SurfacePoint> nearest(const Vec3d& world_point, double max_m) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
