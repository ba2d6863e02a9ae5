// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// NumPy arrays, as https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html describes them: magic, version, length
// of the header, a Python dictionary with 'descr', 'fortran_order' and 'shape', the numbers.
#include <fmt/format.h>

#include <Eigen/Core>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>

#include "panoptic/base/image_codecs.h"

namespace panoptic {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie in memory");

// The header's dictionary and where the numbers begin.
struct NpyText {
  std::string_view header;
  std::size_t data_at = 0;
};

NpyText npy_text(const EncodedImage& file) {
  constexpr std::size_t kVersionAt = 6;
  constexpr std::size_t kLengthAt = 8;
  if (file.bytes.size() < kLengthAt + 4) refuse_damaged(file, "its header is cut off");
  const bool is_long = file.bytes[kVersionAt] >= 2;
  const std::size_t length_bytes = is_long ? 4 : 2;
  std::size_t length = 0;
  for (std::size_t i = length_bytes; i > 0; --i) length = length << 8U | file.bytes[kLengthAt + i - 1];
  const std::size_t data_at = kLengthAt + length_bytes + length;
  if (data_at > file.bytes.size()) refuse_damaged(file, "its header is cut off");
  const auto* text = reinterpret_cast<const char*>(file.bytes.data()) + kLengthAt + length_bytes;
  return {{text, length}, data_at};
}

// The text behind "'key':" in the dictionary.
std::string_view npy_value(const EncodedImage& file, std::string_view header, std::string_view key) {
  const std::string quoted = fmt::format("'{}'", key);
  const std::size_t at = header.find(quoted);
  const std::size_t colon = at == std::string_view::npos ? at : header.find(':', at);
  const std::size_t begin = colon == std::string_view::npos ? colon : header.find_first_not_of(": ", colon);
  if (begin == std::string_view::npos) refuse_damaged(file, fmt::format("its header has no {}", quoted));
  return header.substr(begin);
}

// Width and height of two dimensions, besides such of length 1.
std::array<std::uint64_t, 2> npy_shape(const EncodedImage& file, std::string_view text) {
  std::vector<std::uint64_t> sides;
  const std::string_view inside = text.substr(0, text.find(')'));
  for (std::size_t at = inside.find_first_of("0123456789"); at != std::string_view::npos;) {
    std::uint64_t side = 0;
    const auto [end, error] = std::from_chars(inside.data() + at, inside.data() + inside.size(), side);
    if (error != std::errc{}) refuse_damaged(file, "its size is out of range");
    if (side != 1) sides.push_back(side);
    at = inside.find_first_of("0123456789", static_cast<std::size_t>(end - inside.data()));
  }
  if (sides.size() != 2) refuse_depth(file, fmt::format("an array of {} dimensions", sides.size()));
  return {sides[1], sides[0]};
}

template <typename Stored>
Stored npy_number(const std::uint8_t* at, bool swapped) {
  std::array<std::uint8_t, sizeof(Stored)> bytes{};
  std::memcpy(bytes.data(), at, bytes.size());
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<Stored>(bytes);
}

struct NpyLayout {
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  std::size_t data_at = 0;
  bool by_columns = false;
  bool swapped = false;  // big-endian
};

template <typename Stored, typename Value, typename Convert>
DepthImage npy_image(const EncodedImage& file, const NpyLayout& layout, const Convert& convert) {
  const std::size_t present = (file.bytes.size() - layout.data_at) / sizeof(Stored);
  auto image = image_for<Value>(file, layout.width, layout.height);
  if (present < image.size()) refuse_damaged(file, fmt::format("{} numbers of {}", present, image.size()));
  const std::uint8_t* data = file.bytes.data() + layout.data_at;
  for (std::size_t i = 0; i < image.size(); ++i) {
    const std::size_t at = layout.by_columns ? (i % layout.width) * layout.height + i / layout.width : i;
    image[i] = convert(npy_number<Stored>(data + at * sizeof(Stored), layout.swapped));
  }
  return image;
}

template <typename Stored>
DepthImage npy_whole(const EncodedImage& file, const NpyLayout& layout) {
  return npy_image<Stored, std::uint16_t>(file, layout, [&](Stored value) { return narrowed(file, value); });
}

template <typename Stored>
DepthImage npy_float(const EncodedImage& file, const NpyLayout& layout) {
  return npy_image<Stored, float>(file, layout, [](Stored value) { return static_cast<float>(value); });
}

}  // namespace

DepthImage decode_npy(const EncodedImage& file) {
  const NpyText text = npy_text(file);
  const std::string_view type = npy_value(file, text.header, "descr").substr(0, 5);  // '<f4'
  const auto [width, height] = npy_shape(file, npy_value(file, text.header, "shape"));
  const bool by_columns = npy_value(file, text.header, "fortran_order").starts_with("True");
  if (width > kMaxImagePixels || height > kMaxImagePixels || width * height > file.bytes.size())
    refuse_damaged(file, fmt::format("it is said to hold {} x {} numbers", width, height));
  const NpyLayout layout{width, height, text.data_at, by_columns, type.size() > 1 && type[1] == '>'};
  const std::string_view kind = type.size() == 5 ? type.substr(2, 2) : "";
  if (kind == "f4") return npy_float<float>(file, layout);
  if (kind == "f8") return npy_float<double>(file, layout);
  if (kind == "f2")
    return npy_image<std::uint16_t, float>(
        file, layout, [](std::uint16_t bits) { return static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(bits)); });
  if (kind == "u2") return npy_whole<std::uint16_t>(file, layout);
  if (kind == "i2") return npy_whole<std::int16_t>(file, layout);
  if (kind == "u4") return npy_whole<std::uint32_t>(file, layout);
  if (kind == "i4") return npy_whole<std::int32_t>(file, layout);
  if (kind == "u8") return npy_whole<std::uint64_t>(file, layout);
  if (kind == "i8") return npy_whole<std::int64_t>(file, layout);
  refuse_depth(file, fmt::format("an array of type {}", type.substr(0, type.find(','))));
}

}  // namespace panoptic
