// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/features.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "panoptic/tracking/draws.h"
#include "panoptic/tracking/projection.h"

namespace panoptic {
namespace {

constexpr int kMostFeatures = 400;
constexpr double kQuality = 0.003;  // of the strongest corner
constexpr double kApart_px = 5;
constexpr float kPatch_m = 0.1F;  // radius of what a descriptor looks at
constexpr float kPatch_px = 12;   // the same in the level of the pyramid that it is looked up in, at least two thirds of it
constexpr int kBits = 256;
constexpr int kMostDifferent = 64;  // bits, between two views of one point
constexpr float kClearly = 0.85F;

struct Comparison {
  float ax = 0;
  float ay = 0;
  float bx = 0;
  float by = 0;
};

// Pairs of places in the unit disc, drawn once and for all.
std::array<Comparison, kBits> draw_comparisons() {
  Draws draws(1);
  const auto draw = [&] { return static_cast<float>(draws.next() >> 40) / static_cast<float>(1U << 23) - 1; };
  const auto place = [&](float& x, float& y) {
    do {
      x = draw();
      y = draw();
    } while (x * x + y * y > 1);
  };
  std::array<Comparison, kBits> comparisons{};
  for (Comparison& c : comparisons) {
    place(c.ax, c.ay);
    place(c.bx, c.by);
  }
  return comparisons;
}

// A corner in one level of the pyramid: where, and how far around it the descriptor looks.
struct Patch {
  const Image<float>* grey = nullptr;
  float u = 0;
  float v = 0;
  float radius_px = 0;
};

std::optional<Patch> patch_at(const std::vector<GreyLevel>& pyramid, float u, float v, float radius_px) {
  std::size_t level = 0;
  while (level + 1 < pyramid.size() && radius_px > 1.5F * kPatch_px) {
    ++level;
    radius_px /= 2;
    u = (u + 0.5F) / 2 - 0.5F;
    v = (v + 0.5F) / 2 - 0.5F;
  }
  const Patch patch{&pyramid[level].grey, u, v, std::clamp(radius_px, kPatch_px / 1.5F, 1.5F * kPatch_px)};
  const float reach = patch.radius_px + 1;
  if (!is_inside(*patch.grey, u - reach, v - reach) || !is_inside(*patch.grey, u + reach, v + reach)) return std::nullopt;
  return patch;
}

// The direction of the patch's centre of brightness.
float direction(const Patch& patch) {
  const int r = static_cast<int>(patch.radius_px);
  float right = 0;
  float down = 0;
  for (int y = -r; y <= r; ++y) {
    for (int x = -r; x <= r; ++x) {
      if (x * x + y * y > r * r) continue;
      const float value = (*patch.grey)(static_cast<int>(patch.u) + x, static_cast<int>(patch.v) + y);
      right += static_cast<float>(x) * value;
      down += static_cast<float>(y) * value;
    }
  }
  return std::atan2(down, right);
}

Descriptor describe(const Patch& patch) {
  static const std::array<Comparison, kBits> kComparisons = draw_comparisons();
  const float angle = direction(patch);
  const float c = patch.radius_px * std::cos(angle);
  const float s = patch.radius_px * std::sin(angle);
  const auto value = [&](float x, float y) {
    return sample(*patch.grey, patch.u + c * x - s * y, patch.v + s * x + c * y).value;
  };
  Descriptor descriptor{};
  for (std::size_t i = 0; i < kBits; ++i) {
    const Comparison& p = kComparisons[i];
    if (value(p.ax, p.ay) < value(p.bx, p.by)) descriptor[i / 64] |= std::uint64_t{1} << i % 64;
  }
  return descriptor;
}

std::vector<cv::Point2f> corners(const Image<float>& grey) {
  const cv::Mat image(grey.height(), grey.width(), CV_32F, const_cast<float*>(grey.data()));  // OpenCV has no view of constants
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(image, found, 2 * kMostFeatures, kQuality, kApart_px);
  return found;
}

// The point of the depth camera that a colour pixel shows; nothing where the depth is missing or jumps.
std::optional<Vec3f> point_at(const Frame& frame, const Camera& color, const cv::Point2f& corner, const DepthLimits& range) {
  // The pixel depends on the depth if the two cameras stand apart: two looks are enough.
  const Pose depth_from_color = frame.color_from_depth.inverse();
  double z = 2;
  for (int look = 0; look < 3; ++look) {
    const Vec3d in_depth = depth_from_color * back_project(color, double{corner.x}, double{corner.y}, z);
    if (!(in_depth.z() > 0)) return std::nullopt;
    const Camera& c = frame.depth_camera;
    const Eigen::Vector2d pixel = project(c, in_depth);
    const double u = pixel.x() + 0.5;
    const double v = pixel.y() + 0.5;
    if (!(u >= 0 && v >= 0 && u < c.width && v < c.height)) return std::nullopt;
    const int iu = static_cast<int>(u);
    const int iv = static_cast<int>(v);
    const float reading = frame.depth(iu, iv);
    if (!(reading >= range.min_m && reading <= range.max_m) || !is_smooth(frame.depth, iu, iv, 2)) return std::nullopt;
    const Vec3d point = back_project(c, u - 0.5, v - 0.5, double{reading});
    z = (frame.color_from_depth * point).z();
    if (look == 2) return point.cast<float>();
  }
  return std::nullopt;
}

struct Best {
  int first = std::numeric_limits<int>::max();
  int second = std::numeric_limits<int>::max();
  std::size_t at = 0;

  void offer(int distance, std::size_t index) {
    if (distance < first) {
      second = first;
      first = distance;
      at = index;
    } else if (distance < second) {
      second = distance;
    }
  }
  bool is_clear() const { return first <= kMostDifferent && static_cast<float>(first) <= kClearly * static_cast<float>(second); }
};

}  // namespace

int distance(const Descriptor& a, const Descriptor& b) {
  return std::popcount(a[0] ^ b[0]) + std::popcount(a[1] ^ b[1]) + std::popcount(a[2] ^ b[2]) + std::popcount(a[3] ^ b[3]);
}

std::vector<Feature> find_features(const Frame& frame, const std::vector<GreyLevel>& pyramid, const DepthLimits& range) {
  std::vector<Feature> features;
  if (pyramid.empty()) return features;
  const Camera& camera = pyramid.front().camera;
  for (const cv::Point2f& corner : corners(pyramid.front().grey)) {
    if (features.size() == kMostFeatures) break;
    const std::optional<Vec3f> point = point_at(frame, camera, corner, range);
    if (!point) continue;
    const auto radius_px = static_cast<float>(camera.fx) * kPatch_m / point->z();
    if (const auto patch = patch_at(pyramid, corner.x, corner.y, radius_px)) features.push_back({*point, describe(*patch)});
  }
  return features;
}

std::vector<FeatureMatch> match(const std::vector<Feature>& a, const std::vector<Feature>& b) {
  std::vector<Best> of_a(a.size());
  std::vector<Best> of_b(b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int d = distance(a[i].descriptor, b[j].descriptor);
      of_a[i].offer(d, j);
      of_b[j].offer(d, i);
    }
  }
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (of_a[i].is_clear() && of_b[of_a[i].at].at == i) matches.push_back({i, of_a[i].at});
  }
  return matches;
}

}  // namespace panoptic
