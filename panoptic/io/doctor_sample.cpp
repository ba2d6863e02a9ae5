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

// The values that at least a hundredth of the readings have, with their number.
std::vector<std::pair<float, std::size_t>> common_values(std::vector<float> readings) {
  constexpr std::size_t kOneIn = 100;
  std::vector<std::pair<float, std::size_t>> common;
  std::sort(readings.begin(), readings.end());
  for (auto first = readings.begin(); first != readings.end();) {
    const auto end = std::upper_bound(first, readings.end(), *first);
    const auto count = static_cast<std::size_t>(end - first);
    if (count * kOneIn >= readings.size()) common.emplace_back(*first, count);
    first = end;
  }
  return common;
}

FrameFacts examine(const ReadResult& result) {
  if (!result.frame) return {.reason = result.skipped.reason};
  const Frame& frame = *result.frame;
  if (const Outcome outcome = check(frame); !outcome.used) {
    return {.reason = outcome.reason, .depth_camera = frame.depth_camera, .color_camera = frame.color_camera};
  }
  constexpr std::size_t kStride = 7;
  std::vector<float> readings;
  for (std::size_t i = 0; i < frame.depth.size(); i += kStride) {
    if (frame.depth[i] > 0) readings.push_back(frame.depth[i]);
  }
  FrameFacts facts{true, "", is_rigid(frame.world_from_camera), median(readings), frame.depth_camera, frame.color_camera};
  facts.pose = frame.world_from_camera;
  facts.readings = readings.size();
  facts.common_m = common_values(std::move(readings));
  return facts;
}

// Frames this near to each other look alike, whatever their depth says. Poses that are equal prove nothing: they may be wrong.
bool hardly_moved(const Pose& a, const Pose& b) {
  constexpr double kLittle_m = 0.1;
  constexpr double kLittle_rad = 0.09;
  const Pose motion = a.inverse() * b;
  if (motion.matrix().isIdentity(1e-9)) return false;
  return motion.translation().norm() < kLittle_m && Eigen::AngleAxisd(motion.linear()).angle() < kLittle_rad;
}

DepthView view_of(const Dataset& dataset, std::size_t position, const Frame& frame) {
  DepthView view = thinned(frame, repaired(frame.depth_camera));
  if (position > 0) view.pose_before = dataset.pose(position - 1);
  if (position + 1 < dataset.size()) view.pose_after = dataset.pose(position + 1);
  return view;
}

PairFacts find_pair(const Dataset& dataset, std::size_t position) {
  constexpr std::size_t kFarthestGap = 64;
  constexpr double kLooksDifferent = 0.5;
  PairFacts facts;
  const ReadResult first = dataset.read(position);
  if (!first.frame || !check(*first.frame).used) return facts;
  ViewPair pair{view_of(dataset, position, *first.frame), {}};
  for (std::size_t gap = 1; gap <= kFarthestGap && position + gap < dataset.size(); gap *= 2) {
    const std::optional<Pose> pose = dataset.pose(position + gap);
    const bool is_last = 2 * gap > kFarthestGap || position + 2 * gap >= dataset.size();
    if (pose && !is_last && hardly_moved(first.frame->world_from_camera, *pose)) continue;
    const ReadResult later = dataset.read(position + gap);
    if (!later.frame || !check(*later.frame).used) continue;
    const Vec3d motion = later.frame->world_from_camera.translation() - first.frame->world_from_camera.translation();
    if (gap == 1) facts.step_m = motion.norm();
    pair.to = view_of(dataset, position + gap, *later.frame);
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

std::vector<Step> find_steps(const Dataset& dataset, std::size_t samples) {
  const std::size_t places = dataset.size() < 2 ? 0 : dataset.size() - 1;
  std::vector<std::optional<Step>> found(std::min(samples, places));
  parallel_for(found.size(), [&](std::size_t i) {
    const std::size_t position = spread(i, found.size(), places);
    const std::optional<Pose> a = dataset.pose(position);
    const std::optional<Pose> b = a ? dataset.pose(position + 1) : std::nullopt;
    if (b) found[i] = Step{position, (b->translation() - a->translation()).norm()};
  });
  std::vector<Step> steps;
  for (const std::optional<Step>& step : found) {
    if (step) steps.push_back(*step);
  }
  return steps;
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
