// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Turns a perfect rendering into images like those of a depth sensor and a hand-held camera. Presets: "none", "kinect" (the
// sensor alone), "drift" (kinect, and poses that wander off), "harsh" (drift, motion blur and exposure).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/geometry.h"
#include "panoptic/sim/renderer.h"

namespace panoptic {

// The number of frames that the simulated camera takes in a second.
constexpr double kFrameRate_hz = 30;

// The defaults are free of noise.
struct SensorNoise {
  float axial_m_per_m2 = 0;     // standard deviation of depth at 1 m; grows with depth squared (Khoshelham and Elberink 2012)
  float quantum_m_per_m2 = 0;   // depth step at 1 m; grows with depth squared
  float max_range_m = 0;        // no reading beyond; 0 = everywhere
  float min_cos_incidence = 0;  // no reading where the surface is more oblique
  float dark_dropout = 0;       // probability that a black surface gives no reading
  float flying_px = 0;          // how far into the background pixels at depth edges are smeared
  float drift_m_per_s = 0;      // random walk of the pose, standard deviation along each axis after a second
  float drift_rad_per_s = 0;
  bool motion_blur = false;
  bool exposure = false;  // slow changes of brightness and colour balance
};
Fields fields(SensorNoise& noise);

// Throws Error listing the presets if there is none of that name.
SensorNoise sensor_noise_preset(const std::string& name);

// Applies the noise to the depth and colour of a rendering, in place. Depends on (seed, frame index) alone, not on other frames.
// `motion_px`: how the image moved since the previous frame, for motion blur.
void add_sensor_noise(const SensorNoise& noise, std::uint64_t seed, std::int64_t frame_index, Rendering& rendering,
                      const Eigen::Vector2f& motion_px);

// The path as a tracker with drift would report it, at kFrameRate_hz: every step between frames is a little wrong, so errors
// add up. Starts at the true pose.
std::vector<Pose> with_drift(const SensorNoise& noise, std::uint64_t seed, const std::vector<Pose>& truth);

}  // namespace panoptic
