// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/bags/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/bags/image_messages.h"
#include "panoptic/base/image_io.h"
#include "tests/bags/bag_bytes.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace): of the tests' own

MessageBytes bytes_of(const std::string& text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }
const char* name_of(Wire wire) { return wire == Wire::kRos1 ? "ros1" : "cdr"; }
constexpr Wire kWires[] = {Wire::kRos1, Wire::kCdr, Wire::kBigCdr};

TEST(Messages, SayTheSameInRos1AndInBothByteOrdersOfCdr) {
  for (const Wire wire : kWires) {
    ImageFields fields{1.5, "/a_frame", 3, 2, "mono16", true, 8, std::string(16, 'x')};
    const std::string bytes = image_bytes(fields, wire);
    const ImageMessage image = decode_image(bytes_of(bytes), name_of(wire));
    EXPECT_EQ(image.header.time_ns, 1'500'000'000);
    EXPECT_EQ(image.header.frame, "a_frame") << "without its slash";
    EXPECT_EQ(image.width, 3U);
    EXPECT_EQ(image.height, 2U);
    EXPECT_EQ(image.encoding, "mono16");
    EXPECT_TRUE(image.is_big_endian);
    EXPECT_EQ(image.row_bytes, 8U);
    EXPECT_EQ(image.data.size(), 16U);

    const std::string info_text = info_bytes({640, 480, "plumb_bob", {0.1, 0.2, 0.3, 0.4, 0.5}, 500}, "f", wire);
    const CameraInfoMessage info = decode_camera_info(bytes_of(info_text), name_of(wire));
    EXPECT_EQ(info.width, 640U);
    EXPECT_EQ(info.distortion_model, "plumb_bob");
    EXPECT_THAT(info.d, testing::ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5));
    EXPECT_EQ(info.k[0], 500);
    EXPECT_EQ(info.p[5], 500);

    const std::string transform_text = transform_bytes(2, "map", "base", {1, 2, 3}, wire);
    const auto transforms = decode_transforms(bytes_of(transform_text), name_of(wire));
    ASSERT_EQ(transforms.size(), 1U);
    EXPECT_EQ(transforms[0].header.frame, "map");
    EXPECT_EQ(transforms[0].child, "base");
    EXPECT_EQ(transforms[0].position, Vec3d(1, 2, 3));
    EXPECT_EQ(transforms[0].rotation.w(), 1);
  }
}

TEST(Messages, ThatAreCutOffAnywhereAreRefused) {
  for (const Wire wire : kWires) {
    const std::string image = image_bytes({1, "f", 2, 2, "16UC1", false, 4, std::string(8, 'x')}, wire);
    const std::string info = info_bytes({}, "f", wire);
    const std::string transform = transform_bytes(2, "map", "base", {1, 2, 3}, wire);
    for (std::size_t n = 0; n < image.size(); ++n)
      EXPECT_THROW(decode_image(bytes_of(image).first(n), name_of(wire)), MessageError) << n;
    for (std::size_t n = 0; n + 24 < info.size(); ++n)
      EXPECT_THROW(decode_camera_info(bytes_of(info).first(n), name_of(wire)), MessageError) << n;
    for (std::size_t n = 0; n < transform.size(); ++n)
      EXPECT_THROW(decode_transforms(bytes_of(transform).first(n), name_of(wire)), MessageError) << n;
  }
}

TEST(Messages, OfAnotherSerializationAreRefusedByItsName) {
  const std::string bytes("\0\3\0\0aaaaaaaaaaaaaaaa", 20);
  EXPECT_THAT(error_of([&] { decode_header(bytes_of(bytes), "cdr"); }), testing::HasSubstr("CDR of kind 3"));
  EXPECT_THAT(error_of([&] { decode_header(bytes_of(bytes), "protobuf"); }), testing::HasSubstr("'protobuf'"));
}

TEST(Messages, CountsThatLieTakeNoMemory) {
  MessageBytesWriter writer;
  writer.put(std::uint32_t{0xFFFFFFFF}).put(std::uint64_t{0});
  EXPECT_THROW(decode_transforms(bytes_of(writer.bytes()), "ros1"), MessageError);
}

ImageMessage image_of(const std::string& bytes) { return decode_image(bytes_of(bytes), "ros1"); }

CompressedImageMessage packed(const std::string& format, MessageBytes data) {
  CompressedImageMessage message;
  message.format = format;
  message.data = data;
  return message;
}

TEST(ImageMessages, DepthIsReadInBothByteOrdersAndWithPaddedRows) {
  const std::string little("\1\0\2\0ppp\3\0\4\0ppp", 14);
  const std::string big("\0\1\0\2ppp\0\3\0\4ppp", 14);
  for (const bool is_big : {false, true}) {
    const std::string bytes = image_bytes({1, "f", 2, 2, "16UC1", is_big, 7, is_big ? big : little});
    const auto depth = std::get<Image<std::uint16_t>>(depth_of(image_of(bytes)));
    EXPECT_THAT(depth.pixels(), testing::ElementsAre(1, 2, 3, 4));
  }
  const std::string metres = number_bytes(1.5F) + number_bytes(2.5F);
  const std::string bytes = image_bytes({1, "f", 2, 1, "32FC1", false, 8, metres});
  EXPECT_THAT(std::get<Image<float>>(depth_of(image_of(bytes))).pixels(), testing::ElementsAre(1.5F, 2.5F));
}

