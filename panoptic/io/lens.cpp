// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::size_t kMostCoefficients = 8;

// The coefficients by name, those that are not given being 0.
struct Coefficients {
  explicit Coefficients(const Distortion& d) {
    std::copy(d.begin(), d.begin() + static_cast<std::ptrdiff_t>(std::min(d.size(), all.size())), all.begin());
  }

  std::array<double, kMostCoefficients> all{};  // k1 k2 p1 p2 k3 k4 k5 k6

  double p1() const { return all[2]; }
  double p2() const { return all[3]; }
  double above(double r2) const { return 1 + r2 * (all[0] + r2 * (all[1] + r2 * all[4])); }
  double below(double r2) const { return 1 + r2 * (all[5] + r2 * (all[6] + r2 * all[7])); }
  double slope_above(double r2) const { return all[0] + r2 * (2 * all[1] + r2 * 3 * all[4]); }
  double slope_below(double r2) const { return all[5] + r2 * (2 * all[6] + r2 * 3 * all[7]); }

  // Whether the radius in the image still grows with the radius of the point: d/dr (r * above / below) > 0.
  bool grows(double r2) const {
    const double a = above(r2);
    const double b = below(r2);
    return b > 0 && a * b + 2 * r2 * (slope_above(r2) * b - a * slope_below(r2)) > 0;
  }
};

// The last radius, squared, up to which the model grows; looked for as far as images reach.
double largest_r2(const Coefficients& c) {
  constexpr double kFarthest = 16;  // 76 degrees from the axis
  constexpr int kSteps = 512;
  for (int i = 1; i <= kSteps; ++i) {
    if (!c.grows(kFarthest * i / kSteps)) return kFarthest * (i - 1) / kSteps;
  }
  return kFarthest;
}

Eigen::Vector2d distort(const Eigen::Vector2d& p, const Coefficients& c, double largest) {
  const double r2 = p.squaredNorm();
  if (r2 > largest) return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  const double radial = c.above(r2) / c.below(r2);
  const double xy = p.x() * p.y();
  return {p.x() * radial + 2 * c.p1() * xy + c.p2() * (r2 + 2 * p.x() * p.x()),
          p.y() * radial + c.p1() * (r2 + 2 * p.y() * p.y()) + 2 * c.p2() * xy};
}

// The colour between four pixels; coordinates beyond the border are those of the border.
Rgb interpolated(const Image<Rgb>& image, float x, float y) {
  x = std::clamp(x, 0.0F, static_cast<float>(image.width() - 1));
  y = std::clamp(y, 0.0F, static_cast<float>(image.height() - 1));
  const int u = std::min(static_cast<int>(x), std::max(0, image.width() - 2));
  const int v = std::min(static_cast<int>(y), std::max(0, image.height() - 2));
  const int right = std::min(u + 1, image.width() - 1);
  const int below = std::min(v + 1, image.height() - 1);
  const float s = x - static_cast<float>(u);
  const float t = y - static_cast<float>(v);
  const auto mixed = [&](std::uint8_t Rgb::*c) {
    const float upper = (1 - s) * static_cast<float>(image(u, v).*c) + s * static_cast<float>(image(right, v).*c);
    const float lower = (1 - s) * static_cast<float>(image(u, below).*c) + s * static_cast<float>(image(right, below).*c);
    return static_cast<std::uint8_t>(std::lround((1 - t) * upper + t * lower));
  };
  return {mixed(&Rgb::r), mixed(&Rgb::g), mixed(&Rgb::b)};
}

}  // namespace

Distortion to_distortion(const std::string& model, Distortion coefficients, const std::string& source) {
  constexpr std::array<std::string_view, 5> kSameModel = {"", "opencv", "plumb_bob", "radtan", "rational_polynomial"};
  if (model == "none") return {};
  if (std::find(kSameModel.begin(), kSameModel.end(), model) == kSameModel.end()) {
    throw Error(
        fmt::format("{}: the lens model '{}' is not supported: undistort the images first, or give OpenCV's k1 k2 p1 p2 [k3 "
                    "[k4 k5 k6]] (opencv, plumb_bob, radtan, rational_polynomial; none)",
                    source, model));
  }
  for (const double c : coefficients) {
    if (!std::isfinite(c)) throw Error(fmt::format("{}: the lens distortion holds a number that is not finite", source));
  }
  // Thin prisms and tilted sensors: files often write their coefficients as zeros.
  while (coefficients.size() > kMostCoefficients && coefficients.back() == 0) coefficients.pop_back();
  const std::size_t n = coefficients.size();
  if (n != 0 && n != 4 && n != 5 && n != kMostCoefficients) {
    throw Error(
        fmt::format("{}: the lens distortion has {} numbers, expected k1 k2 p1 p2, then k3, then k4 k5 k6 (4, 5 or 8); undistort "
                    "the images first if the lens needs more",
                    source, n));
  }
  const bool does_nothing = std::all_of(coefficients.begin(), coefficients.end(), [](double c) { return c == 0; });
  return does_nothing ? Distortion{} : coefficients;
}

Eigen::Vector2d distorted(const Eigen::Vector2d& point, const Distortion& distortion) {
  const Coefficients c(distortion);
  return distort(point, c, largest_r2(c));
}

LensMap lens_map(const Camera& camera, const Distortion& distortion) {
  const Coefficients c(distortion);
  const double largest = largest_r2(c);
  LensMap map(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d p = distort({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy}, c, largest);
      map(u, v) = {static_cast<float>(camera.fx * p.x() + camera.cx), static_cast<float>(camera.fy * p.y() + camera.cy)};
    }
  }
  return map;
}

Image<float> undistorted(const Image<float>& depth, const LensMap& map) {
  PANOPTIC_ASSERT(depth.same_size(map.width(), map.height()));
  Image<float> result(depth.width(), depth.height());
  for (std::size_t i = 0; i < map.size(); ++i) {
    const float x = map[i][0] + 0.5F;
    const float y = map[i][1] + 0.5F;
    const bool inside = x >= 0 && y >= 0 && x < static_cast<float>(depth.width()) && y < static_cast<float>(depth.height());
    if (inside) result[i] = depth(static_cast<int>(x), static_cast<int>(y));
  }
  return result;
}

Image<Rgb> undistorted(const Image<Rgb>& color, const LensMap& map) {
  PANOPTIC_ASSERT(color.same_size(map.width(), map.height()));
  Image<Rgb> result(color.width(), color.height());
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (!std::isnan(map[i][0])) result[i] = interpolated(color, map[i][0], map[i][1]);
  }
  return result;
}

}  // namespace panoptic
