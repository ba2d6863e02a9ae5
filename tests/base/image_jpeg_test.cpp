// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <turbojpeg.h>

#include "panoptic/base/image_io.h"
#include "tests/base/images.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::as_grey;
using test::error_of;
using test::FileBytes;
using test::random_colors;
using test::samples_of;
using testing::HasSubstr;

FileBytes jpeg_file(const std::vector<std::uint8_t>& samples, int width, int height, int format, int sampling) {
  tjhandle jpeg = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(jpeg, samples.data(), width, 0, height, format, &bytes, &size, sampling, 95, TJFLAG_ACCURATEDCT), 0);
  FileBytes file(bytes, bytes + size);
  tjFree(bytes);
  tjDestroy(jpeg);
  return file;
}

// A gradient, which every sampling of the chroma keeps.
Image<Rgb> gradient(int width, int height) {
  Image<Rgb> image(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      image(u, v) = {static_cast<std::uint8_t>(60 + 2 * u), static_cast<std::uint8_t>(90 + v),
                     static_cast<std::uint8_t>(120 - u)};
    }
  }
  return image;
}

void expect_near(const Image<Rgb>& image, const Image<Rgb>& expected, int tolerance) {
  ASSERT_TRUE(image.same_size(expected.width(), expected.height()));
  for (std::size_t i = 0; i < image.size(); ++i) {
    ASSERT_NEAR(image[i].r, expected[i].r, tolerance) << i;
    ASSERT_NEAR(image[i].g, expected[i].g, tolerance) << i;
    ASSERT_NEAR(image[i].b, expected[i].b, tolerance) << i;
  }
}

TEST(JpegFile, EverySamplingOfTheChromaIsRead) {
  const Image<Rgb> image = gradient(33, 19);
  for (const int sampling : {TJSAMP_444, TJSAMP_422, TJSAMP_420, TJSAMP_440, TJSAMP_411}) {
    expect_near(decode_rgb(jpeg_file(samples_of(image), 33, 19, TJPF_RGB, sampling), "a"), image, 6);
  }
}

TEST(JpegFile, GreyIsReadAsColourAndAsNumbers) {
  const FileBytes file = jpeg_file(samples_of(gradient(20, 9)), 20, 9, TJPF_RGB, TJSAMP_GRAY);
  const Image<std::uint16_t> numbers = decode_gray16(file, "a");
  EXPECT_EQ(decode_rgb(file, "a"), as_grey(numbers, 0));
  EXPECT_NEAR(numbers(0, 0), 0.299 * 60 + 0.587 * 90 + 0.114 * 120, 2);
  const FileBytes color = jpeg_file(samples_of(gradient(20, 9)), 20, 9, TJPF_RGB, TJSAMP_420);
  EXPECT_THAT(error_of([&] { decode_gray16(color, "a.jpg"); }),
              HasSubstr("a.jpg: expected one channel of 16 or 8 bits, found 3"));
}

TEST(JpegFile, OrientationIsIgnored) {
  FileBytes file = jpeg_file(samples_of(gradient(20, 9)), 20, 9, TJPF_RGB, TJSAMP_444);
  const Image<Rgb> image = decode_rgb(file, "a");
  constexpr char kTurned[] =
      "\xFF\xE1\0\x22"
      "Exif\0\0II*\0\10\0\0\0\1\0\x12\1\3\0\1\0\0\0\6\0\0\0\0\0\0";
  file.insert(file.begin() + 2, std::begin(kTurned), std::end(kTurned));
  EXPECT_EQ(decode_rgb(file, "a"), image);
}

TEST(JpegFile, CmykIsRefusedByThatName) {
  const FileBytes file = jpeg_file(FileBytes(16 * 8 * 4, 100), 16, 8, TJPF_CMYK, TJSAMP_444);
  EXPECT_THAT(error_of([&] { decode_rgb(file, "a.jpg"); }), HasSubstr("a.jpg: not a readable image: its colours are CMYK"));
  EXPECT_THAT(error_of([&] { decode_gray16(file, "a.jpg"); }), HasSubstr("a.jpg: not a readable image: its colours are CMYK"));
}

// libjpeg would show what it can, with a warning.
TEST(JpegFile, WhatLacksDataInTheMiddleIsRefused) {
  FileBytes file = jpeg_file(samples_of(random_colors(64, 64)), 64, 64, TJPF_RGB, TJSAMP_444);
  const auto middle = file.begin() + static_cast<std::ptrdiff_t>(file.size() / 2);
  file.erase(middle, middle + 500);
  testing::internal::CaptureStderr();
  EXPECT_THAT(error_of([&] { decode_rgb(file, "a.jpg"); }), HasSubstr("a.jpg: not a readable image"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// The accurate transforms, and chroma interpolated, on either way: these are computed in integers, the same everywhere.
TEST(JpegFile, ThePixelsAreGolden) {
  const Image<Rgb> image = decode_rgb(encode_jpeg(random_colors(101, 67), 80), "a");
  std::uint64_t hash = 14695981039346656037U;
  for (const std::uint8_t sample : samples_of(image)) hash = (hash ^ sample) * 1099511628211U;
  EXPECT_EQ(hash, 0x22c1cd35ecf83959U);
}

}  // namespace
}  // namespace panoptic
