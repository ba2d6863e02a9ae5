// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/preprocess.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

namespace panoptic {
namespace {

struct Size {
  int width = 0;
  int height = 0;
};

// The size that the image is resized to before it is put into the input.
Size resized_size(int image_width, int image_height, const InputFormat& format) {
  if (format.resize == "stretch") return {format.width, format.height};
  const double ratio =
      std::min(static_cast<double>(format.width) / image_width, static_cast<double>(format.height) / image_height);
  const auto scaled = [&](int length, int limit) { return std::clamp(static_cast<int>(std::lround(length * ratio)), 1, limit); };
  return {scaled(image_width, format.width), scaled(image_height, format.height)};
}

// The 256 values that a channel can take.
std::array<float, 256> normalized(const InputFormat& format, std::size_t channel) {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<float>((static_cast<double>(i) * format.scale - format.mean[channel]) / format.std[channel]);
  }
  return table;
}

// OpenCV reads the pixels where they lie, unless the last row comes first.
cv::Mat mat_of(const ImageView<Rgb>& image) {
  const bool is_upright = image.row_bytes() > 0;
  auto* pixels = const_cast<Rgb*>(image.row(is_upright ? 0 : image.height() - 1));
  cv::Mat mat(image.height(), image.width(), CV_8UC3, pixels, static_cast<std::size_t>(std::abs(image.row_bytes())));
  if (is_upright) return mat;
  cv::Mat upright;  // of its own: the pixels are another's
  cv::flip(mat, upright, 0);
  return upright;
}

}  // namespace

Placement place(int image_width, int image_height, const InputFormat& format) {
  const Size size = resized_size(image_width, image_height, format);
  return {image_width,
          image_height,
          format.width,
          format.height,
          static_cast<double>(size.width) / image_width,
          static_cast<double>(size.height) / image_height};
}

Tensor to_input(const ImageView<Rgb>& image, const InputFormat& format) {
  const Size size = resized_size(image.width(), image.height(), format);
  const cv::Mat full = mat_of(image);
  cv::Mat small = full;
  if (!image.same_size(size.width, size.height)) cv::resize(full, small, {size.width, size.height}, 0, 0, cv::INTER_LINEAR);

  Tensor tensor{{1, 3, format.height, format.width}, {}};
  const auto plane = static_cast<std::size_t>(format.width) * static_cast<std::size_t>(format.height);
  tensor.values.resize(3 * plane);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const std::array<float, 256> table = normalized(format, channel);
    const std::size_t source = format.channels == "rgb" ? channel : 2 - channel;
    float* out = tensor.values.data() + channel * plane;
    std::fill_n(out, plane, table[static_cast<std::size_t>(format.pad_value)]);
    for (int v = 0; v < size.height; ++v, out += format.width) {
      const std::uint8_t* in = small.ptr(v) + source;
      for (int u = 0; u < size.width; ++u) out[u] = table[in[3 * u]];
    }
  }
  return tensor;
}

}  // namespace panoptic
