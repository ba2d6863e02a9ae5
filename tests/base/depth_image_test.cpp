// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/depth_image.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openexr.h>

#include <Eigen/Core>
#include <cmath>
#include <cstring>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "tests/fresh_folder.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

DepthImage decode(const std::string& bytes) { return decode_depth_image(bytes_of(bytes), "input"); }

std::string error_of_bytes(const std::string& bytes) {
  try {
    decode(bytes);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

// A NumPy array as numpy.save writes it (version 1).
template <typename T>
std::string npy(const std::string& type, const std::string& shape, const std::vector<T>& values, bool by_columns = false) {
  std::string header =
      fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}", type, by_columns ? "True" : "False", shape);
  header.resize((10 + header.size() + 1 + 63) / 64 * 64 - 10 - 1, ' ');
  header += '\n';
  std::string bytes = "\x93NUMPY\x01";
  bytes += '\0';
  bytes += static_cast<char>(header.size() & 255);
  bytes += static_cast<char>(header.size() >> 8);
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  return bytes;
}

// Rows (0 1 2) and (3 4 5).
template <typename Value, typename T>
void expect_two_rows(const std::string& bytes, T unit) {
  const DepthImage depth = decode(bytes);
  const auto* image = std::get_if<Image<Value>>(&depth);
  ASSERT_NE(image, nullptr);
  ASSERT_TRUE(image->same_size(3, 2));
  for (int i = 0; i < 6; ++i) EXPECT_EQ((*image)(i % 3, i / 3), static_cast<Value>(i * unit)) << i;
}

TEST(DepthImage, ReadsNumpyArraysOfEveryUsualType) {
  expect_two_rows<float>(npy<float>("<f4", "(2, 3)", {0, 0.5F, 1, 1.5F, 2, 2.5F}), 0.5);
  expect_two_rows<float>(npy<double>("<f8", "(2, 3)", {0, 0.5, 1, 1.5, 2, 2.5}), 0.5);
  std::vector<Eigen::half> halves;
  for (int i = 0; i < 6; ++i) halves.emplace_back(0.5F * static_cast<float>(i));
  expect_two_rows<float>(npy("<f2", "(2, 3)", halves), 0.5);
  expect_two_rows<std::uint16_t>(npy<std::uint16_t>("<u2", "(2, 3)", {0, 1000, 2000, 3000, 4000, 5000}), 1000);
  expect_two_rows<std::uint16_t>(npy<std::int32_t>("<i4", "(2, 3)", {-7, 1000, 2000, 3000, 4000, 5000}), 1000);
  expect_two_rows<std::uint16_t>(npy<std::int64_t>("<i8", "(2, 3)", {0, 1000, 2000, 3000, 4000, 5000}), 1000);
  expect_two_rows<std::uint16_t>(npy<std::uint16_t>(">u2", "(2, 3)", {0, 0x0100, 0x0200, 0x0300, 0x0400, 0x0500}), 1);
}

TEST(DepthImage, ReadsNumpyArraysByColumnsAndWithSidesOfOne) {
  expect_two_rows<float>(npy<float>("<f4", "(2, 3)", {0, 3, 1, 4, 2, 5}, true), 1);
  expect_two_rows<float>(npy<float>("<f4", "(2, 3, 1)", {0, 1, 2, 3, 4, 5}), 1);
  expect_two_rows<float>(npy<float>("<f4", "(1, 2, 3)", {0, 1, 2, 3, 4, 5}), 1);
}

TEST(DepthImage, SaysWhyANumpyArrayIsNoDepth) {
  EXPECT_THAT(error_of_bytes(npy<std::uint8_t>("|u1", "(2, 3)", {0, 1, 2, 3, 4, 5})), HasSubstr("an array of type '|u1'"));
  EXPECT_THAT(error_of_bytes(npy<float>("<f4", "(2, 3, 3)", std::vector<float>(18))), HasSubstr("an array of 3 dimensions"));
  EXPECT_THAT(error_of_bytes(npy<float>("<f4", "(2, 3)", {0, 1, 2, 3, 4})), HasSubstr("5 numbers of 6"));
  EXPECT_THAT(error_of_bytes(npy<float>("<f4", "(200000000, 300000000)", {0})), HasSubstr("said to hold 300000000 x 200000000"));
  EXPECT_THAT(error_of_bytes(npy<float>("<f4", "(99999999999999999999, 3)", {0})), HasSubstr("out of range"));
  EXPECT_THAT(error_of_bytes(npy<std::int32_t>("<i4", "(2, 3)", {0, 0, 0, 0, 70000, 0})), HasSubstr("holds 70000"));
  EXPECT_THAT(error_of_bytes("\x93NUMPY\x01"), HasSubstr("cut off"));
  const std::string whole = npy<float>("<f4", "(2, 3)", {0, 1, 2, 3, 4, 5});
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes)
    EXPECT_NE(error_of_bytes(whole.substr(0, bytes)), "no error") << bytes;
}

