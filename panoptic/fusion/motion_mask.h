// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Keeps out of the map what moves: things of mobile classes by the masks of networks, and whatever comes into space that is known
// to be free.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/frame.h"
#include "panoptic/fusion/frame_view.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/map.h"
#include "panoptic/moving.h"
#include "panoptic/options.h"
#include "panoptic/segmentation.h"

namespace panoptic {

Fields fields(MovingOptions& options);

// The things that move in a frame. Good until the next frame.
struct MovingSight {
  std::vector<MovingThing> things;
  std::vector<std::uint8_t> mask;  // per depth pixel: 255 = moves, 0 = not; empty if nothing does
  // Cells of free space in which something without a class is, ascending: should it stay, it is furniture.
  std::vector<CellIndex> cells;
};

// A point moves if it lies in a cell that five views or more saw to be empty, as they did the cells around it and the cell
// behind it by the error of the camera; such points count where many lie side by side, and so does all that is joined with them
// and is no surface of the map. Keeps its buffers: one per thread.
class MotionMask {
 public:
  explicit MotionMask(const MovingOptions& options) : options_(options) {}

  // Takes what moves out of the frame: its pixels, and those right around them, have no reading any more. `expected`: where
  // things of mobile classes are thought to be; those that have no mask in this frame have no class in what is returned.
  const MovingSight& take_out(const Frame& frame, const Segmentation& segmentation, const PanopticMap& map,
                              std::span<const MovingThing> expected, RegisteredFrame& registered);

 private:
  // One pixel in stride x stride, which stands for the others.
  struct Grid {
    int stride = 1;
    int width = 0;
    int height = 0;
    std::vector<float> depth;          // 0 = no reading
    std::vector<std::uint16_t> thing;  // 1 + its index; 0 = nothing that moves
    std::size_t index(int x, int y) const {
      return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
    std::size_t size() const { return depth.size(); }
  };

  void sample(const FrameView& view);
  void mark_classes(const FrameView& view, const VoxelMap& map, const RegisteredFrame& registered);
  void find_backgrounds();
  bool was_found(const FrameView& view, const MovingThing& expected) const;
  void mark_expected(const FrameView& view, const VoxelMap& map, std::span<const MovingThing> expected);
  void mark_motion(const FrameView& view, const FreeSpaceMap& space);
  void gather_region(std::size_t seed, const std::vector<std::uint8_t>& seeds, std::vector<std::size_t>& region) const;
  void grow(const FrameView& view, const VoxelMap& map);
  void take_pixels(const FrameView& view, const VoxelMap& map, RegisteredFrame& registered);
  bool is_guess(std::uint16_t thing) const { return thing > first_guess_ && thing <= end_of_guesses_; }
  // The four samples beside one, those that there are.
  template <typename Visit>
  void for_each_beside(std::size_t sample, const Visit& visit) const {
    const auto width = static_cast<std::size_t>(grid_.width);
    if (sample % width > 0) visit(sample - 1);
    if (sample % width + 1 < width) visit(sample + 1);
    if (sample >= width) visit(sample - width);
    if (sample + width < grid_.size()) visit(sample + width);
  }
  std::uint16_t thing_near(int x, int y, float z_m) const;
  void take_block(int x, int y, const FrameView& view, const VoxelMap& map, RegisteredFrame& registered);
  void measure(const FrameView& view, float cell_m);
  Vec3d place_m(const FrameView& view, std::size_t sample) const;

  MovingOptions options_;
  Grid grid_;
  std::vector<std::uint16_t> thing_of_segment_;  // by segment: 1 + index of a thing, or 0
  std::vector<ClassId> class_of_;                // by thing, before those without a sample are left out
  std::size_t first_guess_ = 0;                  // things from here on are where some are thought to be
  std::size_t end_of_guesses_ = 0;
  std::vector<std::uint8_t> is_behind_;  // per sample: of a mask, but not of its thing
  std::vector<std::uint8_t> in_free_;    // per sample
  std::vector<std::size_t> queue_;
  std::vector<std::uint16_t> steps_;
  MovingSight sight_;
};

}  // namespace panoptic
