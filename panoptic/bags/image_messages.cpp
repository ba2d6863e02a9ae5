// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/bags/image_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "panoptic/base/bytes.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/text.h"

namespace panoptic {
namespace {

struct ColorLayout {
  std::string_view encoding;
  int channels = 0;
  std::array<int, 3> rgb{};  // where red, green and blue are
};

constexpr std::array<ColorLayout, 8> kColorLayouts = {{{"rgb8", 3, {0, 1, 2}},
                                                       {"bgr8", 3, {2, 1, 0}},
                                                       {"rgba8", 4, {0, 1, 2}},
                                                       {"bgra8", 4, {2, 1, 0}},
                                                       {"8UC3", 3, {2, 1, 0}},
                                                       {"8UC4", 4, {2, 1, 0}},
                                                       {"mono8", 1, {0, 0, 0}},
                                                       {"8UC1", 1, {0, 0, 0}}}};

const ColorLayout* layout_of(std::string_view encoding) {
  const auto found =
      std::find_if(kColorLayouts.begin(), kColorLayouts.end(), [&](const auto& l) { return l.encoding == encoding; });
  return found == kColorLayouts.end() ? nullptr : &*found;
}

// Checks the claimed size against the bytes that are there, before memory is taken.
void require_pixels(const ImageMessage& image, std::size_t pixel_bytes) {
  constexpr std::uint32_t kMostSide_px = 1 << 16;
  const bool has_size = image.width > 0 && image.height > 0 && image.width <= kMostSide_px && image.height <= kMostSide_px;
  const std::uint64_t row_bytes = std::uint64_t{image.width} * pixel_bytes;
  if (has_size && image.row_bytes >= row_bytes &&
      std::uint64_t{image.row_bytes} * (image.height - 1) + row_bytes <= image.data.size())
    return;
  throw MessageError(fmt::format("an image of {}x{} pixels, {} bytes a row, does not fit its {} bytes", image.width, image.height,
                                 image.row_bytes, image.data.size()));
}

template <typename T>
Image<T> pixels_of(const ImageMessage& image) {
  require_pixels(image, sizeof(T));
  Image<T> pixels(static_cast<int>(image.width), static_cast<int>(image.height));
  for (int v = 0; v < pixels.height(); ++v) {
    std::memcpy(pixels.row(v), image.data.data() + std::size_t{image.row_bytes} * static_cast<std::size_t>(v),
                image.width * sizeof(T));
  }
  if (image.is_big_endian == (std::endian::native == std::endian::big)) return pixels;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    auto raw = std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(pixels[i]);
    std::reverse(raw.begin(), raw.end());
    pixels[i] = std::bit_cast<T>(raw);
  }
  return pixels;
}

bool contains(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

constexpr std::string_view kCompressedDepth = "compressedDepth";

// Metres that were stored as whole numbers: the nearer, the finer.
Image<float> metres_of(const Image<std::uint16_t>& stored, float a, float b) {
  Image<float> metres(stored.width(), stored.height());
  for (std::size_t i = 0; i < stored.size(); ++i) metres[i] = stored[i] == 0 ? 0.0F : a / (static_cast<float>(stored[i]) - b);
  return metres;
}

}  // namespace

ImageKind kind_of_encoding(std::string_view encoding, std::string_view topic) {
  if (encoding == "16UC1" || encoding == "32FC1") return ImageKind::kDepth;
  if (encoding == "mono16") return contains(lower_case(topic), "depth") ? ImageKind::kDepth : ImageKind::kUnknown;
  const ColorLayout* layout = layout_of(encoding);
  if (layout == nullptr) return ImageKind::kUnknown;
  return layout->channels == 1 ? ImageKind::kGrey : ImageKind::kColor;
}

ImageKind kind_of_format(std::string_view format, std::string_view topic) {
  if (contains(format, kCompressedDepth) || topic.ends_with(kCompressedDepth)) return ImageKind::kDepth;
  const std::string_view encoding = format.substr(0, format.find(';'));
  if (encoding != format) return kind_of_encoding(encoding, topic);
  return contains(lower_case(topic), "depth") ? ImageKind::kDepth : ImageKind::kColor;
}

DepthImage depth_of(const ImageMessage& image) {
  if (image.encoding == "16UC1" || image.encoding == "mono16") return pixels_of<std::uint16_t>(image);
  if (image.encoding == "32FC1") return pixels_of<float>(image);
  throw MessageError(fmt::format("depth of encoding '{}' cannot be read (16UC1, mono16 and 32FC1 can)", image.encoding));
}

DepthImage depth_of(const CompressedImageMessage& image) {
  constexpr std::size_t kHeadBytes = 12;
  if (!contains(image.format, kCompressedDepth)) return decode_depth_image(image.data, image.format);
  if (contains(image.format, "rvl"))
    throw MessageError(fmt::format("depth of format '{}' cannot be read: record it as png", image.format));
  if (image.data.size() < kHeadBytes) throw MessageError("compressed depth without its head");
  const Image<std::uint16_t> stored = decode_gray16(image.data.subspan(kHeadBytes), image.format);
  const std::string_view encoding = std::string_view(image.format).substr(0, image.format.find(';'));
  if (encoding == "16UC1" || encoding == "mono16") return stored;
  if (encoding != "32FC1") throw MessageError(fmt::format("depth of format '{}' cannot be read", image.format));
  ByteReader head(image.data.subspan(sizeof(std::uint32_t)));
  const auto a = head.take<float>();
  return metres_of(stored, a, head.take<float>());
}

Image<Rgb> color_of(const ImageMessage& image) {
  const ColorLayout* layout = layout_of(image.encoding);
  if (layout == nullptr) {
    throw MessageError(fmt::format(
        "colour of encoding '{}' cannot be read (rgb8, bgr8, rgba8, bgra8, 8UC3, 8UC4, mono8 and 8UC1 can)", image.encoding));
  }
  const auto channels = static_cast<std::size_t>(layout->channels);
  require_pixels(image, channels);
  Image<Rgb> color(static_cast<int>(image.width), static_cast<int>(image.height));
  for (int v = 0; v < color.height(); ++v) {
    const std::uint8_t* from = image.data.data() + std::size_t{image.row_bytes} * static_cast<std::size_t>(v);
    Rgb* to = color.row(v);
    for (std::uint32_t u = 0; u < image.width; ++u, from += channels) {
      to[u] = {from[layout->rgb[0]], from[layout->rgb[1]], from[layout->rgb[2]]};
    }
  }
  return color;
}

Image<Rgb> color_of(const CompressedImageMessage& image) { return decode_rgb(image.data, image.format); }

}  // namespace panoptic
