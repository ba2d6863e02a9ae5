// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/image_io.h"

#include <gmock/gmock.h>

#include <bit>
#include <random>

#include "panoptic/base/files.h"
#include "panoptic/base/image_header.h"
#include "tests/base/foreign_memory.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::HasSubstr;

Image<Rgb> noise_rgb(int width, int height) {
  std::mt19937 random(7);
  Image<Rgb> image(width, height);
  for (std::size_t i = 0; i < image.size(); ++i) {
    image[i] = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random())};
  }
  return image;
}

std::vector<std::uint8_t> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

// The smallest picture that shows every part of the format: a 16 x 8 baseline JPEG of one grey, its tables and its scan
// written out by hand (one DC code of length 1, one AC code for "end of block").
std::vector<std::uint8_t> grey_jpeg() {
  std::vector<std::uint8_t> jpeg = {0xFF, 0xD8, 0xFF, 0xDB, 0x00, 0x43, 0x00};
  jpeg.insert(jpeg.end(), 64, 1);                                                                   // quantisation: all ones
  const std::vector<std::uint8_t> frame = {0xFF, 0xC0, 0x00, 0x0B, 8, 0, 8, 0, 16, 1, 1, 0x11, 0};  // 8 rows, 16 columns
  jpeg.insert(jpeg.end(), frame.begin(), frame.end());
  for (const std::uint8_t table : {std::uint8_t{0x00}, std::uint8_t{0x10}}) {  // one code of one bit, for the value 0
    const std::vector<std::uint8_t> head = {0xFF, 0xC4, 0x00, 0x14, table, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    jpeg.insert(jpeg.end(), head.begin(), head.end());
  }
  const std::vector<std::uint8_t> scan = {0xFF, 0xDA, 0x00, 0x08, 1, 1, 0x00, 0, 63, 0, 0x0F, 0xFF, 0xD9};
  jpeg.insert(jpeg.end(), scan.begin(), scan.end());
  return jpeg;
}

TEST(ImageIo, ColourSurvivesThePngRoundTrip) {
  const std::filesystem::path folder = fresh_folder();
  const Image<Rgb> image = noise_rgb(37, 23);
  write_png(folder / "image.png", image);
  EXPECT_EQ(read_rgb(folder / "image.png"), image);
}

TEST(ImageIo, SixteenBitsSurviveThePngRoundTrip) {
  const std::filesystem::path folder = fresh_folder();
  Image<std::uint16_t> image(256, 256);
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<std::uint16_t>(i);  // every value there is
  write_png(folder / "depth.png", image);
  EXPECT_EQ(read_gray16(folder / "depth.png"), image);
}

TEST(ImageIo, EncodesInMemory) {
  const Image<std::uint8_t> bytes(3, 1, {0, 127, 255});
  const Image<std::uint16_t> words(3, 1, {0, 300, 65535});
  const Image<Rgb> color(16, 8, Rgb{200, 40, 10});
  EXPECT_EQ(decode_gray16(encode_png(bytes), "bytes.png"), Image<std::uint16_t>(3, 1, {0, 127, 255}));
  EXPECT_EQ(decode_gray16(encode_png(words), "words.png"), words);
  const Rgb back = decode_rgb(encode_jpeg(color, 95), "color.jpg")(8, 4);
  EXPECT_NEAR(back.r, 200, 3);
  EXPECT_NEAR(back.g, 40, 3);
  EXPECT_NEAR(back.b, 10, 3);
}

TEST(ImageIo, EncodesBorrowedRowsAsThoseOfAnImage) {
  const Image<Rgb> image = noise_rgb(17, 9);
  for (const test::RowOrder order : {test::RowOrder::kTopFirst, test::RowOrder::kTopLast}) {
    EXPECT_EQ(encode_jpeg(test::ForeignMemory<Rgb>(image, 5, order).view(), 90), encode_jpeg(image, 90));
  }
}

TEST(ImageIo, EightBitGreyKeepsItsValues) {
  const std::string pgm = std::string("P5\n3 1\n255\n") + '\x00' + '\x7f' + '\xff';
  const Image<std::uint16_t> image = decode_gray16(bytes_of(pgm), "image.pgm");
  EXPECT_EQ(image, Image<std::uint16_t>(3, 1, {0, 127, 255}));
}

TEST(ImageIo, GreyBecomesColour) {
  const std::string pgm = std::string("P5\n1 1\n255\n") + '\x7f';
  EXPECT_EQ(decode_rgb(bytes_of(pgm), "image.pgm"), (Image<Rgb>(1, 1, Rgb{127, 127, 127})));
}

TEST(ImageIo, ReadsAJpeg) { EXPECT_EQ(decode_rgb(grey_jpeg(), "grey.jpg"), (Image<Rgb>(16, 8, Rgb{128, 128, 128}))); }

TEST(ImageIo, RefusesAJpegCutOffAnywhere) {
  const std::vector<std::uint8_t> whole = grey_jpeg();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THAT(error_of([&] {
                  decode_rgb({whole.data(), size}, "cut.jpg");
                }),
                HasSubstr("cut.jpg: not a readable image"))
        << size;
  }
}

