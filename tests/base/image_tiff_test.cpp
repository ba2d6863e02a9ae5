// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <tiffio.h>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "tests/base/images.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::as_grey;
using test::bytes_of_text;
using test::error_of;
using test::expect_quiet_complaints;
using test::FileBytes;
using test::fresh_folder;
using test::random_colors;
using test::random_numbers;
using testing::HasSubstr;

struct TiffKind {
  int width = 1;
  int height = 1;
  int bits = 8;
  int channels = 1;
  int format = SAMPLEFORMAT_UINT;
  int meaning = PHOTOMETRIC_MINISBLACK;
  int compression = COMPRESSION_NONE;
  int tile = 0;  // its side, or 0 for strips of 5 rows
  const char* mode = "wl";
};

FileBytes tiff_file(const TiffKind& of, const void* samples) {
  const std::filesystem::path path = fresh_folder("tiff") / "a.tiff";
  TIFF* tiff = TIFFOpen(path.c_str(), of.mode);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, of.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, of.height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, of.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, of.channels);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, of.format);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, of.meaning);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, of.compression);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  const std::size_t pixel = static_cast<std::size_t>(of.channels * of.bits / 8);
  const auto* bytes = static_cast<const std::uint8_t*>(samples);
  const auto at = [&](int u, int v) { return bytes + static_cast<std::size_t>(v * of.width + u) * pixel; };
  if (of.tile > 0) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, of.tile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, of.tile);
    std::uint32_t number = 0;
    for (int v0 = 0; v0 < of.height; v0 += of.tile) {
      for (int u0 = 0; u0 < of.width; u0 += of.tile) {
        FileBytes tile(static_cast<std::size_t>(TIFFTileSize(tiff)));
        const std::size_t columns = static_cast<std::size_t>(std::min(of.tile, of.width - u0));
        for (int v = v0; v < std::min(v0 + of.tile, of.height); ++v) {
          std::copy_n(at(u0, v), columns * pixel, tile.data() + static_cast<std::size_t>((v - v0) * of.tile) * pixel);
        }
        EXPECT_GT(TIFFWriteEncodedTile(tiff, number++, tile.data(), static_cast<tmsize_t>(tile.size())), 0);
      }
    }
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 5);
    for (int v = 0; v < of.height; ++v) {
      FileBytes row(at(0, v), at(0, v) + static_cast<std::size_t>(of.width) * pixel);
      EXPECT_EQ(TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(v)), 1);
    }
  }
  TIFFClose(tiff);
  return bytes_of_text(read_file(path));
}

// Compressions, strips and tiles, little and big endian.
std::vector<TiffKind> tiff_kinds(TiffKind kind) {
  std::vector<TiffKind> kinds;
  for (const int compression : {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS}) {
    for (const int tile : {0, 16}) {
      for (const char* mode : {"wl", "wb"}) {
        kind.compression = compression;
        kind.tile = tile;
        kind.mode = mode;
        kinds.push_back(kind);
      }
    }
  }
  return kinds;
}

TEST(TiffFile, NumbersOfEightAndSixteenBitsAreRead) {
  const Image<std::uint16_t> words = random_numbers(37, 23, 65535);
  for (const TiffKind& kind : tiff_kinds({.width = 37, .height = 23, .bits = 16})) {
    const FileBytes file = tiff_file(kind, words.data());
    EXPECT_EQ(decode_gray16(file, "a"), words) << kind.compression << kind.tile << kind.mode;
    EXPECT_EQ(decode_rgb(file, "a"), as_grey(words, 8)) << kind.compression << kind.tile << kind.mode;
  }
  const Image<std::uint16_t> numbers = random_numbers(37, 23, 255);
  const FileBytes bytes(numbers.pixels().begin(), numbers.pixels().end());
  for (const TiffKind& kind : tiff_kinds({.width = 37, .height = 23})) {
    const FileBytes file = tiff_file(kind, bytes.data());
    EXPECT_EQ(decode_gray16(file, "a"), numbers) << kind.compression << kind.tile << kind.mode;
    EXPECT_EQ(decode_rgb(file, "a"), as_grey(numbers, 0)) << kind.compression << kind.tile << kind.mode;
  }
}

TEST(TiffFile, FloatsAreRead) {
  const std::filesystem::path path = fresh_folder() / "a.tiff";
  Image<float> image(19, 8);
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = 0.25F * static_cast<float>(i) - 3;
  for (const TiffKind& kind : tiff_kinds({.width = 19, .height = 8, .bits = 32, .format = SAMPLEFORMAT_IEEEFP})) {
    const FileBytes file = tiff_file(kind, image.data());
    write_file(path, file);
    EXPECT_EQ(read_gray_float(path), image) << kind.compression << kind.tile << kind.mode;
    EXPECT_THAT(error_of([&] { decode_gray16(file, "a.tiff"); }),
                HasSubstr("a.tiff: expected one channel of 16 or 8 bits, found 1 of 32"));
  }
}

TEST(TiffFile, ColoursAreRead) {
  const Image<Rgb> image = random_colors(21, 18);
  for (const TiffKind& kind : tiff_kinds({.width = 21, .height = 18, .channels = 3, .meaning = PHOTOMETRIC_RGB})) {
    EXPECT_EQ(decode_rgb(tiff_file(kind, image.data()), "a"), image) << kind.compression << kind.tile << kind.mode;
  }
}

TEST(TiffFile, WhereZeroIsWhiteTheNumbersStayAndTheColoursAreTurned) {
  const FileBytes samples = {0, 10, 255};
  const FileBytes file = tiff_file({.width = 3, .meaning = PHOTOMETRIC_MINISWHITE}, samples.data());
  EXPECT_EQ(decode_gray16(file, "a"), Image<std::uint16_t>(3, 1, {0, 10, 255}));
  EXPECT_EQ(decode_rgb(file, "a"), Image<Rgb>(3, 1, {{255, 255, 255}, {245, 245, 245}, {0, 0, 0}}));
}

TEST(TiffFile, OtherKindsAreRefused) {
  const FileBytes samples(64, 1);
  const TiffKind deep{.width = 2, .bits = 16, .channels = 3, .meaning = PHOTOMETRIC_RGB};
  EXPECT_THAT(error_of([&] { decode_rgb(tiff_file(deep, samples.data()), "a.tiff"); }),
              HasSubstr("a.tiff: not a readable image: a TIFF with 3 channels of 16 bits"));
  const TiffKind with_sign{.width = 2, .bits = 16, .format = SAMPLEFORMAT_INT};
  EXPECT_THAT(error_of([&] { decode_gray16(tiff_file(with_sign, samples.data()), "a.tiff"); }),
              HasSubstr("a.tiff: not a readable image"));
}

TEST(TiffFile, DamageIsAnErrorAndNothingIsPrinted) {
  const FileBytes samples(16 * 16, 7);
  const FileBytes sound = tiff_file({.width = 16, .height = 16, .compression = COMPRESSION_LZW}, samples.data());
  expect_quiet_complaints(sound, 0, "a.tiff: ", [](const FileBytes& file) { decode_gray16(file, "a.tiff"); });
}

}  // namespace
}  // namespace panoptic
