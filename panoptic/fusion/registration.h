// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Depth registration: once per frame, colour and segments are gathered onto the depth pixels, and the rest of the system works
// on those alone.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/frame.h"
#include "panoptic/options.h"
#include "panoptic/segmentation.h"

namespace panoptic {

Fields fields(DepthOptions& options);

// The frame on the grid of the depth image: width x height pixels, row-major, plus ONE extra pixel at the end that holds "no
// reading", so that a look-up outside the image is an index and not a branch.
struct RegisteredFrame {
  static constexpr std::uint16_t kNoSegment =
      65535;  // no depth, hidden from the colour camera, outside its image, or no prediction

  int width = 0;
  int height = 0;
  std::vector<float> depth;            // metres; 0 = no (usable) reading
  std::vector<float> depth_weight;     // Frame::depth_weight; empty: all 1
  std::vector<std::uint32_t> color;    // 0xFFrrggbb; 0 = not seen by the colour camera
  std::vector<std::uint16_t> segment;  // as Segmentation::segment_at, or kNoSegment

  std::size_t readings = 0;  // pixels with depth
  float farthest_m = 0;      // the largest depth

  // The first pixel of a row.
  std::size_t index(int row) const { return static_cast<std::size_t>(row) * static_cast<std::size_t>(width); }
  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

// Gathers through the calibration. Where the cameras stand apart, a depth pixel that something nearer hides from the colour
// camera gets neither colour nor segment. REQUIRES inputs that `check` accepts. Keeps its buffers: one per thread.
class Registration {
 public:
  explicit Registration(const DepthOptions& options) : options_(options) {}

  // The result is good until the next call; whoever asked for it may change it.
  RegisteredFrame& apply(const Frame& frame, const Segmentation& segmentation);

 private:
  struct Rows {
    int begin = 0;
    int end = 0;
  };
  // Rows of the depth image that one thread works on, and what it finds there.
  struct Band {
    Rows rows;
    std::size_t readings = 0;
    float farthest_m = 0;
    std::vector<std::int32_t> color_pixel;  // per depth pixel: index into the colour image
    std::vector<std::int32_t> cell;         // per depth pixel: cell of the visibility test
    std::vector<float> color_depth;         // per depth pixel: z in the colour camera
    std::vector<float> nearest;             // smallest z per cell of the colour image, for cells in [begin_cell, end_cell)
    std::size_t begin_cell = 0;
    std::size_t end_cell = 0;
  };

  void resize(const Frame& frame);
  void clean_depth(const Frame& frame, Band& band);
  void gather_registered(const Frame& frame, const Segmentation& segmentation, const Band& band);
  void project(const Frame& frame, Band& band);
  void find_nearest(Band& band, std::size_t begin_cell, std::size_t end_cell);
  void limit_visibility();
  template <typename Colors>
  void gather_visible(const Colors& colors, const Segmentation& segmentation, const Band& band);

  DepthOptions options_;
  RegisteredFrame result_;
  int cell_px_ = 1;  // edge of a cell in colour pixels
  std::vector<Band> bands_;
  std::vector<float> limits_;  // per cell: what lies deeper is hidden; and one cell for what is outside the image
};

}  // namespace panoptic