TEST(ImageIo, TakesAJpegWithBytesAfterItsEnd) {
  std::vector<std::uint8_t> padded = grey_jpeg();
  padded.insert(padded.end(), 100, 0);
  EXPECT_EQ(decode_rgb(padded, "padded.jpg").width(), 16);
}

TEST(ImageIo, RefusesAPngCutOffAnywhere) {
  const std::filesystem::path folder = fresh_folder();
  write_png(folder / "image.png", noise_rgb(9, 7));
  const std::string whole = read_file(folder / "image.png");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_file(folder / "cut.png", std::string_view(whole).substr(0, size));
    EXPECT_THAT(error_of([&] { read_rgb(folder / "cut.png"); }), HasSubstr("cut.png: not a readable image")) << size;
  }
}

TEST(ImageIo, RefusesASixteenBitPngCutOffInTheMiddle) {
  const std::filesystem::path folder = fresh_folder();
  Image<std::uint16_t> image(64, 64);
  std::mt19937 random(3);
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<std::uint16_t>(random());
  write_png(folder / "depth.png", image);
  const std::string whole = read_file(folder / "depth.png");
  write_file(folder / "cut.png", std::string_view(whole).substr(0, whole.size() / 2));
  EXPECT_THAT(error_of([&] { read_gray16(folder / "cut.png"); }), HasSubstr("cut.png: not a readable image"));
}

TEST(ImageIo, RefusesEmptyAndForeignFiles) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "empty.png", "");
  write_file(folder / "text.png", "this is no picture");
  EXPECT_THAT(error_of([&] { read_rgb(folder / "empty.png"); }), HasSubstr("empty.png: not a readable image"));
  EXPECT_THAT(error_of([&] { read_gray16(folder / "text.png"); }), HasSubstr("text.png: not a readable image"));
  EXPECT_THAT(error_of([&] { read_rgb(folder / "absent.png"); }), HasSubstr("absent.png: No such file"));
  EXPECT_THAT(error_of([] { decode_rgb({}, "nothing"); }), HasSubstr("nothing: not a readable image"));
}

TEST(ImageIo, RefusesAHeaderThatLiesAboutTheSize) {
  const std::filesystem::path folder = fresh_folder();
  write_png(folder / "image.png", noise_rgb(4, 4));
  std::vector<std::uint8_t> png = bytes_of(read_file(folder / "image.png"));
  png[18] = 0x7F;  // width 32516: times height 32516, above the limit
  png[22] = 0x7F;
  EXPECT_THAT(error_of([&] { decode_rgb(png, "lying.png"); }), HasSubstr("lying.png: not a readable image"));
  std::vector<std::uint8_t> jpeg = grey_jpeg();
  constexpr std::size_t kHeight = 71 + 5;
  ASSERT_EQ(jpeg[kHeight + 1], 8);
  jpeg[kHeight] = 0xFF;
  jpeg[kHeight + 2] = 0xFF;
  EXPECT_THAT(error_of([&] { decode_rgb(jpeg, "lying.jpg"); }), HasSubstr("lying.jpg: not a readable image"));
}

TEST(ImageIo, LeavesFormatsThatNobodyNeedsAlone) {
  // A whole 1 x 1 picture each.
  std::vector<std::uint8_t> bmp(58, 0);
  const std::vector<std::uint8_t> head = {'B', 'M', 58, 0, 0, 0, 0, 0, 0, 0, 54, 0, 0, 0, 40,
                                          0,   0,   0,  1, 0, 0, 0, 1, 0, 0, 0,  1, 0, 24};
  std::copy(head.begin(), head.end(), bmp.begin());
  const std::vector<std::vector<std::uint8_t>> foreign = {
      bmp, bytes_of(std::string("P4\n1 1\n") + '\x80'),
      bytes_of("P7\nWIDTH 1\nHEIGHT 1\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\n\x7f"),
      bytes_of("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x7f\x7f\x7f\x7f")};
  for (const auto& bytes : foreign) {
    EXPECT_THAT(error_of([&] { decode_rgb(bytes, "foreign"); }), HasSubstr("foreign: not a readable image")) << bytes[1];
  }
}

