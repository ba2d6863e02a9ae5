// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/displacement_field.h"

#include <cmath>
#include <vector>

#include "panoptic/sim/random.h"
#include "panoptic/sim/smooth_noise.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kPurpose = 0x4449;
constexpr int kCoarse_px = 48;
constexpr int kFine_px = 16;
constexpr float kFineShare = 0.3F;  // of the variance

// Normal numbers every `step` pixels, times `scale`.
void add_octave(Random random, int step, float scale, Image<float>& image) {
  Image<float> grid((image.width() - 1) / step + 2, (image.height() - 1) / step + 2);
  for (std::size_t i = 0; i < grid.size(); ++i) grid[i] = scale * static_cast<float>(nearly_normal(random.bits()));
  add_interpolated(grid, step, image);
}

Image<float> noise_image(std::uint64_t seed, std::uint64_t counter, int width, int height) {
  // Interpolation between independent values leaves 4/9 of their variance on average.
  constexpr float kInterpolationLoss = 1.5F;
  Image<float> image(width, height);
  add_octave(Random(seed, kPurpose, counter), kCoarse_px, kInterpolationLoss * std::sqrt(1 - kFineShare), image);
  add_octave(Random(seed, kPurpose + 1, counter), kFine_px, kInterpolationLoss * std::sqrt(kFineShare), image);
  return image;
}

}  // namespace

void add_interpolated(const Image<float>& grid, int step, Image<float>& image) {
  std::vector<float> top(static_cast<std::size_t>(image.width()));
  std::vector<float> bottom(top.size());
  const auto stretch = [&](int row, std::vector<float>& line) {
    for (int u = 0; u < image.width(); ++u) {
      const float t = static_cast<float>(u % step) / static_cast<float>(step);
      line[static_cast<std::size_t>(u)] = grid(u / step, row) + t * (grid(u / step + 1, row) - grid(u / step, row));
    }
  };
  for (int v = 0; v < image.height(); ++v) {
    if (v % step == 0) {
      stretch(v / step, top);
      stretch(v / step + 1, bottom);
    }
    const float t = static_cast<float>(v % step) / static_cast<float>(step);
    float* line = image.row(v);
    for (std::size_t u = 0; u < top.size(); ++u) line[u] += top[u] + t * (bottom[u] - top[u]);
  }
}

DisplacementField::DisplacementField(std::uint64_t seed, std::int64_t frame_index, int width, int height)
    : x_(noise_image(seed, 2 * static_cast<std::uint64_t>(frame_index), width, height)),
      y_(noise_image(seed, 2 * static_cast<std::uint64_t>(frame_index) + 1, width, height)) {}

}  // namespace panoptic
