// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Images: row-major, pixel (u, v) = column u, row v, (0, 0) top left. An Image owns its pixels, an ImageView reads those of
// another, and a SharedImage is what is passed on: pixels that nobody changes any more, owned or borrowed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
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

// Rows follow one another without padding.
template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T fill = T{}) : width_(width), height_(height), pixels_(count(width, height), fill) {}
  // REQUIRES width * height pixels.
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

// Throws Error unless rows of `length_bytes` can lie `row_bytes` apart there.
void check_pixels(const void* pixels, int rows, std::ptrdiff_t row_bytes, std::ptrdiff_t length_bytes, std::size_t alignment);

// Copying a view copies no pixels. Whoever makes one sees to it that the pixels stay, unchanged, for as long as it is used.
template <typename T>
class ImageView {
 public:
  ImageView() = default;
  ImageView(const Image<T>& image)  // NOLINT(google-explicit-constructor): every image can be read
      : ImageView(image.data(), image.width(), image.height()) {}
  ImageView(const T* pixels, int width, int height) : ImageView(pixels, width, height, std::ptrdiff_t{width} * kPixelBytes) {}
  // Rows begin `row_bytes` apart; below zero: the last row comes first in memory. Throws Error if `pixels` is null and the
  // image has a size, if rows would overlap, or if pixels would not be aligned.
  ImageView(const T* pixels, int width, int height, std::ptrdiff_t row_bytes)
      : pixels_(pixels), width_(width), height_(height), row_bytes_(height > 1 ? row_bytes : width * kPixelBytes) {
    check_pixels(pixels, height, row_bytes_, width * kPixelBytes, alignof(T));
  }

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t size() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_); }
  bool empty() const { return size() == 0; }
  bool same_size(int width, int height) const { return width_ == width && height_ == height; }
  std::ptrdiff_t row_bytes() const { return row_bytes_; }
  bool is_dense() const { return row_bytes_ == width_ * kPixelBytes; }  // as an Image is

  const T* row(int v) const {
    PANOPTIC_ASSERT(v >= 0 && v < height_);
    return reinterpret_cast<const T*>(reinterpret_cast<const char*>(pixels_) + v * row_bytes_);
  }
  const T& operator()(int u, int v) const {
    PANOPTIC_ASSERT(u >= 0 && u < width_);
    return row(v)[u];
  }
  const T& operator[](std::size_t i) const {
    const auto width = static_cast<std::size_t>(width_);
    return (*this)(static_cast<int>(i % width), static_cast<int>(i / width));
  }
  Image<T> copied() const {
    Image<T> copy(width_, height_);
    for (int v = 0; v < height_ && width_ > 0; ++v) std::copy_n(row(v), width_, copy.row(v));
    return copy;
  }

  friend bool operator==(const ImageView& a, const ImageView& b) {
    bool same = a.same_size(b.width_, b.height_);
    for (int v = 0; same && !a.empty() && v < a.height_; ++v) same = std::equal(a.row(v), a.row(v) + a.width_, b.row(v));
    return same;
  }

 private:
  static constexpr std::ptrdiff_t kPixelBytes = sizeof(T);

  const T* pixels_ = nullptr;
  int width_ = 0;
  int height_ = 0;
  std::ptrdiff_t row_bytes_ = 0;
};

// Copies share the pixels.
template <typename T>
class SharedImage : public ImageView<T> {
 public:
  SharedImage() = default;
  SharedImage(Image<T> image)  // NOLINT(google-explicit-constructor): it takes the image
      : ImageView<T>(image), owner_(std::make_shared<const Image<T>>(std::move(image))) {}
  // Borrows pixels. They must stay, unchanged, until `owner` is let go, which happens with the last copy of this. Without an
  // owner they must stay for as long as the function or class that takes the image says.
  explicit SharedImage(const ImageView<T>& pixels, std::shared_ptr<const void> owner = nullptr)
      : ImageView<T>(pixels), owner_(std::move(owner)) {}

  // The image, to be kept for any time: itself where it has an owner, else a copy.
  SharedImage kept() const { return owner_ != nullptr ? *this : SharedImage(this->copied()); }

 private:
  std::shared_ptr<const void> owner_;
};

}  // namespace panoptic
