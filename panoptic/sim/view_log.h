// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The things of a scene that a camera sees on its way, in small pictures of some of its frames.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"
#include "panoptic/sim/renderer.h"

namespace panoptic {

// A surface that is farther than this does not count as shown: depth cameras see little there.
constexpr double kShown_m = 4;
// A share of the picture that shows enough of a thing: a chair at three metres covers two hundredths.
constexpr double kEnoughOfPicture = 0.008;

// A picture of one frame.
struct SmallView {
  std::size_t frame = 0;
  Pose world_from_camera = Pose::Identity();
  Image<float> depth;
  std::vector<std::uint16_t> pixels;  // per object of the scene: all that are seen
  std::vector<std::uint16_t> near;    // and those of them that count as shown
};

class ViewLog {
 public:
  // Looks at every `stride`-th frame of the way. `camera` is that of the recording.
  ViewLog(const Renderer& renderer, std::size_t objects, const std::vector<Pose>& path, const Camera& camera, std::size_t stride);

  const std::vector<SmallView>& views() const { return views_; }
  int enough_px() const;

  // How many of 27 points of the box the view sees: at all, and near enough to count as shown. A thing that stands there hides
  // the points behind its surface, but not those on it.
  struct Points {
    int seen = 0;
    int near = 0;
  };
  static constexpr int kEnoughPoints = 8;
  Points points_in(const SmallView& view, const Eigen::AlignedBox3d& box) const;

 private:
  Camera camera_;
  std::vector<SmallView> views_;
};

}  // namespace panoptic
