// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Small bags that claim what would take gigabytes: chunks, messages, images, counts.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "panoptic/bag.h"
#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "tests/bags/bag_bytes.h"
#include "tests/fresh_folder.h"
#include "tests/limits/allocation_meter.h"

namespace panoptic {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace): of the tests' own

constexpr std::size_t kAlways = 4U << 20;

void expect_little(const std::string& bytes, const char* what) {
  const std::filesystem::path path = fresh_folder("limits") / "a.bag";
  write_file(path, bytes);
  const Allocations taken = allocations_of([&] {
    try {
      list_bag(path);
      const auto dataset = open_bag(path, {});
      for (std::size_t i = 0; i < dataset->size(); ++i) dataset->read(i);
    } catch (const Error&) {
    }
  });
  EXPECT_LE(taken.largest, kAlways) << what;
  EXPECT_LE(taken.peak, kAlways) << what;
}

std::vector<WrittenMessage> recording(const ImageFields& depth, Wire wire) {
  return {{"/d/image", "sensor_msgs/Image", 1, image_bytes(depth, wire)},
          {"/c/image", "sensor_msgs/Image", 1, image_bytes({1, "camera", 2, 2, "rgb8", false, 6, std::string(12, 'c')}, wire)},
          {"/d/camera_info", "sensor_msgs/CameraInfo", 1, info_bytes({}, "camera", wire)},
          {"/tf", "tf2_msgs/TFMessage", 1, transform_bytes(1, "map", "camera", {1, 0, 0}, wire)},
          {"/tf", "tf2_msgs/TFMessage", 1.1, transform_bytes(1.1, "map", "camera", {2, 0, 0}, wire)}};
}

TEST(BagLimits, ClaimedChunksTakeNothing) {
  const ImageFields sound{1, "camera", 2, 2, "16UC1", false, 4, std::string(8, 'd')};
  for (const char* compression : {"none", "lz4", "bz2", "zstd"}) {
    for (const bool is_indexed : {true, false}) {
      Ros1Fields fields{compression, 0x30000000, "", is_indexed};
      expect_little(ros1_bag(recording(sound, Wire::kRos1), fields), compression);
      expect_little(mcap_bag(recording(sound, Wire::kCdr), compression, 0x30000000, is_indexed), compression);
    }
  }
}

TEST(BagLimits, ClaimedImagesTakeNothing) {
  for (const std::uint32_t side : {30000U, 0xFFFFFFFFU}) {
    const ImageFields large{1, "camera", side, side, "16UC1", false, 2 * side, std::string(8, 'd')};
    expect_little(ros1_bag(recording(large, Wire::kRos1)), "image");
  }
}

TEST(BagLimits, ClaimedCountsTakeNothing) {
  const ImageFields sound{1, "camera", 2, 2, "16UC1", false, 4, std::string(8, 'd')};
  const std::string whole = ros1_bag(recording(sound, Wire::kRos1));
  for (std::size_t at = 16; at + 4 < whole.size(); at += 2) {
    std::string bytes = whole;
    bytes.replace(at, 4, "\xFF\xFF\xFF\x3F", 4);
    if (at % 26 == 16) expect_little(bytes, "any four bytes");
  }
}

}  // namespace
}  // namespace panoptic
