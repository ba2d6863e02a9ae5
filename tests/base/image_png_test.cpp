// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <png.h>

#include "panoptic/base/image_io.h"
#include "tests/base/images.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::as_grey;
using test::error_of;
using test::expect_quiet_complaints;
using test::FileBytes;
using test::random_numbers;
using testing::HasSubstr;

struct PngKind {
  int width = 1;
  int height = 1;
  int bits = 8;
  int kind = PNG_COLOR_TYPE_GRAY;
  int interlace = PNG_INTERLACE_NONE;
  std::vector<png_color> palette{};
  FileBytes palette_alpha{};
};

// Samples of 16 bits with the high byte first.
FileBytes png_file(const PngKind& of, const FileBytes& samples) {
  FileBytes file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  const auto take = [](png_structp from, png_bytep bytes, std::size_t count) {
    auto* all = static_cast<FileBytes*>(png_get_io_ptr(from));
    all->insert(all->end(), bytes, bytes + count);
  };
  png_set_write_fn(png, &file, take, nullptr);
  png_set_IHDR(png, info, static_cast<unsigned>(of.width), static_cast<unsigned>(of.height), of.bits, of.kind, of.interlace,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_gAMA(png, info, 0.3);  // to be left alone
  if (!of.palette.empty()) png_set_PLTE(png, info, of.palette.data(), static_cast<int>(of.palette.size()));
  if (!of.palette_alpha.empty()) {
    png_set_tRNS(png, info, of.palette_alpha.data(), static_cast<int>(of.palette_alpha.size()), nullptr);
  }
  png_write_info(png, info);
  const std::size_t row_bytes = png_get_rowbytes(png, info);
  EXPECT_EQ(samples.size(), row_bytes * static_cast<std::size_t>(of.height));
  FileBytes copy = samples;
  std::vector<png_bytep> rows;
  for (std::size_t at = 0; at < copy.size(); at += row_bytes) rows.push_back(copy.data() + at);
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return file;
}

TEST(PngFile, GreyOfFewBitsIsStretchedToEight) {
  const PngKind bits1{.width = 4, .bits = 1};
  const PngKind bits2{.width = 4, .bits = 2};
  const PngKind bits4{.width = 2, .bits = 4};
  EXPECT_EQ(decode_gray16(png_file(bits1, {0b01010000}), "a"), Image<std::uint16_t>(4, 1, {0, 255, 0, 255}));
  EXPECT_EQ(decode_gray16(png_file(bits2, {0b00011011}), "a"), Image<std::uint16_t>(4, 1, {0, 85, 170, 255}));
  EXPECT_EQ(decode_gray16(png_file(bits4, {0x1F}), "a"), Image<std::uint16_t>(2, 1, {17, 255}));
  EXPECT_EQ(decode_rgb(png_file(bits4, {0x1F}), "a"), Image<Rgb>(2, 1, {{17, 17, 17}, {255, 255, 255}}));
}

TEST(PngFile, SixteenBitsBecomeTheUpperEightOfAColour) {
  const PngKind grey{.width = 2, .bits = 16};
  const FileBytes file = png_file(grey, {0x12, 0xFF, 0xFE, 0x80});
  EXPECT_EQ(decode_gray16(file, "a"), Image<std::uint16_t>(2, 1, {0x12FF, 0xFE80}));
  EXPECT_EQ(decode_rgb(file, "a"), Image<Rgb>(2, 1, {{0x12, 0x12, 0x12}, {0xFE, 0xFE, 0xFE}}));
  const PngKind color{.bits = 16, .kind = PNG_COLOR_TYPE_RGB};
  EXPECT_EQ(decode_rgb(png_file(color, {1, 200, 2, 200, 3, 200}), "a"), Image<Rgb>(1, 1, {{1, 2, 3}}));
}

TEST(PngFile, APaletteGivesItsColours) {
  const PngKind kind{.width = 4, .bits = 2, .kind = PNG_COLOR_TYPE_PALETTE, .palette = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}};
  PngKind with_alpha = kind;
  with_alpha.palette_alpha = {0, 100, 255};
  for (const PngKind& of : {kind, with_alpha}) {
    const FileBytes file = png_file(of, {0b00011000});
    EXPECT_EQ(decode_rgb(file, "a"), Image<Rgb>(4, 1, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {1, 2, 3}}));
    EXPECT_THAT(error_of([&] { decode_gray16(file, "a.png"); }),
                HasSubstr("a.png: expected one channel of 16 or 8 bits, found 3"));
  }
}

TEST(PngFile, AlphaIsDropped) {
  const PngKind grey{.width = 2, .kind = PNG_COLOR_TYPE_GRAY_ALPHA};
  EXPECT_EQ(decode_rgb(png_file(grey, {50, 0, 60, 255}), "a"), Image<Rgb>(2, 1, {{50, 50, 50}, {60, 60, 60}}));
  const PngKind color{.kind = PNG_COLOR_TYPE_RGB_ALPHA};
  EXPECT_EQ(decode_rgb(png_file(color, {1, 2, 3, 0}), "a"), Image<Rgb>(1, 1, {{1, 2, 3}}));
  const PngKind deep{.bits = 16, .kind = PNG_COLOR_TYPE_RGB_ALPHA};
  EXPECT_EQ(decode_rgb(png_file(deep, {1, 0, 2, 0, 3, 0, 0, 0}), "a"), Image<Rgb>(1, 1, {{1, 2, 3}}));
}

TEST(PngFile, InterlacedIsTheSame) {
  const Image<std::uint16_t> image = random_numbers(17, 9, 65535);
  FileBytes samples;
  for (const std::uint16_t value : image.pixels()) {
    samples.insert(samples.end(), {static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value & 255)});
  }
  const PngKind kind{.width = 17, .height = 9, .bits = 16, .interlace = PNG_INTERLACE_ADAM7};
  EXPECT_EQ(decode_gray16(png_file(kind, samples), "a"), image);
  EXPECT_EQ(decode_rgb(png_file(kind, samples), "a"), as_grey(image, 8));
}

TEST(PngFile, DamageIsAnErrorAndNothingIsPrinted) {
  const FileBytes sound = png_file({.width = 3, .height = 2}, {1, 2, 3, 4, 5, 6});
  testing::internal::CaptureStderr();
  FileBytes pixels_damaged = sound;
  pixels_damaged[sound.size() - 20] ^= 0x55U;
  EXPECT_THAT(error_of([&] { decode_rgb(pixels_damaged, "a.png"); }), HasSubstr("a.png: not a readable image"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  expect_quiet_complaints(sound, 8, "a.png: not a readable image", [](const FileBytes& file) { decode_rgb(file, "a.png"); });
}

}  // namespace
}  // namespace panoptic