// A TIFF of one strip of grey floats, little or big endian.
std::vector<std::uint8_t> float_tiff(bool big, std::uint32_t width, std::uint32_t height, const std::vector<float>& pixels) {
  std::vector<std::uint8_t> tiff;
  const auto put = [&](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) tiff.push_back(static_cast<std::uint8_t>(value >> (8 * (big ? bytes - 1 - i : i))));
  };
  put(big ? 0x4D4D : 0x4949, 2);
  put(42, 2);
  put(8, 4);
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> entries = {
      {256, width}, {257, height}, {258, 32},
      {259, 1},     {262, 1},      {273, 8 + 2 + 10 * 12 + 4},
      {277, 1},     {278, height}, {279, static_cast<std::uint32_t>(4 * pixels.size())},
      {339, 3}};
  put(static_cast<std::uint32_t>(entries.size()), 2);
  for (const auto& [tag, value] : entries) {
    const bool is_short = tag == 258 || tag == 259 || tag == 262 || tag == 277 || tag == 339;
    put(tag, 2);
    put(is_short ? 3 : 4, 2);
    put(1, 4);
    put(value, is_short ? 2 : 4);
    if (is_short) put(0, 2);
  }
  put(0, 4);
  for (const float pixel : pixels) put(std::bit_cast<std::uint32_t>(pixel), 4);
  return tiff;
}

TEST(ImageIo, ReadsFloatsFromATiffOfEitherByteOrder) {
  const std::filesystem::path folder = fresh_folder();
  for (const bool big : {false, true}) {
    write_file(folder / "depth.tiff", float_tiff(big, 3, 1, {0.25F, -1, 1e6F}));
    EXPECT_EQ(read_gray_float(folder / "depth.tiff"), (Image<float>(3, 1, {0.25F, -1, 1e6F}))) << big;
  }
}

// The size is refused by what the header says, before a codec takes memory for it; each is otherwise plausible.
TEST(ImageHeader, TellsTheSizeOfEveryFormat) {
  const std::vector<float> pixels(1000);
  const auto tiff = [&](std::uint32_t width, std::uint32_t height) { return float_tiff(width % 2 == 0, width, height, pixels); };
  EXPECT_TRUE(is_acceptable_image(tiff(100, 10), 1000));
  EXPECT_TRUE(is_acceptable_image(tiff(125, 8), 1000));
  for (const auto& [width, height] : std::vector<std::pair<std::uint32_t, std::uint32_t>>{
           {100, 11}, {1001, 1}, {65536, 65536}, {0xFFFFFFFF, 0xFFFFFFFF}, {0, 5}, {5, 0}}) {
    EXPECT_FALSE(is_acceptable_image(tiff(width, height), 1000)) << width << " x " << height;
  }
  const auto pnm = [](const std::string& text) { return is_acceptable_image(bytes_of(text), 1000); };
  const std::string data(1000, '7');
  EXPECT_TRUE(pnm("P5\n# by hand\n100\t10 255\n" + data));
  EXPECT_TRUE(pnm("P3 1 1 255 1 2 3"));
  for (const char* text : {"P5\n100 11\n255\n", "P6 4294967297 1 255\n", "P6 99999 99999 255\n", "P5 -5 5 255\n", "P5 0 5 255\n",
                           "P5 # 5 5", "P4 1 1\n"}) {
    EXPECT_FALSE(pnm(text + data)) << text;
  }
  EXPECT_FALSE(pnm("P5 5"));
  EXPECT_FALSE(pnm("P5"));
}

// A header may claim what the best compression could pack into the file, and no pixel more: memory is taken for what it claims.
TEST(ImageHeader, RefusesMorePixelsThanTheBytesCanHold) {
  constexpr std::size_t kNoOtherLimit = std::size_t{1} << 62;
  std::vector<std::uint8_t> png = encode_png(Image<std::uint16_t>(2000, 1000));  // all zeros: as small as it gets
  EXPECT_TRUE(is_acceptable_image(png, kNoOtherLimit));
  EXPECT_LT(png.size(), 10000U);
  png[22] = 0x20;  // 8192 rows more
  EXPECT_FALSE(is_acceptable_image(png, kNoOtherLimit));

  std::vector<std::uint8_t> jpeg = encode_jpeg(Image<Rgb>(2000, 1000), 1);
  EXPECT_TRUE(is_acceptable_image(jpeg, kNoOtherLimit));
  std::vector<std::uint8_t> tiny = grey_jpeg();
  constexpr std::size_t kWidth = 71 + 7;
  ASSERT_EQ(tiny[kWidth + 1], 16);
  tiny[kWidth] = 0x40;  // 16,400 x 8 pixels in 141 bytes
  EXPECT_TRUE(is_acceptable_image(tiny, kNoOtherLimit));
  tiny[kWidth - 2] = 0x10;  // 4,104 rows
  EXPECT_FALSE(is_acceptable_image(tiny, kNoOtherLimit));

  EXPECT_TRUE(is_acceptable_image(float_tiff(false, 40, 10, std::vector<float>(400)), kNoOtherLimit));
  EXPECT_FALSE(is_acceptable_image(float_tiff(false, 4000, 1000, std::vector<float>(400)), kNoOtherLimit));
  EXPECT_TRUE(is_acceptable_image(bytes_of("P6 2 1 255 abcdef"), kNoOtherLimit));
  EXPECT_FALSE(is_acceptable_image(bytes_of("P6 200 100 255 abcdef"), kNoOtherLimit));
}

