// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// From samples to pixels.
#include <algorithm>
#include <cmath>

#include "panoptic/fusion/motion_mask.h"
#include "panoptic/fusion/motion_surface.h"

namespace panoptic {

void MotionMask::take_pixels(const FrameView& view, const VoxelMap& map, RegisteredFrame& registered) {
  sight_.mask.assign(registered.pixel_count(), 0);
  for (std::size_t i = 0; i < registered.pixel_count(); ++i) {
    const std::uint16_t segment = registered.segment[i];
    const bool is_mobile = segment != 0 && segment <= thing_of_segment_.size() && thing_of_segment_[segment - 1U] != 0;
    if (!is_mobile) continue;
    const auto x = static_cast<int>(i % static_cast<std::size_t>(registered.width)) / grid_.stride;
    const auto y = static_cast<int>(i / static_cast<std::size_t>(registered.width)) / grid_.stride;
    const std::size_t sample = grid_.index(x, y);
    const bool is_of_block = is_behind_[sample] == 0 && grid_.thing[sample] == 0;  // it is of the map as well, say
    if (is_of_block || thing_near(x, y, registered.depth[i]) != 0) sight_.mask[i] = 255;
    registered.depth[i] = 0;
  }
  std::vector<std::uint8_t> around(grid_.size(), 0);
  for (const std::size_t i : queue_) {
    const auto x = static_cast<int>(i % static_cast<std::size_t>(grid_.width));
    const auto y = static_cast<int>(i / static_cast<std::size_t>(grid_.width));
    for (int by = std::max(0, y - 1); by <= std::min(grid_.height - 1, y + 1); ++by) {
      for (int bx = std::max(0, x - 1); bx <= std::min(grid_.width - 1, x + 1); ++bx) around[grid_.index(bx, by)] = 1;
    }
  }
  for (int y = 0; y < grid_.height; ++y) {
    for (int x = 0; x < grid_.width; ++x) {
      if (around[grid_.index(x, y)] != 0) take_block(x, y, view, map, registered);
    }
  }
  registered.readings = 0;
  for (std::size_t i = 0; i < registered.pixel_count(); ++i) {
    if (sight_.mask[i] == 255) registered.depth[i] = 0;
    registered.readings += registered.depth[i] > 0 ? 1 : 0;
    if (registered.depth[i] > 0) continue;
    registered.color[i] = 0;
    registered.segment[i] = RegisteredFrame::kNoSegment;
  }
}

// The thing, at or beside this sample, whose surface goes on at that depth; 0 if there is none.
std::uint16_t MotionMask::thing_near(int x, int y, float z_m) const {
  std::uint16_t near = 0;
  for (int by = std::max(0, y - 1); by <= std::min(grid_.height - 1, y + 1); ++by) {
    for (int bx = std::max(0, x - 1); bx <= std::min(grid_.width - 1, x + 1); ++bx) {
      const std::size_t beside = grid_.index(bx, by);
      if (grid_.depth[beside] > 0 && std::abs(grid_.depth[beside] - z_m) <= step_m(z_m))
        near = std::max(near, grid_.thing[beside]);
    }
  }
  return near;
}

// The pixels that a sample at or beside a thing stands for: those of its surface are the thing's. The others have no reading
// either, because masks end too early and depth is smeared at borders.
void MotionMask::take_block(int x, int y, const FrameView& view, const VoxelMap& map, RegisteredFrame& registered) {
  const bool is_own = grid_.thing[grid_.index(x, y)] != 0;
  const int end_u = std::min((x + 1) * grid_.stride, registered.width);
  const int end_v = std::min((y + 1) * grid_.stride, registered.height);
  for (int v = y * grid_.stride; v < end_v; ++v) {
    for (int u = x * grid_.stride; u < end_u; ++u) {
      const std::size_t pixel = registered.index(v) + static_cast<std::size_t>(u);
      const float z = registered.depth[pixel];
      if (!(z > 0) || sight_.mask[pixel] == 255) continue;
      const Vec3d point = view.camera_in_world_m + (view.ray(u, v) * z).cast<double>();
      const std::uint16_t near = thing_near(x, y, z);
      const bool is_thing = near != 0 && (is_own || !is_surface(map, point, z, frames_of_surface(class_of_[near - 1U])));
      if (is_thing) {
        sight_.mask[pixel] = 255;
      } else {
        registered.depth[pixel] = 0;
      }
    }
  }
}

}  // namespace panoptic
