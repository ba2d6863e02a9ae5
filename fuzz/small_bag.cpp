// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/small_bag.h"

#include <fmt/format.h>

#include <map>

#include "fuzz/input.h"
#include "panoptic/base/files.h"
#include "panoptic/base/sqlite.h"
#include "tests/bags/bag_bytes.h"

namespace panoptic::fuzz {
namespace {

std::string sqlite_bag(const std::vector<test::WrittenMessage>& messages) {
  const Scratch scratch("small_bag");
  const std::filesystem::path path = scratch.path() / "a.db3";
  {
    Database database(path, DatabaseAccess::kCreate);
    // Small pages: a fuzzer's inputs are short.
    database.execute(
        "PRAGMA page_size = 512;"
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);");
    std::map<std::string, std::int64_t> ids;
    for (const test::WrittenMessage& m : messages) {
      const auto [id, is_new] = ids.try_emplace(m.topic, static_cast<std::int64_t>(ids.size()) + 1);
      if (is_new) {
        Statement(database, "INSERT INTO topics VALUES(?, ?, ?, 'cdr')").bind(id->second).bind(m.topic).bind(m.type).run();
      }
      Statement(database, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)")
          .bind(id->second)
          .bind(static_cast<std::int64_t>(1e9 * m.time_s))
          .bind(bytes_of(m.bytes))
          .run();
    }
  }
  return read_file(path);
}

}  // namespace

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
      bags.emplace_back("two_frames.db3", sqlite_bag(messages));
    }
  }
  return bags;
}

}  // namespace panoptic::fuzz
