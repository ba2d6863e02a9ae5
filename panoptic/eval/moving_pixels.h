// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares masks of what moves with the true ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/source.h"

namespace panoptic {

// The time at which each part of a room was first seen, in cells of 20 cm.
class FirstSeen {
 public:
  // Cells outside the box are never seen.
  explicit FirstSeen(const Eigen::AlignedBox3d& box);

  // Takes in what the frame sees: all that is empty before its surfaces, and the surfaces. Frames come in order of time.
  void look(const Frame& frame);
  // Seconds since the cell was first seen; nothing if it never was.
  std::optional<double> seconds(const Vec3d& world_point, double now_s) const;

 private:
  std::optional<std::size_t> cell_at(const Vec3d& world_point) const;

  Vec3d origin_;
  Eigen::Vector3i cells_;
  std::vector<double> first_s_;  // infinite where not seen
};

// Pixels of every second column and row that have a depth and show a place that was first seen a second ago or earlier: a map
// cannot know what moves before it knows the place.
struct MovingPixels {
  std::uint64_t both = 0;
  std::uint64_t claimed_only = 0;
  std::uint64_t true_only = 0;
  std::uint64_t frames = 0;        // compared
  std::uint64_t without_mask = 0;  // frames that the run gave no mask for: they do not count

  std::optional<double> precision() const;
  std::optional<double> recall() const;
  std::optional<double> f1() const;
};
// Adds one frame. REQUIRES masks of the size of the depth image.
void count_moving(const Frame& frame, const Image<std::uint16_t>& truth, const Image<std::uint16_t>& claim,
                  const FirstSeen& first_seen, MovingPixels& pixels);

// Compares all masks of two folders, named by the frames of the recording. `box`: of the scene. Throws Error naming the mask
// that is absent from the truth or has another size than the frame, or if there is none to compare.
MovingPixels score_moving(const Dataset& recording, const std::filesystem::path& truth, const std::filesystem::path& claims,
                          const Eigen::AlignedBox3d& box);

}  // namespace panoptic
