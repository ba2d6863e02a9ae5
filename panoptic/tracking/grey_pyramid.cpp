// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/grey_pyramid.h"

#include <algorithm>

#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr int kWidest_px = 400;
constexpr int kSmallest_px = 16;

// Means over squares of `side` pixels.
Image<float> shrunk(const ImageView<Rgb>& color, int side) {
  Image<float> grey(color.width() / side, color.height() / side);
  const float share = 1.0F / static_cast<float>(256 * side * side);
  parallel_for(static_cast<std::size_t>(grey.height()), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    std::vector<std::uint32_t> sums(static_cast<std::size_t>(grey.width()));
    for (int y = 0; y < side; ++y) {
      const Rgb* pixel = color.row(v * side + y);
      for (std::uint32_t& sum : sums) {
        for (int x = 0; x < side; ++x, ++pixel) sum += 77U * pixel->r + 150U * pixel->g + 29U * pixel->b;
      }
    }
    std::transform(sums.begin(), sums.end(), grey.row(v), [&](std::uint32_t sum) { return share * static_cast<float>(sum); });
  });
  return grey;
}

Image<float> halved(const Image<float>& image) {
  Image<float> half(image.width() / 2, image.height() / 2);
  for (int v = 0; v < half.height(); ++v) {
    const float* top = image.row(2 * v);
    const float* bottom = image.row(2 * v + 1);
    float* to = half.row(v);
    for (int u = 0; u < half.width(); ++u) to[u] = 0.25F * (top[2 * u] + top[2 * u + 1] + bottom[2 * u] + bottom[2 * u + 1]);
  }
  return half;
}

// The camera of an image that was made of squares of `side` pixels.
Camera shrunk(const Camera& camera, int side) {
  Camera small = camera;
  small.width = camera.width / side;
  small.height = camera.height / side;
  small.fx /= side;
  small.fy /= side;
  small.cx = (camera.cx + 0.5) / side - 0.5;
  small.cy = (camera.cy + 0.5) / side - 0.5;
  return small;
}

}  // namespace

std::vector<GreyLevel> grey_pyramid(const ImageView<Rgb>& color, const Camera& camera) {
  int side = 1;
  while (color.width() / side > kWidest_px) side *= 2;
  std::vector<GreyLevel> levels;
  if (std::min(color.width(), color.height()) / side < kSmallest_px) return levels;
  levels.push_back({shrunk(camera, side), shrunk(color, side)});
  for (int level = 1; level < kGreyLevels; ++level) {
    const GreyLevel& finer = levels.back();
    if (std::min(finer.grey.width(), finer.grey.height()) < 2 * kSmallest_px) break;
    levels.push_back({shrunk(finer.camera, 2), halved(finer.grey)});
  }
  return levels;
}

}  // namespace panoptic
