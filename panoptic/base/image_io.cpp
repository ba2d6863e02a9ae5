// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/image_io.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/image_codecs.h"
#include "panoptic/base/image_header.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

// Nothing else reaches the codecs.
EncodedImage accepted(std::span<const std::uint8_t> bytes, std::string_view name) {
  if (bytes.size() > kMaxImageFileBytes || !is_acceptable_image(bytes, kMaxImagePixels)) {
    throw Error(fmt::format("{}: not a readable image of at most {} pixels; it may be cut off", name, kMaxImagePixels));
  }
  return {bytes, name};
}

std::span<const std::uint8_t> as_bytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

template <typename T>
PixelRows rows_of(const Image<T>& image, int channels) {
  return {image.data(), image.width(), image.height(), channels, static_cast<int>(8 * sizeof(T)) / channels};
}

std::vector<std::uint8_t> encoded(std::vector<std::uint8_t> bytes, std::string_view name, const char* format) {
  if (bytes.empty()) throw Error(fmt::format("{} cannot be encoded as {}", name, format));
  return bytes;
}

std::vector<std::uint8_t> encoded_png(const PixelRows& rows, const std::string& name = "an image") {
  return encoded(rows.width > 0 && rows.height > 0 ? png_from_rows(rows) : std::vector<std::uint8_t>(), name, "PNG");
}

}  // namespace

void refuse_damaged(const EncodedImage& file, std::string_view reason) {
  throw Error(fmt::format("{}: not a readable image ({}); it may be cut off", file.name, reason));
}

void refuse_kind(const EncodedImage& file, std::string_view kind) {
  throw Error(fmt::format("{}: not a readable image: {}; save it as grey or RGB of 8 bits", file.name, kind));
}

void refuse_channels(const EncodedImage& file, int channels, int bits) {
  throw Error(fmt::format("{}: expected one channel of 16 or 8 bits, found {} of {}", file.name, channels, bits));
}

void refuse_no_floats(const EncodedImage& file) {
  throw Error(fmt::format("{}: expected one channel of 32-bit floats", file.name));
}

Image<Rgb> decode_rgb(std::span<const std::uint8_t> bytes, std::string_view name) {
  const EncodedImage file = accepted(bytes, name);
  switch (image_format(bytes)) {
    case ImageFormat::kPng:
      return decode_png_rgb(file);
    case ImageFormat::kJpeg:
      return decode_jpeg_rgb(file);
    case ImageFormat::kTiff:
      return decode_tiff_rgb(file);
    default:
      return decode_pnm_rgb(file);
  }
}

Image<std::uint16_t> decode_gray16(std::span<const std::uint8_t> bytes, std::string_view name) {
  const EncodedImage file = accepted(bytes, name);
  switch (image_format(bytes)) {
    case ImageFormat::kPng:
      return decode_png_gray16(file);
    case ImageFormat::kJpeg:
      return decode_jpeg_gray16(file);
    case ImageFormat::kTiff:
      return decode_tiff_gray16(file);
    default:
      return decode_pnm_gray16(file);
  }
}

Image<Rgb> read_rgb(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kMaxImageFileBytes);
  return decode_rgb(as_bytes(bytes), path.string());
}

Image<std::uint16_t> read_gray16(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kMaxImageFileBytes);
  return decode_gray16(as_bytes(bytes), path.string());
}

Image<float> read_gray_float(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kMaxImageFileBytes);
  const std::string name = path.string();
  const EncodedImage file = accepted(as_bytes(bytes), name);
  if (image_format(file.bytes) != ImageFormat::kTiff) refuse_no_floats(file);
  return decode_tiff_float(file);
}

std::vector<std::uint8_t> encode_jpeg(const ImageView<Rgb>& image, int quality) {
  if (!image.is_dense()) return encode_jpeg(image.copied(), quality);
  const PixelRows rows{image.empty() ? nullptr : image.row(0), image.width(), image.height(), 3, 8};
  return encoded(jpeg_from_rows(rows, quality), "an image", "JPEG");
}

std::vector<std::uint8_t> encode_png(const Image<std::uint8_t>& image) { return encoded_png(rows_of(image, 1)); }

std::vector<std::uint8_t> encode_png(const Image<std::uint16_t>& image) { return encoded_png(rows_of(image, 1)); }

std::vector<std::uint8_t> encode_png(const Image<Rgb>& color, const Image<std::uint8_t>& alpha) {
  PANOPTIC_ASSERT(alpha.same_size(color.width(), color.height()));
  std::vector<std::uint8_t> rgba;
  rgba.reserve(4 * color.size());
  for (std::size_t i = 0; i < color.size(); ++i) rgba.insert(rgba.end(), {color[i].r, color[i].g, color[i].b, alpha[i]});
  return encoded_png({rgba.data(), color.width(), color.height(), 4, 8});
}

void write_png(const std::filesystem::path& path, const Image<Rgb>& image) {
  write_file(path, encoded_png(rows_of(image, 3), path.string() + ": the image"));
}

void write_png(const std::filesystem::path& path, const Image<std::uint16_t>& image) {
  write_file(path, encoded_png(rows_of(image, 1), path.string() + ": the image"));
}

}  // namespace panoptic
