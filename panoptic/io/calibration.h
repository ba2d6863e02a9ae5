// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The cameras of a recording, as its format states them and as a calibration TOML overrides them.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/io/lens.h"

namespace panoptic {

struct ImageSize {
  int width = 0;
  int height = 0;

  bool operator==(const ImageSize&) const = default;
};

// The sizes in the cameras are those that the intrinsics belong to: 0 = the size of the recording's images, whatever it is.
struct Calibration {
  Camera depth;                              // fx = 0: not known
  std::optional<Camera> color;               // nothing: the colour images are registered to the depth images
  Pose color_from_depth = Pose::Identity();  // a point of the depth camera's frame in the colour camera's frame
  Pose posed_from_depth = Pose::Identity();  // the same in the frame that the recording's poses are of; not overridden
  double depth_scale = 1000;                 // raw value / depth_scale = metres
  std::vector<double> invalid = {65535};     // raw values that are no reading; 0 never is one
  // The lenses. Colour that is registered to depth was distorted as depth is, unless it has a camera or a lens of its own.
  Distortion depth_distortion;
  std::optional<Distortion> color_distortion;
  // Taken for granted: neither the recording nor a calibration file says so.
  bool camera_is_assumed = false;
  bool scale_is_assumed = false;
  bool color_is_assumed = false;  // that it is registered to depth
  // The maps that remove the distortion; made by `fitted`, null where there is none.
  std::shared_ptr<const LensMap> depth_lens;
  std::shared_ptr<const LensMap> color_lens;
};

// Overrides what the file gives and keeps the rest. Throws Error naming file and line for unknown keys, wrong types, values
// out of range, and for intrinsics that stay incomplete. The keys are described in docs/datasets.md.
void read_calibration(const std::filesystem::path& path, Calibration& calibration);

// A pose from 9 numbers, row by row, and 3. Throws Error, beginning with `place`, if it is none.
Pose pose_of(const std::vector<double>& rotation, const std::vector<double>& translation, const std::string& place);

// The calibration for images of these sizes: intrinsics that belong to another size of the same shape are scaled, a missing
// colour camera becomes the depth camera, lenses get their maps. Throws Error, beginning with `source`, if intrinsics are missing
// or the shapes differ by more than 2 %.
Calibration fitted(const Calibration& calibration, ImageSize depth, ImageSize color, const std::string& source);

// The same fitted calibration with this camera in place of both, scaled to their sizes. Throws Error as `fitted` does.
Calibration with_camera(Calibration calibration, const Camera& camera, const std::string& source);

}  // namespace panoptic
