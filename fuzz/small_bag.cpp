// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/small_bag.h"

#include "tests/bags/bag_bytes.h"

namespace panoptic::fuzz {

std::vector<std::pair<std::string, std::string>> small_bags() {
  std::vector<std::pair<std::string, std::string>> bags;
  for (const test::Wire wire : {test::Wire::kRos1, test::Wire::kCdr}) {
    std::vector<test::WrittenMessage> messages;
    for (int i = 0; i < 2; ++i) {
      const double time_s = 10 + 0.1 * i;
      messages.push_back({"/d/image", "sensor_msgs/Image", time_s,
                          test::image_bytes({time_s, "camera", 2, 2, "16UC1", false, 4, std::string(8, 'd')}, wire)});
      messages.push_back({"/c/image", "sensor_msgs/Image", time_s,
                          test::image_bytes({time_s, "camera", 2, 2, "rgb8", false, 6, std::string(12, 'c')}, wire)});
      messages.push_back(
          {"/tf", "tf2_msgs/TFMessage", time_s, test::transform_bytes(time_s, "map", "camera", {time_s, 0, 0}, wire)});
    }
    messages.push_back({"/d/camera_info", "sensor_msgs/CameraInfo", 10, test::info_bytes({}, "camera", wire)});
    if (wire == test::Wire::kRos1) {
      test::Ros1Fields plain;
      plain.is_indexed = false;
      bags.emplace_back("two_frames.bag", test::ros1_bag(messages));
      bags.emplace_back("without_index.bag", test::ros1_bag(messages, plain));
    } else {
      bags.emplace_back("two_frames.mcap", test::mcap_bag(messages));
      bags.emplace_back("without_index.mcap", test::mcap_bag(messages, "", 0, false));
    }
  }
  return bags;
}

}  // namespace panoptic::fuzz
