// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A home, a camera's way through it, and every frame on demand.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/labels.h"
#include "panoptic/scan_truth.h"
#include "panoptic/sim/home.h"
#include "panoptic/sim/jumps.h"
#include "panoptic/sim/moving_home.h"
#include "panoptic/sim/renderer.h"
#include "panoptic/sim/sensor_noise.h"
#include "panoptic/source.h"

namespace panoptic {

struct SimulationOptions {
  std::uint64_t seed = 1;
  int rooms = 4;
  int frames = 0;                   // 0 = as many as the way takes at 30 Hz
  std::string noise = "kinect";     // sensor_noise_preset
  std::string dynamics = "static";  // dynamics_of
  int jumps = 0;                    // kidnappings of the camera (jumps.h)
};

// "sim:SEED" or "sim:SEED,rooms=2,frames=300,noise=none,dynamics=busy" or "sim:SEED,jumps=4". Throws Error showing the syntax.
SimulationOptions parse_simulation(const std::string& text);

struct SimulatedFrame {
  Frame frame;          // as the sensor gives it, pose as the tracker reports it
  Rendering rendering;  // the truth: noise-free
  Pose true_world_from_camera = Pose::Identity();
};

class Simulation : public Dataset {
 public:
  // Throws Error (package missing, options out of range).
  explicit Simulation(const SimulationOptions& options);
  ~Simulation() override;
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  std::string description() const override;
  std::size_t size() const override;
  ReadResult read(std::size_t position) const override;

  SimulatedFrame simulate(std::size_t position) const;  // REQUIRES position < size()

  const SimulationOptions& options() const;
  const Home& home() const;  // with every thing in each of its places, if some are moved
  const MovingHome& world() const;
  bool moves() const;                          // false: the dynamics are "static"
  const std::vector<Pose>& true_path() const;  // world_from_camera of every frame
  const JumpingPath& jumps() const;            // the same, and where the camera was carried off
  const LabelSet& labels() const;              // of the classes that frames show
  const Renderer& renderer() const;
  const Camera& camera() const;  // of depth and colour alike: 640x480, as ScanNet's

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The ground-truth mesh: marching cubes of the noise-free fusion of every `stride`-th frame at 2 cm, vertices labelled from the
// nearest true surface. Where things move it is the surface at the end, as far as frames showed it.
ScanTruth ground_truth(const Simulation& simulation, std::size_t stride = 1);

}  // namespace panoptic
