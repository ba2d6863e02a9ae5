// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/textures.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "panoptic/base/floor.h"

namespace panoptic {
namespace {

float linear_from_srgb(float s) { return s <= 0.04045F ? s / 12.92F : std::pow((s + 0.055F) / 1.055F, 2.4F); }
float srgb_from_linear(float l) { return l <= 0.0031308F ? l * 12.92F : 1.055F * std::pow(l, 1 / 2.4F) - 0.055F; }

const std::array<float, 256>& linear_table() {
  static const std::array<float, 256> kTable = [] {
    std::array<float, 256> table{};
    for (int i = 0; i < 256; ++i) table[i] = linear_from_srgb(static_cast<float>(i) / 255);
    return table;
  }();
  return kTable;
}

std::uint8_t byte_of_linear(float l) {
  return static_cast<std::uint8_t>(std::clamp(srgb_from_linear(l) * 255 + 0.5F, 0.0F, 255.0F));
}

// Close to linear in the dark and ever flatter towards white, which `kWhite` reaches.
constexpr float kWhite = 4;
float film(float l) { return std::min(1.0F, l * (1 + l / (kWhite * kWhite)) / (1 + 0.6F * l)); }

// Steps of the table are equal in the square root of light, where a step is about as visible everywhere.
constexpr int kToneSteps = 2048;
const std::array<std::uint8_t, kToneSteps + 1>& tone_table() {
  static const std::array<std::uint8_t, kToneSteps + 1> kTable = [] {
    std::array<std::uint8_t, kToneSteps + 1> table{};
    for (int i = 0; i <= kToneSteps; ++i) {
      const float root = 2 * static_cast<float>(i) / kToneSteps;
      table[i] = byte_of_linear(film(root * root));
    }
    return table;
  }();
  return kTable;
}

// Averages of 2x2 pixels (or 2x1, 1x2 at the thin end), in linear light.
Image<Rgb> halved(const Image<Rgb>& image) {
  Image<Rgb> half(std::max(1, image.width() / 2), std::max(1, image.height() / 2));
  for (int v = 0; v < half.height(); ++v) {
    for (int u = 0; u < half.width(); ++u) {
      const int u1 = std::min(2 * u + 1, image.width() - 1);
      const int v1 = std::min(2 * v + 1, image.height() - 1);
      const Vec3f sum = linear_from_srgb(image(2 * u, 2 * v)) + linear_from_srgb(image(u1, 2 * v)) +
                        linear_from_srgb(image(2 * u, v1)) + linear_from_srgb(image(u1, v1));
      half(u, v) = {byte_of_linear(sum.x() / 4), byte_of_linear(sum.y() / 4), byte_of_linear(sum.z() / 4)};
    }
  }
  return half;
}

// The place of texel coordinate x between two columns of a repeating image.
struct Between {
  int low;
  int high;
  float to_high;
};
Between between(float x, int size) {
  const float wrapped = (x - static_cast<float>(floor_to_int(x))) * static_cast<float>(size) - 0.5F;
  const int low = floor_to_int(wrapped);
  return {low < 0 ? size - 1 : low, low + 1 >= size ? 0 : low + 1, wrapped - static_cast<float>(low)};
}

}  // namespace

Vec3f linear_from_srgb(const Rgb& color) {
  const auto& table = linear_table();
  return {table[color.r], table[color.g], table[color.b]};
}

Rgb tone_mapped(const Vec3f& light) {
  const auto& table = tone_table();
  const auto byte = [&](float l) {
    const float rounding_step = std::sqrt(std::clamp(l, 0.0F, 4.0F)) * (kToneSteps / 2.0F) + 0.5F;
    return table[static_cast<std::size_t>(rounding_step)];
  };
  return {byte(light.x()), byte(light.y()), byte(light.z())};
}

Texture::Texture(const Image<Rgb>& image) : levels_{image} {
  while (levels_.back().size() > 1) levels_.push_back(halved(levels_.back()));
  mean_ = linear_from_srgb(levels_.back()[0]);
}

Vec3f Texture::sample(const Eigen::Vector2f& uv, float footprint) const {
  PANOPTIC_ASSERT(uv.cwiseAbs().maxCoeff() < 1e9F);
  const auto texels = static_cast<std::uint32_t>(std::clamp(footprint, 1.0F, 32768.0F));
  const auto level = std::min<std::size_t>(std::bit_width(texels) - 1, levels_.size() - 1);
  const Image<Rgb>& image = levels_[level];
  const Between u = between(uv.x(), image.width());
  const Between v = between(-uv.y(), image.height());
  const Rgb* high_row = image.row(v.high);
  const Rgb* low_row = image.row(v.low);
  const std::array<float, 256>& linear = linear_table();
  const auto mix = [&](auto channel) {
    const float low = (1 - u.to_high) * linear[low_row[u.low].*channel] + u.to_high * linear[low_row[u.high].*channel];
    const float high = (1 - u.to_high) * linear[high_row[u.low].*channel] + u.to_high * linear[high_row[u.high].*channel];
    return (1 - v.to_high) * low + v.to_high * high;
  };
  return {mix(&Rgb::r), mix(&Rgb::g), mix(&Rgb::b)};
}

}  // namespace panoptic
