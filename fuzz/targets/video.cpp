// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/video.h"

#include <algorithm>

#include "fuzz/input.h"

namespace panoptic::fuzz {

// The video of a phone, read forwards and then back to its first image.
void video(Input input) {
  constexpr std::size_t kMostImages = 3;
  static const Scratch kScratch("video");
  const std::filesystem::path path = kScratch.put("a.mp4", input);
  succeeds([&] {
    const Video video(path);
    require(video.size() > 0, "a video has images");
    for (std::size_t i = 0; i < std::min(video.size(), kMostImages); ++i) {
      succeeds([&] { require(!video.read(i).empty(), "an image has pixels"); });
    }
    succeeds([&] { require(!video.read(0).empty(), "an image has pixels"); });
  });
}

}  // namespace panoptic::fuzz
