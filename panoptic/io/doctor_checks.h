// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The checks of the doctor, each over what was sampled of a recording.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "panoptic/io/doctor.h"
#include "panoptic/io/doctor_geometry.h"
#include "panoptic/io/doctor_sample.h"

namespace panoptic {

// Facts about a recording and what its frames say about scale, poses and focal length.
struct Examination {
  RecordingNotes notes;
  std::size_t size = 0;
  std::vector<FrameFacts> frames;  // REQUIRES one that is usable, but for check_frames and check_rotations
  std::vector<Step> steps;
  std::vector<ViewPair> pairs;
  double median_m = 0;
  std::optional<Explanations> found;  // nothing if too few pairs of frames show motion
};

Check check_frames(const Examination& examination);
Check check_rotations(const Examination& examination);
// A focal length or a principal point that the images rule out.
Check check_intrinsics(const std::string& name, const Camera& camera);
// A value of the depth images that stands for something else than a distance.
Check check_readings(const Examination& examination);
Check check_scale(const Examination& examination);
Check check_poses(const Examination& examination);
Check check_steps(const Examination& examination);
// Adds what the agreement of depth images says about the focal length.
void add_focal_finding(Check& intrinsics, const Examination& examination);

}  // namespace panoptic
