// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/simulation.h"

#include <fmt/format.h>

#include <algorithm>

#include "panoptic/error.h"
#include "panoptic/sim/catalogue.h"

namespace panoptic {
namespace {

constexpr Camera kCamera{640, 480, 577.87, 577.87, 319.5, 239.5};
constexpr int kMostFrames = 1'000'000;

const SimulationOptions& checked(const SimulationOptions& options) {
  if (options.frames < 0 || options.frames > kMostFrames) {
    throw Error(
        fmt::format("frames = {} is out of range; it may be 0 (as many as the way takes) to {}", options.frames, kMostFrames));
  }
  if (options.jumps != 0 && dynamics_of(options.dynamics) != Dynamics::kStatic) {
    throw Error(fmt::format("jumps = {} do not go with dynamics '{}', which follow where the camera is; choose one of them",
                            options.jumps, options.dynamics));
  }
  return options;
}

// How the image moved since the camera stood at `before`: what is seen in the middle, in pixels.
Eigen::Vector2f motion_px(const Pose& before, const Pose& now, const Image<float>& depth) {
  constexpr double kTypicalDepth_m = 2;
  const int u = kCamera.width / 2;
  const int v = kCamera.height / 2;
  const double z = depth(u, v) > 0 ? depth(u, v) : kTypicalDepth_m;
  const Vec3d seen_before = before.inverse() * now * back_project(kCamera, u, v, z);
  if (seen_before.z() <= 0) return Eigen::Vector2f::Zero();
  const Eigen::Vector2d at_before(kCamera.fx * seen_before.x() / seen_before.z() + kCamera.cx,
                                  kCamera.fy * seen_before.y() / seen_before.z() + kCamera.cy);
  return (Eigen::Vector2d(u, v) - at_before).cast<float>();
}

}  // namespace

struct Simulation::State {
  explicit State(const SimulationOptions& options_in)
      : options(checked(options_in)),
        noise(sensor_noise_preset(options.noise)),
        world(make_moving_home({{options.seed, options.rooms}, options.frames, dynamics_of(options.dynamics)}, Catalogue(),
                               kCamera)),
        jumping(with_jumps(world.path, options.jumps, options.seed)),
        tracked_path(with_drift(noise, options.seed, jumping.poses)),
        labels(labels_of(world)),
        renderer(world.home.scene, world.presences) {}

  SimulationOptions options;
  SensorNoise noise;
  MovingHome world;
  JumpingPath jumping;
  std::vector<Pose> tracked_path;
  LabelSet labels;
  Renderer renderer;
};

Simulation::Simulation(const SimulationOptions& options) : state_(std::make_unique<State>(options)) {}

Simulation::~Simulation() = default;

std::string Simulation::description() const {
  std::uint16_t things = 0;
  for (const SceneObject& object : state_->world.home.scene.objects) things = std::max(things, object.instance);
  const std::size_t rooms = state_->world.home.rooms.size();
  std::string text =
      fmt::format("simulated home {}: {} room{}, {} things, {} frames, depth and colour {}x{}, noise '{}'", state_->options.seed,
                  rooms, rooms == 1 ? "" : "s", things, size(), kCamera.width, kCamera.height, state_->options.noise);
  if (!jumps().jumps.empty()) text += fmt::format(", carried off {} times", jumps().jumps.size());
  if (moves()) {
    text += fmt::format(", dynamics '{}': {} movers, {} changes", state_->options.dynamics, state_->world.movers.size(),
                        state_->world.changes.size());
  }
  return text;
}

std::size_t Simulation::size() const { return state_->world.path.size(); }
const std::vector<Pose>& Simulation::true_path() const { return state_->jumping.poses; }
const JumpingPath& Simulation::jumps() const { return state_->jumping; }

ReadResult Simulation::read(std::size_t position) const {
  Frame frame = simulate(position).frame;
  if (const Outcome outcome = check(frame); !outcome.used) return {std::nullopt, {frame.index, outcome.reason}};
  return {std::move(frame), {}};
}

SimulatedFrame Simulation::simulate(std::size_t position) const {
  PANOPTIC_ASSERT(position < size());
  SimulatedFrame result;
  const std::vector<Pose>& path = true_path();
  result.true_world_from_camera = path[position];
  result.rendering = state_->renderer.render(kCamera, result.true_world_from_camera,
                                             {state_->world.presence_at(position), state_->world.figures_at(position)});

  Rendering sensed = result.rendering;
  // Nothing was exposed while the camera was carried.
  const bool is_put_down =
      std::any_of(jumps().jumps.begin(), jumps().jumps.end(), [&](const Jump& jump) { return jump.frame == position; });
  const Pose& before = path[position == 0 || is_put_down ? position : position - 1];
  add_sensor_noise(state_->noise, state_->options.seed, static_cast<std::int64_t>(position), sensed,
                   motion_px(before, result.true_world_from_camera, result.rendering.depth));
  Frame& frame = result.frame;
  frame.index = static_cast<std::int64_t>(position);
  frame.time_s = static_cast<double>(position) / kFrameRate_hz;
  frame.depth_camera = kCamera;
  frame.color_camera = kCamera;
  frame.world_from_camera = state_->tracked_path[position];
  frame.depth = std::move(sensed.depth);
  frame.color = std::move(sensed.color);
  return result;
}

const SimulationOptions& Simulation::options() const { return state_->options; }
const Home& Simulation::home() const { return state_->world.home; }
const MovingHome& Simulation::world() const { return state_->world; }
bool Simulation::moves() const { return dynamics_of(state_->options.dynamics) != Dynamics::kStatic; }
const LabelSet& Simulation::labels() const { return state_->labels; }
const Renderer& Simulation::renderer() const { return state_->renderer; }
const Camera& Simulation::camera() const { return kCamera; }

}  // namespace panoptic
