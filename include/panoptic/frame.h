// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One posed RGB-D frame. Its images can be borrowed: `frame.depth = SharedImage(ImageView<float>(pixels, width, height,
// row_bytes))` reads a caller's memory where it lies. Mapper reads a frame during the call alone, and copies neither image;
// whatever keeps a frame longer (OnlinePipeline, a snapshot for those who look on) keeps the images' owners, and copies images
// that have none.
#pragma once

#include <cstdint>

#include "panoptic/geometry.h"
#include "panoptic/image.h"
#include "panoptic/outcome.h"

namespace panoptic {

struct Frame {
  std::int64_t index = 0;  // the frame's number in its recording: no two frames of a run have the same
  double time_s = 0;       // for playback and trajectories; 0 = not known
  Camera depth_camera;
  Camera color_camera;                        // may differ from the depth camera in size, intrinsics and place
  Pose color_from_depth = Pose::Identity();   // a point of the depth camera's frame in the colour camera's frame
  Pose world_from_camera = Pose::Identity();  // the depth camera
  SharedImage<float> depth;                   // metres, planar z; 0 and all that is no positive number: no reading
  SharedImage<float> depth_weight;            // of each reading beside others of its depth, in (0, 1]; empty: all count 1
  SharedImage<Rgb> color;                     // as the colour camera saw it
};

// The frame, to be kept for any time: with SharedImage::kept images.
Frame kept(Frame frame);

// Whether a frame can be used: not with a pose that is NaN or no rigid motion, a camera without sound intrinsics or wider than
// 150 degrees, images of another size than their cameras', no colour, no depth reading at all, or a reading of no sound weight.
Outcome check(const Frame& frame);

}  // namespace panoptic
