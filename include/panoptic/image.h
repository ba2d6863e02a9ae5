// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A plain image: row-major, no padding, pixel (u, v) = column u, row v, (0, 0) top left.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "panoptic/error.h"

namespace panoptic {

struct Rgb {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;

  bool operator==(const Rgb&) const = default;
};

template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T fill = T{}) : width_(width), height_(height), pixels_(count(width, height), fill) {}
  Image(int width, int height, std::vector<T> pixels) : width_(width), height_(height), pixels_(std::move(pixels)) {
    PANOPTIC_ASSERT(pixels_.size() == count(width, height));
  }

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t size() const { return pixels_.size(); }
  bool empty() const { return pixels_.empty(); }
  bool same_size(int width, int height) const { return width_ == width && height_ == height; }

  T& operator()(int u, int v) { return pixels_[index(u, v)]; }
  const T& operator()(int u, int v) const { return pixels_[index(u, v)]; }
  T& operator[](std::size_t i) { return pixels_[i]; }
  const T& operator[](std::size_t i) const { return pixels_[i]; }
  T* row(int v) { return pixels_.data() + index(0, v); }
  const T* row(int v) const { return pixels_.data() + index(0, v); }
  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  std::span<const T> pixels() const { return pixels_; }

  bool operator==(const Image&) const = default;

 private:
  static std::size_t count(int width, int height) { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  std::size_t index(int u, int v) const {
    PANOPTIC_ASSERT(u >= 0 && u < width_ && v >= 0 && v < height_);
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
  }

  int width_ = 0;
  int height_ = 0;
  std::vector<T> pixels_;
};

}  // namespace panoptic
