// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "fuzz/input.h"
#include "panoptic/io/sens.h"

namespace panoptic::fuzz {

void sens(Input input) {
  constexpr std::size_t kMostFrames = 3;
  static const Scratch kScratch("sens");
  const std::filesystem::path path = kScratch.put("a.sens", input);
  succeeds([&] {
    const SensDataset dataset(path);
    require(!dataset.description().empty(), "a recording has a description");
    for (std::size_t i = 0; i < std::min(dataset.size(), kMostFrames); ++i) {
      const ReadResult result = dataset.read(i);
      require(result.frame || !result.skipped.reason.empty(), "there is a frame or a reason");
      if (!result.frame) continue;
      const Frame& frame = *result.frame;
      require(frame.depth.same_size(frame.depth_camera.width, frame.depth_camera.height), "depth has the camera's size");
      require(frame.color.same_size(frame.color_camera.width, frame.color_camera.height), "colour has the camera's size");
      require(is_finite(frame.world_from_camera), "poses are finite");
    }
  });
}

}  // namespace panoptic::fuzz
