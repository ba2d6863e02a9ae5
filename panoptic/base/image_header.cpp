// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/image_header.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "panoptic/base/image_codecs.h"

namespace panoptic {
namespace {

using Bytes = std::span<const std::uint8_t>;

std::uint32_t big_endian(Bytes bytes) {
  std::uint32_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8U | byte;
  return value;
}

std::uint32_t little_endian(Bytes bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = bytes.size(); i > 0; --i) value = value << 8U | bytes[i - 1];
  return value;
}

bool starts_with(Bytes bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin(),
                                                    [](char m, std::uint8_t b) { return static_cast<std::uint8_t>(m) == b; });
}

// Both sides are below 2^32, so the product cannot overflow.
bool fits(std::uint64_t width, std::uint64_t height, std::size_t max_pixels) {
  return width > 0 && height > 0 && width * height <= max_pixels;
}

constexpr std::uint64_t kDeflateRatio = 1032;  // 258 bytes from two bits

// Could the picture's bits come from a file of so many bytes? REQUIRES sides that fit some sane limit.
bool could_hold(std::size_t file_bytes, std::uint64_t pixels, std::uint64_t bits_per_pixel, std::uint64_t ratio) {
  return pixels * bits_per_pixel <= std::uint64_t{file_bytes} * 8 * ratio;
}

bool acceptable_png(Bytes bytes, std::size_t max_pixels) {
  constexpr std::size_t kHeaderBytes = 26;  // signature, chunk length and type, width, height, depth, kind of colour
  constexpr std::array<std::uint64_t, 7> kChannels = {1, 0, 3, 1, 2, 0, 4};
  if (bytes.size() < kHeaderBytes) return false;
  const std::uint64_t width = big_endian(bytes.subspan(16, 4));
  const std::uint64_t height = big_endian(bytes.subspan(20, 4));
  const std::size_t kind = bytes[25];
  if (!fits(width, height, max_pixels) || kind >= kChannels.size() || kChannels.at(kind) == 0) return false;
  return could_hold(bytes.size(), width * height, bytes[24] * kChannels.at(kind), kDeflateRatio);
}

// True if the picture's data has an end and no more scans than any encoder writes: a scan of a few bytes makes the decoder go
// through the whole picture again.
bool acceptable_scans(Bytes scans) {
  constexpr std::uint8_t kScan = 0xDA;
  constexpr std::uint8_t kEnd = 0xD9;
  constexpr int kMostScans = 100;
  int count = 0;
  for (std::size_t i = 0; i + 1 < scans.size(); ++i) {
    if (scans[i] != 0xFF) continue;
    if (scans[i + 1] == kEnd) return true;
    if (scans[i + 1] == kScan && ++count > kMostScans) return false;
  }
  return false;
}

// Walks the segments of a JPEG. The end marker must be there, which cannot occur within the picture's data: what is left of a
// truncated file is not to be taken for a picture.
bool acceptable_jpeg(Bytes bytes, std::size_t max_pixels) {
  constexpr std::uint8_t kScan = 0xDA;
  constexpr std::uint64_t kMostPixelsPerByte = 1024;  // a bit for each of 8 blocks, which may stand for 32 x 32 pixels
  for (std::size_t at = 2; at + 9 < bytes.size();) {
    const std::uint8_t marker = bytes[at + 1];
    if (bytes[at] != 0xFF) return false;
    if (marker == 0xFF) {  // padding
      ++at;
      continue;
    }
    if (marker == kScan) return acceptable_scans(bytes.subspan(at));
    const bool is_frame_header = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    const Bytes sizes = bytes.subspan(at + 5, 4);
    if (is_frame_header) {
      const std::uint64_t limit = std::min<std::uint64_t>(max_pixels, bytes.size() * kMostPixelsPerByte);
      if (!fits(big_endian(sizes.subspan(2)), big_endian(sizes.first(2)), limit)) return false;
    }
    at += 2 + big_endian(bytes.subspan(at + 2, 2));
  }
  return false;
}

bool acceptable_pnm(Bytes bytes, std::size_t max_pixels) {
  std::size_t at = 2;
  const auto width = next_pnm_number(bytes, at);
  const auto height = next_pnm_number(bytes, at);
  return width && height && fits(*width, *height, std::min(max_pixels, bytes.size()));  // a byte per pixel or more
}

// How many bytes of a TIFF's pixels one byte of the file can stand for, at most; 0 for compressions that nobody uses for images
// of numbers.
std::uint64_t tiff_ratio(std::uint32_t compression) {
  constexpr std::uint64_t kLzwRatio = 2560;  // strings of up to 3838 bytes from 12 bits
  constexpr std::uint64_t kPackBitsRatio = 64;
  switch (compression) {
    case 1:
      return 1;
    case 5:
      return kLzwRatio;
    case 8:
    case 32946:
      return kDeflateRatio;
    case 32773:
      return kPackBitsRatio;
    default:
      return 0;
  }
}