TEST(ImageMessages, ColourIsReadInEveryOrderOfChannels) {
  const Rgb expected{10, 20, 30};
  const std::string rgb{10, 20, 30};
  const std::string bgr{30, 20, 10};
  const std::pair<std::string, std::string> cases[] = {{"rgb8", rgb},           {"bgr8", bgr},        {"8UC3", bgr},
                                                       {"rgba8", rgb + '\xFF'}, {"bgra8", bgr + "a"}, {"8UC4", bgr + "a"}};
  for (const auto& [encoding, data] : cases) {
    const std::string bytes = image_bytes({1, "f", 1, 1, encoding, false, static_cast<std::uint32_t>(data.size()), data});
    EXPECT_EQ(color_of(image_of(bytes))(0, 0), expected) << encoding;
  }
  const std::string grey = image_bytes({1, "f", 1, 1, "mono8", false, 1, "\x28"});
  EXPECT_EQ(color_of(image_of(grey))(0, 0), (Rgb{40, 40, 40}));
}

TEST(ImageMessages, UnknownEncodingsAreRefusedByName) {
  const std::string bayer = image_bytes({1, "f", 1, 1, "bayer_rggb8", false, 1, "a"});
  EXPECT_THAT(error_of([&] { color_of(image_of(bayer)); }), testing::HasSubstr("'bayer_rggb8'"));
  EXPECT_THAT(error_of([&] { depth_of(image_of(bayer)); }), testing::HasSubstr("'bayer_rggb8'"));
  const CompressedImageMessage rvl = packed("16UC1; compressedDepth rvl", {});
  EXPECT_THAT(error_of([&] { depth_of(rvl); }), testing::HasSubstr("rvl"));
}

TEST(ImageMessages, SizesThatDoNotFitTheBytesAreRefused) {
  for (const ImageFields& f :
       {ImageFields{1, "f", 65535, 65535, "16UC1", false, 131070, "abcd"},
        ImageFields{1, "f", 2, 2, "16UC1", false, 3, "abcdefgh"}, ImageFields{1, "f", 2, 2, "16UC1", false, 4, "abcdefg"},
        ImageFields{1, "f", 0, 2, "16UC1", false, 0, ""}}) {
    const std::string bytes = image_bytes(f);
    EXPECT_THROW(depth_of(image_of(bytes)), MessageError);
    EXPECT_THROW(color_of(decode_image(bytes_of(image_bytes({1, "f", 60000, 60000, "rgb8", false, 180000, "abc"})), "ros1")),
                 MessageError);
  }
}

TEST(ImageMessages, CompressedDepthIsPngAfterItsHead) {
  Image<std::uint16_t> stored(3, 2);
  for (std::size_t i = 0; i < stored.size(); ++i) stored[i] = static_cast<std::uint16_t>(1000 * i);
  const std::vector<std::uint8_t> png = encode_png(stored);
  const float a = 5000;
  const float b = -10;
  std::string data = number_bytes(std::uint32_t{0}) + number_bytes(a) + number_bytes(b);
  data.append(png.begin(), png.end());
  EXPECT_EQ(std::get<Image<std::uint16_t>>(depth_of(packed("16UC1; compressedDepth png", bytes_of(data)))), stored);
  const auto metres = std::get<Image<float>>(depth_of(packed("32FC1; compressedDepth", bytes_of(data))));
  EXPECT_EQ(metres[0], 0) << "no reading";
  for (std::size_t i = 1; i < stored.size(); ++i) EXPECT_FLOAT_EQ(metres[i], a / (static_cast<float>(stored[i]) - b));
  EXPECT_THROW(depth_of(packed("16UC1; compressedDepth", bytes_of(data).first(5))), MessageError);
}

TEST(ImageMessages, TheirKindIsToldByTheEncoding) {
  EXPECT_EQ(kind_of_encoding("16UC1", "/a"), ImageKind::kDepth);
  EXPECT_EQ(kind_of_encoding("mono16", "/device_0/sensor_0/Depth_0/image/data"), ImageKind::kDepth);
  EXPECT_EQ(kind_of_encoding("mono16", "/infra"), ImageKind::kUnknown);
  EXPECT_EQ(kind_of_encoding("mono8", "/infra"), ImageKind::kGrey);
  EXPECT_EQ(kind_of_encoding("bayer_rggb8", "/a"), ImageKind::kUnknown);
  EXPECT_EQ(kind_of_format("rgb8; jpeg compressed bgr8", "/a/compressed"), ImageKind::kColor);
  EXPECT_EQ(kind_of_format("jpeg", "/a"), ImageKind::kColor);
  EXPECT_EQ(kind_of_format("16UC1; compressedDepth", "/a"), ImageKind::kDepth);
}

}  // namespace
}  // namespace panoptic
