// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/draw_text.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace panoptic {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr int kThickness_px = 1;

}  // namespace

TextSize text_size(const std::string& text, double scale) {
  int below = 0;
  const cv::Size size = cv::getTextSize(text, kFont, scale, kThickness_px, &below);
  return {size.width, size.height};
}

void draw_text(Image<Rgb>& image, const std::string& text, int u, int v, const Rgb& color, double scale) {
  static_assert(sizeof(Rgb) == 3, "an image of Rgb is drawn on in place");
  cv::Mat mat(image.height(), image.width(), CV_8UC3, image.data());
  cv::putText(mat, text, {u, v}, kFont, scale, cv::Scalar(color.r, color.g, color.b), kThickness_px, cv::LINE_AA);
}

void fill(Image<Rgb>& image, const PixelBox& box, const Rgb& color, double opacity) {
  const auto mix = [&](std::uint8_t below, std::uint8_t above) {
    return static_cast<std::uint8_t>(std::lround(below + opacity * (above - below)));
  };
  for (int v = std::max(box.v0, 0); v < std::min(box.v1, image.height()); ++v) {
    for (int u = std::max(box.u0, 0); u < std::min(box.u1, image.width()); ++u) {
      Rgb& pixel = image(u, v);
      pixel = {mix(pixel.r, color.r), mix(pixel.g, color.g), mix(pixel.b, color.b)};
    }
  }
}

}  // namespace panoptic
