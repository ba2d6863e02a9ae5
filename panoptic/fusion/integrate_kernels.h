// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The inner loops of integration: what one observation does to a voxel (Eq. 6-11), and one block against one frame.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "panoptic/labels.h"
#include "panoptic/map/voxel_label.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

// The weight of a vote, beside that of the distance: object ids are those from first_object on.
struct LabelVotes {
  float object = 1;
  std::uint16_t first_object = 65535;

  float of(std::uint16_t label) const { return label >= first_object ? object : 1.0F; }
};

// The frame as the kernels see it: raw planes with one extra "no reading" pixel at the end, camera numbers in float.
struct KernelFrame {
  const float* depth = nullptr;
  const std::uint32_t* color = nullptr;
  const LabelSlot* label = nullptr;
  int width = 0;
  int height = 0;
  float fx = 1, fy = 1, cx = 0, cy = 0;
  LabelVotes votes;
  float max_weight = std::numeric_limits<float>::infinity();  // of a voxel (MapOptions)
  bool labels_only = false;                                   // label, label weight and sum of votes alone are updated
  const float* scale = nullptr;                               // per pixel, of signed distances (grazing.h); nullptr: all 1
  const float* depth_weight = nullptr;                        // per pixel, of readings (Frame); nullptr: all 1
};

// The truncation band around the surface: half width, and how far behind the surface the weight starts to drop. Metres.
struct Band {
  float truncation_m;
  float drop_off_m;
};

// w_t: 1/z^2 as in voxblox (the paper's "quadric weight"), falling linearly to 0 from drop_off behind the surface to the end of
// the band. z: measured depth; distance: signed distance of the voxel.
inline float observation_weight(float z, float distance, const Band& band) {
  const float quadric = 1.0F / (z * z);
  const float share = (band.truncation_m + distance) / (band.truncation_m - band.drop_off_m);
  const float drop = distance < -band.drop_off_m ? (share > 0 ? share : 0.0F) : 1.0F;
  return quadric * drop;
}

// Eq. 6: the weighted mean of old and new.
inline float fused_distance(float old_distance, float old_weight, float distance, float weight) {
  return (old_weight * old_distance + weight * distance) / (old_weight + weight);
}

// Eq. 7, up to the limit.
inline float fused_weight(float old_weight, float weight, float max_weight) {
  const float sum = old_weight + weight;
  return sum > max_weight ? max_weight : sum;
}

// The mean of one colour channel in 8.8 fixed point. 0 means "no colour yet", so black is stored as 1/256. The weight is that
// of the distance: colour seen for the first time is taken whole, and if depth was seen without colour before, what follows
// moves it more slowly than a weight of its own would (which would cost a plane). A step of less than one unit is made one
// unit: if it were rounded away, a colour seen from far could never change one seen from near.
inline float whole_step(float step) {
  const float up = step > 1.0F ? step : 1.0F;
  const float down = step < -1.0F ? step : -1.0F;
  return step > 0 ? up : step < 0 ? down : 0.0F;
}
inline std::int32_t fused_color(std::int32_t old_color, float old_weight, std::int32_t color, float weight) {
  const float target = static_cast<float>(color) * 256.0F;
  const auto old = static_cast<float>(old_color);
  const float share = old_color == 0 ? 1.0F : weight / (old_weight + weight);
  const float mean = old + whole_step((target - old) * share) + 0.5F;
  return static_cast<std::int32_t>(mean > 1.0F ? mean : 1.0F);
}

// The place of a block in the camera frame: the centre of voxel (0, 0, 0), and the steps to the next voxel along each axis.
struct BlockInCamera {
  float origin[3];
  float step_x[3];
  float step_y[3];
  float step_z[3];
};

// Bricks of a block, a bit each.
struct BricksInBand {
  std::uint64_t bricks = 0;
  bool grazing = false;  // some may see pixels of a scale below 1
};

// Projects the voxels of these bricks into the frame and fuses the pixels they fall on, within the band (Eq. 6-11; with
// frame.labels_only Eq. 9-11, for voxels that are stored). Stores the voxels that are observed for the first time.
void integrate_block(const KernelFrame& frame, const BlockInCamera& place, const Band& band, const BricksInBand& bricks,
                     VoxelBlock& block);

}  // namespace panoptic
