// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "panoptic/base/image_codecs.h"

namespace panoptic {
namespace {

struct Pnm {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t largest = 0;  // the sample that stands for white
  int channels = 1;
  bool is_text = false;
  std::span<const std::uint8_t> samples;
};

Pnm read_pnm_header(const EncodedImage& file) {
  const char kind = static_cast<char>(file.bytes[1]);
  std::size_t at = 2;
  const auto width = next_pnm_number(file.bytes, at);
  const auto height = next_pnm_number(file.bytes, at);
  const auto largest = next_pnm_number(file.bytes, at);
  if (!width || !height || !largest || *largest == 0 || *largest > 65535 || at == file.bytes.size()) {
    refuse_damaged(file, "its header is damaged");
  }
  return {*width, *height, *largest, kind == '3' || kind == '6' ? 3 : 1, kind == '2' || kind == '3', file.bytes.subspan(at + 1)};
}

// Calls take(sample) for each, row by row, colours side by side.
template <typename Take>
void read_samples(const EncodedImage& file, const Pnm& pnm, std::size_t count, const Take& take) {
  std::size_t at = 0;
  const bool is_wide = pnm.largest > 255;
  for (std::size_t i = 0; i < count; ++i) {
    if (pnm.is_text) {
      const auto number = next_pnm_number(pnm.samples, at);
      if (!number) refuse_damaged(file, "its samples are cut off or no numbers");
      take(std::min(*number, pnm.largest));
    } else {
      take(is_wide ? pnm.samples[2 * i] * 256U + pnm.samples[2 * i + 1] : pnm.samples[i]);
    }
  }
}

// Memory is taken only if the samples can be there: in text a digit each and what parts them.
template <typename T>
Image<T> image_for_samples(const EncodedImage& file, const Pnm& pnm) {
  const std::uint64_t count = std::uint64_t{pnm.width} * pnm.height * static_cast<std::uint64_t>(pnm.channels);
  const std::uint64_t least = pnm.is_text ? 2 * count - 1 : count * (pnm.largest > 255 ? 2 : 1);
  if (least > pnm.samples.size()) refuse_damaged(file, "it is shorter than its header says");
  return image_for<T>(file, pnm.width, pnm.height);
}

}  // namespace

std::optional<std::uint32_t> next_pnm_number(std::span<const std::uint8_t> bytes, std::size_t& at) {
  constexpr std::size_t kMaxDigits = 9;
  constexpr std::string_view kSpaces = " \t\r\n\v\f";
  const auto is_space = [&](std::uint8_t b) { return kSpaces.find(static_cast<char>(b)) != std::string_view::npos; };
  while (at < bytes.size() && (is_space(bytes[at]) || bytes[at] == '#')) {
    if (bytes[at] == '#') {
      while (at < bytes.size() && bytes[at] != '\n') ++at;
    } else {
      ++at;
    }
  }
  std::uint32_t value = 0;
  std::size_t digits = 0;
  for (; at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9'; ++at, ++digits) {
    if (digits == kMaxDigits) return std::nullopt;
    value = value * 10 + (bytes[at] - std::uint32_t{'0'});
  }
  return digits > 0 ? std::optional(value) : std::nullopt;
}

// Samples of 16 bits keep their upper 8. Text of fewer than 8 bits is stretched to 8; bytes stand for themselves.
Image<Rgb> decode_pnm_rgb(const EncodedImage& file) {
  const Pnm pnm = read_pnm_header(file);
  auto image = image_for_samples<Rgb>(file, pnm);
  auto* out = reinterpret_cast<std::uint8_t*>(image.data());
  const int copies = pnm.channels == 1 ? 3 : 1;
  const bool is_stretched = pnm.is_text && pnm.largest < 255;
  read_samples(file, pnm, image.size() * static_cast<std::size_t>(pnm.channels), [&](std::uint32_t sample) {
    if (pnm.largest > 255) sample >>= 8U;
    if (is_stretched) sample = sample * 255 / pnm.largest;
    out = std::fill_n(out, copies, static_cast<std::uint8_t>(sample));
  });
  return image;
}

Image<std::uint16_t> decode_pnm_gray16(const EncodedImage& file) {
  const Pnm pnm = read_pnm_header(file);
  if (pnm.channels != 1) refuse_channels(file, pnm.channels, pnm.largest > 255 ? 16 : 8);
  auto image = image_for_samples<std::uint16_t>(file, pnm);
  std::uint16_t* out = image.data();
  read_samples(file, pnm, image.size(), [&](std::uint32_t sample) { *out++ = static_cast<std::uint16_t>(sample); });
  return image;
}

}  // namespace panoptic
