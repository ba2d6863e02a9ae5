// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <array>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <exception>
#include <new>

#include "panoptic/base/image_codecs.h"

namespace panoptic {
namespace {

// libpng reports errors by longjmp. So each function that calls setjmp, and each callback, has nothing on its stack that would
// have to be destroyed; whatever owns memory lives in the callers.
using Reason = std::array<char, 96>;

[[noreturn]] void jump_out(png_structp png, png_const_charp message) {
  auto& reason = *static_cast<Reason*>(png_get_error_ptr(png));
  std::strncpy(reason.data(), message, reason.size() - 1);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp /*png*/, png_const_charp /*message*/) {}

class PngReader {
 public:
  explicit PngReader(std::span<const std::uint8_t> bytes)
      : left_(bytes),
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, &reason_, jump_out, ignore_warning)),
        info_(png_create_info_struct(png_)) {
    if (info_ != nullptr) return;
    png_destroy_read_struct(&png_, nullptr, nullptr);
    throw std::bad_alloc();
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  bool read_header() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, this, give_bytes);
    png_read_info(png_, info_);
    return true;
  }

  // After the header.
  unsigned width() const { return png_get_image_width(png_, info_); }
  unsigned height() const { return png_get_image_height(png_, info_); }
  int bits() const { return png_get_bit_depth(png_, info_); }
  int channels() const {  // of what the picture shows, not of the indices into a palette
    const int kind = png_get_color_type(png_, info_);
    return ((kind & PNG_COLOR_MASK_COLOR) != 0 ? 3 : 1) + ((kind & PNG_COLOR_MASK_ALPHA) != 0 ? 1 : 0);
  }

  // Samples of 16 bits keep their upper 8. Gamma and other profiles are left alone.
  bool convert_to_rgb() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_strip_16(png_);
    png_set_strip_alpha(png_);
    png_set_palette_to_rgb(png_);
    png_set_expand_gray_1_2_4_to_8(png_);
    png_set_gray_to_rgb(png_);
    return true;
  }

  // Grey of 1, 2 and 4 bits is stretched to 8; REQUIRES one channel.
  bool convert_to_numbers() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    if (bits() < 8) png_set_expand_gray_1_2_4_to_8(png_);
    return true;
  }

  // Into rows of so many bytes each.
  bool read_rows(std::uint8_t* rows, std::size_t row_bytes) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    const int passes = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    if (png_get_rowbytes(png_, info_) != row_bytes) png_error(png_, "its rows have another length");
    for (int pass = 0; pass < passes; ++pass) {
      for (std::size_t v = 0; v < height(); ++v) png_read_row(png_, rows + v * row_bytes, nullptr);
    }
    png_read_end(png_, nullptr);
    return true;
  }

  std::string_view reason() const { return reason_.data(); }

 private:
  static void give_bytes(png_structp png, png_bytep to, std::size_t count) {
    auto& left = static_cast<PngReader*>(png_get_io_ptr(png))->left_;
    if (count > left.size()) png_error(png, "it ends too early");
    std::memcpy(to, left.data(), count);
    left = left.subspan(count);
  }

  Reason reason_{};
  std::span<const std::uint8_t> left_;
  png_structp png_;
  png_infop info_;
};

template <typename T>
Image<T> read_pixels(PngReader& reader, const EncodedImage& file) {
  auto image = image_for<T>(file, reader.width(), reader.height());
  const std::size_t row_bytes = static_cast<std::size_t>(image.width()) * sizeof(T);
  if (!reader.read_rows(reinterpret_cast<std::uint8_t*>(image.data()), row_bytes)) refuse_damaged(file, reader.reason());
  return image;
}

class PngWriter {
 public:
  PngWriter()
      : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, &reason_, jump_out, ignore_warning)),
        info_(png_create_info_struct(png_)) {
    if (info_ != nullptr) return;
    png_destroy_write_struct(&png_, nullptr);
    throw std::bad_alloc();
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  // Fast rather than small: images are written while a map grows.
  bool write(const PixelRows& rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    constexpr std::array<int, 5> kKinds = {0, PNG_COLOR_TYPE_GRAY, 0, PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
    constexpr int kRunLengths = 3;  // zlib's Z_RLE: differences between neighbours repeat, longer patterns seldom do
    png_set_write_fn(png_, this, take_bytes, nullptr);
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_set_compression_level(png_, 1);
    png_set_compression_strategy(png_, kRunLengths);
    png_set_IHDR(png_, info_, static_cast<unsigned>(rows.width), static_cast<unsigned>(rows.height), rows.bits,
                 kKinds[static_cast<std::size_t>(rows.channels)], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png_, info_);
    if (std::endian::native == std::endian::little && rows.bits == 16) png_set_swap(png_);
    const std::size_t row_bytes = static_cast<std::size_t>(rows.width) * static_cast<std::size_t>(rows.channels * rows.bits / 8);
    for (std::size_t v = 0; v < static_cast<std::size_t>(rows.height); ++v) {
      png_write_row(png_, static_cast<const std::uint8_t*>(rows.data) + v * row_bytes);
    }
    png_write_end(png_, info_);
    return true;
  }

  std::vector<std::uint8_t> bytes;

 private:
  static void take_bytes(png_structp png, png_bytep from, std::size_t count) {
    bool is_taken = true;
    try {
      auto& bytes = static_cast<PngWriter*>(png_get_io_ptr(png))->bytes;
      bytes.insert(bytes.end(), from, from + count);
    } catch (const std::exception&) {  // no exception may pass through libpng
      is_taken = false;
    }
    if (!is_taken) png_error(png, "no memory");
  }

  Reason reason_{};
  png_structp png_;
  png_infop info_;
};

}  // namespace

Image<Rgb> decode_png_rgb(const EncodedImage& file) {
  PngReader reader(file.bytes);
  if (!reader.read_header() || !reader.convert_to_rgb()) refuse_damaged(file, reader.reason());
  return read_pixels<Rgb>(reader, file);
}

Image<std::uint16_t> decode_png_gray16(const EncodedImage& file) {
  PngReader reader(file.bytes);
  if (!reader.read_header() || !reader.convert_to_numbers()) refuse_damaged(file, reader.reason());
  if (reader.channels() != 1) refuse_channels(file, reader.channels(), reader.bits());
  if (reader.bits() == 16) return read_pixels<std::uint16_t>(reader, file);
  return widened(read_pixels<std::uint8_t>(reader, file));
}

std::vector<std::uint8_t> png_from_rows(const PixelRows& rows) {
  PngWriter writer;
  if (!writer.write(rows)) return {};
  return std::move(writer.bytes);
}

}  // namespace panoptic