// Two rows of three floats in one OpenEXR channel beside others of zeros, written by the library itself.
std::string exr(const std::vector<const char*>& channels, exr_compression_t compression, const std::string& wanted) {
  const std::filesystem::path path = fresh_folder("exr") / "a.exr";
  exr_context_t context = nullptr;
  exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
  EXPECT_EQ(exr_start_write(&context, path.c_str(), EXR_WRITE_FILE_DIRECTLY, &start), EXR_ERR_SUCCESS);
  int part = 0;
  exr_add_part(context, "", EXR_STORAGE_SCANLINE, &part);
  exr_initialize_required_attr_simple(context, part, 3, 2, compression);
  for (const char* name : channels) exr_add_channel(context, part, name, EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
  EXPECT_EQ(exr_write_header(context), EXR_ERR_SUCCESS);
  std::int32_t step = 1;
  exr_get_scanlines_per_chunk(context, part, &step);
  const std::vector<float> depth = {0, 1, 2, 3, 4, 5};
  const std::vector<float> zeros(6);
  exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
  for (int y = 0; y < 2; y += step) {
    exr_chunk_info_t chunk{};
    exr_write_scanline_chunk_info(context, part, y, &chunk);
    y == 0 ? exr_encoding_initialize(context, part, &chunk, &encode) : exr_encoding_update(context, part, &chunk, &encode);
    for (int i = 0; i < encode.channel_count; ++i) {
      const std::vector<float>& values = wanted == encode.channels[i].channel_name ? depth : zeros;
      encode.channels[i].user_pixel_stride = 4;
      encode.channels[i].user_line_stride = 12;
      encode.channels[i].encode_from_ptr = reinterpret_cast<const std::uint8_t*>(values.data() + 3 * y);
    }
    if (y == 0) exr_encoding_choose_default_routines(context, part, &encode);
    EXPECT_EQ(exr_encoding_run(context, part, &encode), EXR_ERR_SUCCESS);
  }
  exr_encoding_destroy(context, &encode);
  exr_finish(&context);
  return read_file(path);
}

TEST(DepthImage, ReadsOpenExrByItsDepthChannel) {
  for (const exr_compression_t compression :
       {EXR_COMPRESSION_NONE, EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP, EXR_COMPRESSION_PIZ}) {
    expect_two_rows<float>(exr({"Z"}, compression, "Z"), 1);
    expect_two_rows<float>(exr({"A", "B", "G", "R", "Z"}, compression, "Z"), 1);
  }
  expect_two_rows<float>(exr({"distance"}, EXR_COMPRESSION_ZIP, "distance"), 1);
  EXPECT_THAT(error_of_bytes(exr({"u", "v"}, EXR_COMPRESSION_ZIP, "u")), HasSubstr("2 channels and no Z"));
}

TEST(DepthImage, EveryTruncationOfAnOpenExrFileIsRefused) {
  const std::string whole = exr({"Z"}, EXR_COMPRESSION_ZIP, "Z");
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes)
    EXPECT_NE(error_of_bytes(whole.substr(0, bytes)), "no error") << bytes;
}

TEST(DepthImage, RefusesPicturesOfEightBitsByName) {
  const auto text = [](const std::vector<std::uint8_t>& bytes) { return std::string(bytes.begin(), bytes.end()); };
  EXPECT_THAT(error_of_bytes(text(encode_png(Image<std::uint8_t>(4, 3, 9)))),
              HasSubstr("grey of 8 bits; depth needs one channel of 16"));
  EXPECT_THAT(error_of_bytes(text(encode_jpeg(Image<Rgb>(4, 3), 90))), HasSubstr("a JPEG"));
  const std::filesystem::path path = fresh_folder("color") / "a.png";
  write_png(path, Image<Rgb>(4, 3));
  EXPECT_THAT(error_of_bytes(read_file(path)), HasSubstr("a colour picture"));
  EXPECT_THAT(error_of_bytes("P5 2 1 255\n\1\2"), HasSubstr("grey of 8 bits"));
  const DepthImage depth = decode(text(encode_png(Image<std::uint16_t>(4, 3, 1234))));
  EXPECT_EQ(std::get<Image<std::uint16_t>>(depth)(3, 2), 1234);
}

}  // namespace
}  // namespace panoptic::test