TEST(ImageHeader, RefusesAJpegOfEndlessScans) {
  const std::vector<std::uint8_t> whole = grey_jpeg();
  constexpr std::size_t kScanBytes = 11;  // with its one byte of data
  const std::vector<std::uint8_t> scan(whole.end() - kScanBytes - 2, whole.end() - 2);
  const auto with_scans = [&](int count) {
    std::vector<std::uint8_t> jpeg(whole.begin(), whole.end() - 2);
    for (int i = 1; i < count; ++i) jpeg.insert(jpeg.end(), scan.begin(), scan.end());
    jpeg.insert(jpeg.end(), {0xFF, 0xD9});
    return jpeg;
  };
  EXPECT_TRUE(is_acceptable_image(with_scans(20), 1000));
  EXPECT_FALSE(is_acceptable_image(with_scans(101), 1000));
}

TEST(ImageHeader, RefusesATiffWhoseDirectoryIsNotThere) {
  const std::vector<std::uint8_t> whole = float_tiff(false, 2, 1, {1, 2});
  for (std::size_t size = 0; size < 8 + 2 + 10 * 12; ++size) {
    EXPECT_FALSE(is_acceptable_image({whole.data(), size}, 1000)) << size;
  }
  std::vector<std::uint8_t> far = whole;
  std::fill_n(far.begin() + 4, 4, std::uint8_t{0xFF});
  EXPECT_FALSE(is_acceptable_image(far, 1000));
}

TEST(ImageIo, SurvivesAnyFlippedByte) {
  const std::filesystem::path folder = fresh_folder();
  write_png(folder / "image.png", noise_rgb(5, 5));
  for (const std::vector<std::uint8_t>& whole :
       {bytes_of(read_file(folder / "image.png")), grey_jpeg(), float_tiff(false, 2, 1, {1, 2}), bytes_of("P5\n2 1\n255\n<>")}) {
    for (std::size_t i = 0; i < whole.size(); ++i) {
      for (const int flip : {1, 0x80, 0xFF}) {
        std::vector<std::uint8_t> bytes = whole;
        bytes[i] = static_cast<std::uint8_t>(bytes[i] ^ flip);
        for (const bool color : {true, false}) {
          try {
            const std::size_t pixels = color ? decode_rgb(bytes, "flipped").size() : decode_gray16(bytes, "flipped").size();
            EXPECT_GT(pixels, 0U);
          } catch (const Error& error) {
            EXPECT_THAT(error.what(), HasSubstr("flipped"));
          }
        }
      }
    }
  }
}

TEST(ImageIo, RefusesColourWhereDepthIsExpected) {
  const std::filesystem::path folder = fresh_folder();
  write_png(folder / "image.png", noise_rgb(3, 3));
  EXPECT_THAT(error_of([&] { read_gray16(folder / "image.png"); }), HasSubstr("expected one channel of 16 or 8 bits, found 3"));
  EXPECT_THAT(error_of([&] { read_gray_float(folder / "image.png"); }), HasSubstr("expected one channel of 32-bit floats"));
}

TEST(ImageIo, RefusesToWriteAnEmptyImage) {
  const std::filesystem::path folder = fresh_folder();
  EXPECT_THAT(error_of([&] { write_png(folder / "none.png", Image<Rgb>()); }), HasSubstr("none.png"));
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(ImageIo, AnUnwritablePlaceIsAnErrorThatNamesIt) {
  EXPECT_THAT(error_of([] { write_png("/nowhere/image.png", Image<Rgb>(2, 2)); }), HasSubstr("/nowhere/image.png"));
}

}  // namespace
}  // namespace panoptic
