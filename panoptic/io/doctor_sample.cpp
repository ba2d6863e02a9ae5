// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/doctor_sample.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "panoptic/parallel.h"

namespace panoptic {
namespace {

std::size_t spread(std::size_t i, std::size_t samples, std::size_t size) { return i * size / samples; }

FrameFacts examine(const ReadResult& result) {
  if (!result.frame) return {.reason = result.skipped.reason};
  const Frame& frame = *result.frame;
  if (const Outcome outcome = check(frame); !outcome.used) return {.reason = outcome.reason};
  constexpr std::size_t kStride = 7;
  std::vector<float> readings;
  for (std::size_t i = 0; i < frame.depth.size(); i += kStride) {
    if (frame.depth[i] > 0) readings.push_back(frame.depth[i]);
  }
  return {true, "", is_rigid(frame.world_from_camera), median(std::move(readings)), frame.depth_camera, frame.color_camera};
}

PairFacts find_pair(const Dataset& dataset, std::size_t position) {
  constexpr std::size_t kFarthestGap = 64;
  constexpr double kLooksDifferent = 0.5;
  PairFacts facts;
  const ReadResult first = dataset.read(position);
  if (!first.frame || !check(*first.frame).used) return facts;
  ViewPair pair{thinned(*first.frame, repaired(first.frame->depth_camera)), {}};
  for (std::size_t gap = 1; gap <= kFarthestGap && position + gap < dataset.size(); gap *= 2) {
    const ReadResult later = dataset.read(position + gap);
    if (!later.frame || !check(*later.frame).used) continue;
    const Vec3d motion = later.frame->world_from_camera.translation() - first.frame->world_from_camera.translation();
    if (gap == 1) facts.step_m = motion.norm();
    pair.to = thinned(*later.frame, repaired(later.frame->depth_camera));
    if (agreement_without_motion(pair) >= kLooksDifferent) continue;
    facts.pair = std::move(pair);
    break;
  }
  return facts;
}

}  // namespace

std::vector<FrameFacts> examine_frames(const Dataset& dataset, std::size_t samples) {
  std::vector<FrameFacts> frames(std::min(samples, dataset.size()));
  parallel_for(frames.size(),
               [&](std::size_t i) { frames[i] = examine(dataset.read(spread(i, frames.size(), dataset.size()))); });
  return frames;
}

std::vector<PairFacts> find_pairs(const Dataset& dataset, std::size_t samples) {
  std::vector<PairFacts> pairs(std::min(samples, dataset.size()));
  parallel_for(pairs.size(), [&](std::size_t i) { pairs[i] = find_pair(dataset, spread(i, pairs.size(), dataset.size())); });
  return pairs;
}

std::optional<ImageSize> other_size(const Camera& camera) {
  constexpr double kTolerance = 0.2;
  const double off_x = std::abs(camera.cx + 0.5 - camera.width / 2.0) / camera.width;
  const double off_y = std::abs(camera.cy + 0.5 - camera.height / 2.0) / camera.height;
  if (off_x <= kTolerance && off_y <= kTolerance) return std::nullopt;
  return ImageSize{static_cast<int>(std::lround(2 * camera.cx)), static_cast<int>(std::lround(2 * camera.cy))};
}

Camera repaired(const Camera& camera) {
  const std::optional<ImageSize> size = other_size(camera);
  if (!size || size->width <= 0 || size->height <= 0) return camera;
  Camera original = camera;
  original.width = size->width;
  original.height = size->height;
  return resized(original, camera.width, camera.height);
}

double median(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

}  // namespace panoptic