// The first directory of a TIFF: codecs read no other.
bool acceptable_tiff(Bytes bytes, std::size_t max_pixels) {
  constexpr std::size_t kEntryBytes = 12;
  constexpr std::uint32_t kShort = 3;
  constexpr std::uint32_t kLong = 4;
  // Width and height of the image, then of a tile; compression.
  constexpr std::array<std::uint32_t, 5> kTags = {256, 257, 322, 323, 259};
  const auto number = bytes[0] == 'I' ? little_endian : big_endian;
  if (bytes.size() < 8) return false;
  const std::size_t directory = number(bytes.subspan(4, 4));
  if (directory + 2 > bytes.size()) return false;
  const std::size_t entries = number(bytes.subspan(directory, 2));
  if (directory + 2 + entries * kEntryBytes > bytes.size()) return false;
  std::array<std::optional<std::uint32_t>, kTags.size()> sizes;
  for (std::size_t i = 0; i < entries; ++i) {
    const Bytes entry = bytes.subspan(directory + 2 + i * kEntryBytes, kEntryBytes);
    const auto tag = std::find(kTags.begin(), kTags.end(), number(entry.first(2)));
    if (tag == kTags.end()) continue;
    auto& size = sizes.at(static_cast<std::size_t>(tag - kTags.begin()));
    const std::uint32_t type = number(entry.subspan(2, 2));
    if (size || (type != kShort && type != kLong) || number(entry.subspan(4, 4)) != 1) return false;
    size = number(entry.subspan(8, type == kShort ? 2 : 4));
  }
  const bool tile_fits = fits(sizes[2].value_or(1), sizes[3].value_or(1), max_pixels);
  if (!sizes[0] || !sizes[1] || !tile_fits || !fits(*sizes[0], *sizes[1], max_pixels)) return false;
  constexpr std::uint64_t kLeastBits = 8;  // of a pixel: what a file of 32 bits cannot hold, one of 8 may
  return could_hold(bytes.size(), std::uint64_t{*sizes[0]} * *sizes[1], kLeastBits, tiff_ratio(sizes[4].value_or(1)));
}

}  // namespace

ImageFormat image_format(std::span<const std::uint8_t> bytes) {
  using std::string_view_literals::operator""sv;
  if (starts_with(bytes, "\x89PNG")) return ImageFormat::kPng;
  if (starts_with(bytes, "\xFF\xD8")) return ImageFormat::kJpeg;
  if (starts_with(bytes, "II*\0"sv) || starts_with(bytes, "MM\0*"sv)) return ImageFormat::kTiff;
  if (starts_with(bytes, "\x93NUMPY")) return ImageFormat::kNpy;
  if (starts_with(bytes, "\x76\x2F\x31\x01")) return ImageFormat::kExr;
  const auto is_pnm = [&](std::string_view magic) { return starts_with(bytes, magic); };
  constexpr std::array<std::string_view, 4> kPnm = {"P2", "P3", "P5", "P6"};
  return std::any_of(kPnm.begin(), kPnm.end(), is_pnm) ? ImageFormat::kPnm : ImageFormat::kOther;
}

SampleKind sample_kind(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kBitsAt = 24;  // in a PNG, and after them the kind of colour
  constexpr std::array<int, 7> kPngChannels = {1, 0, 3, 3, 2, 0, 4};
  const ImageFormat format = image_format(bytes);
  if (format == ImageFormat::kPng && bytes.size() > kBitsAt + 1 && bytes[kBitsAt + 1] < kPngChannels.size())
    return {kPngChannels.at(bytes[kBitsAt + 1]), bytes[kBitsAt]};
  if (format != ImageFormat::kPnm) return {};
  std::optional<std::uint32_t> largest;
  std::size_t at = 2;
  for (int i = 0; i < 3; ++i) largest = next_pnm_number(bytes, at);  // width, height, largest sample
  return {bytes[1] == '3' || bytes[1] == '6' ? 3 : 1, largest.value_or(0) > 255 ? 16 : 8};
}

bool is_acceptable_image(std::span<const std::uint8_t> bytes, std::size_t max_pixels) {
  switch (image_format(bytes)) {
    case ImageFormat::kPng:
      return acceptable_png(bytes, max_pixels);
    case ImageFormat::kJpeg:
      return acceptable_jpeg(bytes, max_pixels);
    case ImageFormat::kTiff:
      return acceptable_tiff(bytes, max_pixels);
    case ImageFormat::kPnm:
      return acceptable_pnm(bytes, max_pixels);
    default:
      return false;
  }
}

}  // namespace panoptic
