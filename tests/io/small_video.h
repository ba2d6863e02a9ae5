// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Videos for tests, written by FFmpeg's libraries.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/image.h"

namespace panoptic::test {

struct VideoKind {
  std::string codec = "libx264rgb";  // without loss; others get grey images
  int key_every = 8;
  int images_between = 3;    // that need a later one, at most
  bool index_first = false;  // as in files made to be streamed
};

// False if this FFmpeg has no such encoder. Images are of one size, even numbers, and come at irregular times.
bool write_video(const std::filesystem::path& path, const std::vector<Image<Rgb>>& images, const VideoKind& kind = {});

}  // namespace panoptic::test
