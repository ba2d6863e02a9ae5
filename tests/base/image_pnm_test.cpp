// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "panoptic/base/image_io.h"
#include "tests/base/images.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::as_grey;
using test::bytes_of_text;
using test::error_of;
using test::FileBytes;
using testing::HasSubstr;

TEST(PnmFile, TextAndBytesOfBothDepthsAreRead) {
  const Image<std::uint16_t> numbers(2, 2, {0, 7, 200, 255});
  EXPECT_EQ(decode_gray16(bytes_of_text("P2\n# by hand\n2 2\n255\n0 7\n200 255"), "a"), numbers);
  EXPECT_EQ(decode_gray16(bytes_of_text(std::string("P5 2 2 255\n") + '\0' + "\x07\xC8\xFF"), "a"), numbers);
  const Image<std::uint16_t> large(2, 1, {0x1234, 0xFF00});
  EXPECT_EQ(decode_gray16(bytes_of_text("P2 2 1 65535 4660 65280\n"), "a"), large);
  EXPECT_EQ(decode_gray16(bytes_of_text(std::string("P5 2 1 65535\n\x12\x34\xFF") + '\0'), "a"), large);
  EXPECT_EQ(decode_rgb(bytes_of_text("P2 2 1 65535 4660 65280\n"), "a"), as_grey(large, 8));
  const Image<Rgb> color(2, 1, {{1, 2, 3}, {4, 5, 6}});
  EXPECT_EQ(decode_rgb(bytes_of_text("P3 2 1 255 1 2 3 4 5 6\n"), "a"), color);
  EXPECT_EQ(decode_rgb(bytes_of_text("P6 2 1 255\n\1\2\3\4\5\6"), "a"), color);
  EXPECT_EQ(decode_rgb(bytes_of_text("P6 2 1 65535\n\1x\2x\3x\4x\5x\6x"), "a"), color);
}

TEST(PnmFile, TextOfFewBitsIsStretchedWhereColourIsAsked) {
  const FileBytes file = bytes_of_text("P2 3 1 15 0 1 15\n");
  EXPECT_EQ(decode_gray16(file, "a"), Image<std::uint16_t>(3, 1, {0, 1, 15}));
  EXPECT_EQ(decode_rgb(file, "a"), Image<Rgb>(3, 1, {{0, 0, 0}, {17, 17, 17}, {255, 255, 255}}));
}

TEST(PnmFile, WhatIsNotThereIsRefused) {
  for (const char* text :
       {"P2 2 2 255 1 2 3", "P2 2 2 255 1 2 x 4", "P3 2 1 255 1 2 3 4 5", "P5 2 2 255\nabc", "P5 2 2 65535\nabcdefg",
        "P6 2 1 255\nabcde", "P5 2 2 0\nabcd", "P5 2 2 65536\nabcdefgh", "P5 2 2 255", "P2 2 2 -1 1 2 3 4"}) {
    EXPECT_THAT(error_of([&] { decode_rgb(bytes_of_text(text), "a.pgm"); }), HasSubstr("a.pgm: not a readable image")) << text;
  }
  EXPECT_THAT(error_of([] { decode_gray16(bytes_of_text("P6 1 1 255\nabc"), "a.ppm"); }), HasSubstr("found 3 of 8"));
}

}  // namespace
}  // namespace panoptic
