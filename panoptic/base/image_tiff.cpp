// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>

#include "panoptic/base/image_codecs.h"

namespace panoptic {
namespace {

// The bytes that libtiff reads, and why it failed: the first complaint is the cause.
struct TiffMemory {
  std::span<const std::uint8_t> bytes;
  std::uint64_t at = 0;
  std::array<char, 96> reason{};
};

TiffMemory& memory_of(thandle_t handle) { return *static_cast<TiffMemory*>(handle); }

tmsize_t take_tiff_bytes(thandle_t handle, void* to, tmsize_t count) {
  TiffMemory& memory = memory_of(handle);
  const std::uint64_t left = memory.bytes.size() - std::min<std::uint64_t>(memory.at, memory.bytes.size());
  const std::uint64_t taken = std::min(left, static_cast<std::uint64_t>(std::max<tmsize_t>(count, 0)));
  if (taken > 0) std::memcpy(to, memory.bytes.data() + memory.at, taken);
  memory.at += taken;
  return static_cast<tmsize_t>(taken);
}

tmsize_t write_nothing(thandle_t /*handle*/, void* /*from*/, tmsize_t /*count*/) { return -1; }

toff_t seek_tiff(thandle_t handle, toff_t offset, int whence) {
  TiffMemory& memory = memory_of(handle);
  const toff_t base = whence == SEEK_CUR ? memory.at : whence == SEEK_END ? memory.bytes.size() : 0;
  return memory.at = base + offset;
}

int close_nothing(thandle_t /*handle*/) { return 0; }
toff_t tiff_size(thandle_t handle) { return memory_of(handle).bytes.size(); }

int keep_tiff_error(TIFF* /*tiff*/, void* memory, const char* /*module*/, const char* format, va_list arguments) {
  auto& reason = memory_of(memory).reason;
  if (reason[0] == '\0') std::vsnprintf(reason.data(), reason.size(), format, arguments);
  return 1;  // nobody else is told
}

int ignore_tiff_warning(TIFF* /*tiff*/, void* /*user*/, const char* /*module*/, const char* /*format*/, va_list /*arguments*/) {
  return 1;
}

struct TiffHeader {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t bits = 1;
  std::uint16_t channels = 1;
  std::uint16_t format = SAMPLEFORMAT_UINT;
  std::uint16_t meaning = PHOTOMETRIC_MINISBLACK;
  std::uint16_t planes = PLANARCONFIG_CONTIG;
};

class TiffReader {
 public:
  explicit TiffReader(const EncodedImage& file) : file_(file), memory_{file.bytes} {
    constexpr std::size_t kMostForTables = 32U << 20;
    const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
    if (!options) throw std::bad_alloc();
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_tiff_error, &memory_);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), ignore_tiff_warning, nullptr);
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), static_cast<tmsize_t>(file.bytes.size() + kMostForTables));
    tiff_.reset(TIFFClientOpenExt("", "rm", &memory_, take_tiff_bytes, write_nothing, seek_tiff, close_nothing, tiff_size,
                                  nullptr, nullptr, options.get()));
    if (!tiff_) fail();
    read_header();
  }

  const TiffHeader& header() const { return header_; }

  bool is_numbers(int bits, int format) const { return header_.bits == bits && header_.format == format; }

  // REQUIRES pixels of sizeof(T) bytes.
  template <typename T>
  Image<T> pixels() {
    auto image = image_for<T>(file_, header_.width, header_.height);
    auto* bytes = reinterpret_cast<std::uint8_t*>(image.data());
    if (header_.channels > 1 && header_.planes != PLANARCONFIG_CONTIG) refuse_kind(file_, "a TIFF with a plane for each colour");
    if (TIFFIsTiled(tiff_.get()) != 0) {
      read_tiles(bytes, sizeof(T));
    } else {
      read_strips(bytes, header_.width * sizeof(T));
    }
    return image;
  }

 private:
  [[noreturn]] void fail() const {
    refuse_damaged(file_, memory_.reason[0] == '\0' ? "its data is damaged" : memory_.reason.data());
  }

  template <typename T>
  T field(std::uint32_t tag, T otherwise) const {
    T value = otherwise;
    return TIFFGetFieldDefaulted(tiff_.get(), tag, &value) != 0 ? value : otherwise;
  }

  void read_header() {
    header_.width = field(TIFFTAG_IMAGEWIDTH, header_.width);
    header_.height = field(TIFFTAG_IMAGELENGTH, header_.height);
    header_.bits = field(TIFFTAG_BITSPERSAMPLE, header_.bits);
    header_.channels = field(TIFFTAG_SAMPLESPERPIXEL, header_.channels);
    header_.format = field(TIFFTAG_SAMPLEFORMAT, header_.format);
    header_.meaning = field(TIFFTAG_PHOTOMETRIC, header_.meaning);
    header_.planes = field(TIFFTAG_PLANARCONFIG, header_.planes);
  }

  void read_strips(std::uint8_t* out, std::size_t row_bytes) {
    const std::uint32_t strip_rows = std::min(field(TIFFTAG_ROWSPERSTRIP, header_.height), header_.height);
    if (strip_rows == 0 || static_cast<std::size_t>(TIFFScanlineSize(tiff_.get())) != row_bytes) fail();
    std::uint32_t strip = 0;
    for (std::uint32_t v = 0; v < header_.height; v += strip_rows, ++strip) {
      const auto size = static_cast<tmsize_t>(std::min(strip_rows, header_.height - v) * row_bytes);
      if (TIFFReadEncodedStrip(tiff_.get(), strip, out + v * row_bytes, size) != size) fail();
    }
  }

  // A tile may be larger than a small image, within limits.
  void read_tiles(std::uint8_t* out, std::size_t pixel_bytes) {
    constexpr std::uint64_t kAlwaysFits = 512 * 512;
    const std::uint64_t width = field(TIFFTAG_TILEWIDTH, std::uint32_t{0});
    const std::uint64_t height = field(TIFFTAG_TILELENGTH, std::uint32_t{0});
    const std::uint64_t most = std::max(kAlwaysFits, std::uint64_t{header_.width} * header_.height);
    if (width == 0 || height == 0 || width > most || height > most / width) refuse_damaged(file_, "its tiles are too large");
    const std::size_t tile_row = width * pixel_bytes;
    std::vector<std::uint8_t> tile(tile_row * height);
    const auto size = static_cast<tmsize_t>(tile.size());
    if (TIFFTileSize(tiff_.get()) != size) fail();
    std::uint32_t number = 0;
    for (std::uint64_t v = 0; v < header_.height; v += height) {
      for (std::uint64_t u = 0; u < header_.width; u += width, ++number) {
        if (TIFFReadEncodedTile(tiff_.get(), number, tile.data(), size) != size) fail();
        const std::size_t row_bytes = std::min(width, header_.width - u) * pixel_bytes;
        for (std::uint64_t row = 0; row < std::min(height, header_.height - v); ++row) {
          std::memcpy(out + ((v + row) * header_.width + u) * pixel_bytes, tile.data() + row * tile_row, row_bytes);
        }
      }
    }
  }

  struct Close {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
  };

  EncodedImage file_;
  TiffMemory memory_;
  std::unique_ptr<TIFF, Close> tiff_;
  TiffHeader header_;
};

