// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The codecs behind image_io.cpp: each has one source and is named nowhere else. They take bytes that is_acceptable_image() let
// through and throw Error that starts with the file's name. Any thread; nothing is printed.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/base/depth_image.h"
#include "panoptic/image.h"

namespace panoptic {

constexpr std::size_t kMaxImagePixels = 64U << 20;
constexpr std::uintmax_t kMaxImageFileBytes = 256U << 20;

struct EncodedImage {
  std::span<const std::uint8_t> bytes;
  std::string_view name;  // for the error text
};

// Throws Error: the file is damaged, with what the codec says of it.
[[noreturn]] void refuse_damaged(const EncodedImage& file, std::string_view reason);
// Throw Error: the file is sound, but of a kind that is not read; not one channel of 16 or 8 bits; not one channel of floats.
[[noreturn]] void refuse_kind(const EncodedImage& file, std::string_view kind);
[[noreturn]] void refuse_channels(const EncodedImage& file, int channels, int bits);
[[noreturn]] void refuse_no_floats(const EncodedImage& file);
// Throws Error: the file is sound, but no depth image.
[[noreturn]] void refuse_depth(const EncodedImage& file, std::string_view kind);

// A reading of a wider type. Throws Error for one that does not fit; negative ones become 0.
template <typename Number>
std::uint16_t narrowed(const EncodedImage& file, Number value) {
  if (value <= 0) return 0;
  if (static_cast<std::uint64_t>(value) > 65535) refuse_depth(file, fmt::format("holds {}, which is above 65535", value));
  return static_cast<std::uint16_t>(value);
}

// Makes room for the pixels. Throws Error if they are too many: the size that a codec states is checked again.
template <typename T>
Image<T> image_for(const EncodedImage& file, std::uint64_t width, std::uint64_t height) {
  const bool fits = width > 0 && height > 0 && width <= kMaxImagePixels && height <= kMaxImagePixels / width;
  if (!fits) refuse_damaged(file, "its size is out of range");
  return Image<T>(static_cast<int>(width), static_cast<int>(height));
}

// The same values in 16 bits.
inline Image<std::uint16_t> widened(const Image<std::uint8_t>& image) {
  Image<std::uint16_t> wide(image.width(), image.height());
  std::copy_n(image.data(), image.size(), wide.data());
  return wide;
}

Image<Rgb> decode_png_rgb(const EncodedImage& file);
Image<std::uint16_t> decode_png_gray16(const EncodedImage& file);
Image<Rgb> decode_jpeg_rgb(const EncodedImage& file);
Image<std::uint16_t> decode_jpeg_gray16(const EncodedImage& file);
Image<Rgb> decode_tiff_rgb(const EncodedImage& file);
Image<std::uint16_t> decode_tiff_gray16(const EncodedImage& file);
Image<float> decode_tiff_float(const EncodedImage& file);
DepthImage decode_tiff_depth(const EncodedImage& file);
DepthImage decode_npy(const EncodedImage& file);  // these two check all sizes themselves
DepthImage decode_exr(const EncodedImage& file);
Image<Rgb> decode_pnm_rgb(const EncodedImage& file);
Image<std::uint16_t> decode_pnm_gray16(const EncodedImage& file);

// Rows from the top without padding, channels side by side, 16 bits in the machine's byte order. Grey, RGB or RGBA.
struct PixelRows {
  const void* data = nullptr;
  int width = 0;
  int height = 0;
  int channels = 1;
  int bits = 8;  // of a channel: 8 or 16
};

// Both return no bytes if there are no pixels or the codec fails.
std::vector<std::uint8_t> png_from_rows(const PixelRows& rows);
std::vector<std::uint8_t> jpeg_from_rows(const PixelRows& rgb, int quality);

// The next number of a PGM or PPM, after spaces and comments; moves `at` behind it.
std::optional<std::uint32_t> next_pnm_number(std::span<const std::uint8_t> bytes, std::size_t& at);

}  // namespace panoptic
