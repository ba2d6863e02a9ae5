// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/bag.h"

#include <algorithm>

#include "fuzz/input.h"

namespace panoptic::fuzz {

// A bag of any container: which one it is shows by its first bytes.
void bag(Input input) {
  constexpr std::size_t kMostFrames = 3;
  static const Scratch kScratch("bag");
  const std::filesystem::path path = kScratch.put("a.bag", input);
  succeeds([&] {
    for (const ListedTopic& topic : list_bag(path).topics)
      require(topic.messages == 0 || topic.name.size() <= input.size(), "names are of the file");
  });
  succeeds([&] {
    const auto dataset = open_bag(path, {});
    require(!dataset->description().empty(), "a recording has a description");
    for (std::size_t i = 0; i < std::min(dataset->size(), kMostFrames); ++i) {
      const ReadResult result = dataset->read(i);
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