[[noreturn]] void refuse_tiff(const EncodedImage& file, const TiffHeader& header) {
  refuse_kind(file, fmt::format("a TIFF with {} channels of {} bits, format {}, photometric interpretation {}", header.channels,
                                header.bits, header.format, header.meaning));
}

// REQUIRES one channel of 8 or 16 bits.
Image<std::uint16_t> grey_numbers(TiffReader& reader) {
  return reader.header().bits == 16 ? reader.pixels<std::uint16_t>() : widened(reader.pixels<std::uint8_t>());
}

}  // namespace

// Reads grey of 8 bits, or 16 of which it keeps the upper 8, and RGB of 8.
Image<Rgb> decode_tiff_rgb(const EncodedImage& file) {
  TiffReader reader(file);
  const TiffHeader& header = reader.header();
  const bool is_rgb = header.channels == 3 && header.meaning == PHOTOMETRIC_RGB;
  if (is_rgb && reader.is_numbers(8, SAMPLEFORMAT_UINT)) return reader.pixels<Rgb>();
  const bool is_grey = header.channels == 1 && header.meaning <= PHOTOMETRIC_MINISBLACK &&
                       (reader.is_numbers(8, SAMPLEFORMAT_UINT) || reader.is_numbers(16, SAMPLEFORMAT_UINT));
  if (!is_grey) refuse_tiff(file, header);
  const auto image = grey_numbers(reader);
  const int shift = header.bits - 8;
  const std::uint8_t flip = header.meaning == PHOTOMETRIC_MINISWHITE ? 0xFF : 0;
  Image<Rgb> rgb(image.width(), image.height());
  std::transform(image.data(), image.data() + image.size(), rgb.data(), [&](std::uint16_t value) {
    const auto grey = static_cast<std::uint8_t>((value >> shift) ^ flip);
    return Rgb{grey, grey, grey};
  });
  return rgb;
}

Image<std::uint16_t> decode_tiff_gray16(const EncodedImage& file) {
  TiffReader reader(file);
  const TiffHeader& header = reader.header();
  if (header.channels != 1 || (header.bits != 8 && header.bits != 16)) refuse_channels(file, header.channels, header.bits);
  if (header.format != SAMPLEFORMAT_UINT || header.meaning > PHOTOMETRIC_MINISBLACK) refuse_tiff(file, header);
  return grey_numbers(reader);
}

Image<float> decode_tiff_float(const EncodedImage& file) {
  TiffReader reader(file);
  if (reader.header().channels != 1 || !reader.is_numbers(32, SAMPLEFORMAT_IEEEFP)) refuse_no_floats(file);
  return reader.pixels<float>();
}

DepthImage decode_tiff_depth(const EncodedImage& file) {
  TiffReader reader(file);
  const TiffHeader& header = reader.header();
  if (header.channels != 1) refuse_depth(file, fmt::format("a TIFF with {} channels", header.channels));
  if (reader.is_numbers(32, SAMPLEFORMAT_IEEEFP)) return reader.pixels<float>();
  if (reader.is_numbers(16, SAMPLEFORMAT_UINT)) return reader.pixels<std::uint16_t>();
  const auto whole = [&](const auto& image) {
    Image<std::uint16_t> narrow(image.width(), image.height());
    for (std::size_t i = 0; i < image.size(); ++i) narrow[i] = narrowed(file, image[i]);
    return narrow;
  };
  if (reader.is_numbers(16, SAMPLEFORMAT_INT)) return whole(reader.pixels<std::int16_t>());
  if (reader.is_numbers(32, SAMPLEFORMAT_INT)) return whole(reader.pixels<std::int32_t>());
  if (reader.is_numbers(32, SAMPLEFORMAT_UINT)) return whole(reader.pixels<std::uint32_t>());
  refuse_depth(file, fmt::format("a TIFF with {} bits of format {}", header.bits, header.format));
}

}  // namespace panoptic
