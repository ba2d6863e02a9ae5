// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Messages and bags byte by byte, so that tests can lie in any field. Whole bags by writers of others: tests/bag_writers.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/geometry.h"

namespace panoptic::test {

template <typename Number>
std::string number_bytes(Number number, bool big = false) {
  std::string bytes(sizeof(Number), '\0');
  std::memcpy(bytes.data(), &number, sizeof(Number));
  return big == (std::endian::native == std::endian::big) ? bytes : std::string(bytes.rbegin(), bytes.rend());
}

enum class Wire { kRos1, kCdr, kBigCdr };

// A message, value by value.
class MessageBytesWriter {
 public:
  explicit MessageBytesWriter(Wire wire = Wire::kRos1) : wire_(wire) {}

  template <typename Number>
  MessageBytesWriter& put(Number number) {
    if (wire_ != Wire::kRos1) body_ += std::string((sizeof(Number) - body_.size() % sizeof(Number)) % sizeof(Number), '\0');
    body_ += number_bytes(number, wire_ == Wire::kBigCdr);
    return *this;
  }
  MessageBytesWriter& text(std::string text) {
    if (wire_ != Wire::kRos1) text.push_back('\0');
    return blob(text);
  }
  MessageBytesWriter& blob(const std::string& bytes) {
    put(static_cast<std::uint32_t>(bytes.size()));
    body_ += bytes;
    return *this;
  }
  MessageBytesWriter& header(double time_s, const std::string& frame) {
    if (wire_ == Wire::kRos1) put(std::uint32_t{7});
    const auto whole_s = static_cast<std::uint32_t>(time_s);
    put(whole_s).put(static_cast<std::uint32_t>((time_s - whole_s) * 1e9 + 0.5));
    return text(frame);
  }
  MessageBytesWriter& pose(const Vec3d& p, const Eigen::Quaterniond& q) {
    return put(p.x()).put(p.y()).put(p.z()).put(q.x()).put(q.y()).put(q.z()).put(q.w());
  }
  std::string bytes() const {
    const char* head = wire_ == Wire::kCdr ? "\0\1\0\0" : "\0\0\0\0";
    return (wire_ == Wire::kRos1 ? "" : std::string(head, 4)) + body_;
  }

 private:
  Wire wire_;
  std::string body_;
};

struct ImageFields {
  double time_s = 1;
  std::string frame = "camera";
  std::uint32_t width = 2;
  std::uint32_t height = 2;
  std::string encoding = "16UC1";
  bool is_big_endian = false;
  std::uint32_t row_bytes = 4;
  std::string data;
};
inline std::string image_bytes(const ImageFields& f, Wire wire = Wire::kRos1) {
  MessageBytesWriter writer(wire);
  writer.header(f.time_s, f.frame).put(f.height).put(f.width).text(f.encoding);
  return writer.put(static_cast<std::uint8_t>(f.is_big_endian)).put(f.row_bytes).blob(f.data).bytes();
}

struct InfoFields {
  std::uint32_t width = 2;
  std::uint32_t height = 2;
  std::string model = "plumb_bob";
  std::vector<double> d;
  double focal = 2;
};
inline std::string info_bytes(const InfoFields& f, const std::string& frame = "camera", Wire wire = Wire::kRos1) {
  MessageBytesWriter writer(wire);
  writer.header(1, frame).put(f.height).put(f.width).text(f.model).put(static_cast<std::uint32_t>(f.d.size()));
  for (const double d : f.d) writer.put(d);
  for (const double k : {f.focal, 0.0, 0.5, 0.0, f.focal, 0.5, 0.0, 0.0, 1.0}) writer.put(k);
  for (const double r : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) writer.put(r);
  for (const double p : {f.focal, 0.0, 0.5, 0.0, 0.0, f.focal, 0.5, 0.0, 0.0, 0.0, 1.0, 0.0}) writer.put(p);
  for (int i = 0; i < 6; ++i) writer.put(std::uint32_t{0});
  return writer.put(std::uint8_t{0}).bytes();
}

inline std::string transform_bytes(double time_s, const std::string& parent, const std::string& child, const Vec3d& position,
                                   Wire wire = Wire::kRos1) {
  MessageBytesWriter writer(wire);
  return writer.put(std::uint32_t{1}).header(time_s, parent).text(child).pose(position, Eigen::Quaterniond::Identity()).bytes();
}

inline std::string odometry_bytes(double time_s, const std::string& parent, const std::string& child, const Vec3d& position) {
  MessageBytesWriter writer;
  writer.header(time_s, parent).text(child).pose(position, Eigen::Quaterniond::Identity());
  constexpr int kCovariancesAndTwist = 36 + 6 + 36;
  for (int i = 0; i < kCovariancesAndTwist; ++i) writer.put(0.0);
  return writer.bytes();
}

struct WrittenMessage {
  std::string topic;
  std::string type;
  double time_s = 0;
  std::string bytes;
};

// ROS 1 bags.
inline std::string ros1_fields(const std::vector<std::pair<std::string, std::string>>& fields) {
  std::string bytes;
  for (const auto& [name, value] : fields) {
    const std::string field = name + "=" + value;
    bytes += number_bytes(static_cast<std::uint32_t>(field.size())) + field;
  }
  return bytes;
}
inline std::string ros1_record(const std::string& fields, const std::string& data) {
  return number_bytes(static_cast<std::uint32_t>(fields.size())) + fields +
         number_bytes(static_cast<std::uint32_t>(data.size())) + data;
}
inline std::string op(std::uint8_t number) { return {static_cast<char>(number)}; }
inline std::string ros1_time(double time_s) {
  const auto whole_s = static_cast<std::uint32_t>(time_s);
  return number_bytes(whole_s) + number_bytes(static_cast<std::uint32_t>((time_s - whole_s) * 1e9 + 0.5));
}
constexpr const char* kRos1Magic = "#ROSBAG V2.0\n";

struct Ros1Fields {
  std::string compression = "none";
  std::uint32_t size_more = 0;  // that the chunk claims to unpack to beyond its size
  std::string encryptor;
  bool is_indexed = true;
};
// One chunk with all messages, each topic a connection.
inline std::string ros1_bag(const std::vector<WrittenMessage>& messages, const Ros1Fields& f = {}) {
  std::vector<std::string> topics;
  std::string connections;
  std::string chunk;
  std::string indices;
  for (const WrittenMessage& m : messages) {
    auto number = static_cast<std::uint32_t>(std::find(topics.begin(), topics.end(), m.topic) - topics.begin());
    const std::string conn = number_bytes(number);
    if (number == topics.size()) {
      topics.push_back(m.topic);
      const std::string record = ros1_record(ros1_fields({{"op", op(7)}, {"conn", conn}, {"topic", m.topic}}),
                                             ros1_fields({{"topic", m.topic}, {"type", m.type}, {"md5sum", "*"}}));
      chunk += record;
      connections += record;
    }
    const std::string entry = ros1_time(m.time_s) + number_bytes(static_cast<std::uint32_t>(chunk.size()));
    indices += ros1_record(
        ros1_fields(
            {{"op", op(4)}, {"ver", number_bytes(std::uint32_t{1})}, {"conn", conn}, {"count", number_bytes(std::uint32_t{1})}}),
        entry);
    chunk += ros1_record(ros1_fields({{"op", op(2)}, {"conn", conn}, {"time", ros1_time(m.time_s)}}), m.bytes);
  }
  std::vector<std::pair<std::string, std::string>> head = {{"op", op(3)}, {"index_pos", number_bytes(std::uint64_t{0})}};
  if (!f.encryptor.empty()) head.emplace_back("encryptor", f.encryptor);
  const std::string size = number_bytes(static_cast<std::uint32_t>(chunk.size()) + f.size_more);
  const std::string chunk_record =
      ros1_record(ros1_fields({{"op", op(5)}, {"compression", f.compression}, {"size", size}}), chunk);
  return kRos1Magic + ros1_record(ros1_fields(head), std::string(64, ' ')) + chunk_record +
         (f.is_indexed ? indices + connections : "");
}

// .mcap, one chunk.
inline std::string mcap_text(const std::string& text) { return number_bytes(static_cast<std::uint32_t>(text.size())) + text; }
inline std::string mcap_record(std::uint8_t op, const std::string& data) {
  return std::string(1, static_cast<char>(op)) + number_bytes(static_cast<std::uint64_t>(data.size())) + data;
}
constexpr const char* kMcapMagic = "\x89MCAP0\r\n";

inline std::string mcap_bag(const std::vector<WrittenMessage>& messages, const std::string& compression = "",
                            std::uint64_t size_more = 0, bool is_indexed = true) {
  std::vector<std::string> topics;
  std::string chunk;
  std::string indices;
  for (const WrittenMessage& m : messages) {
    auto number = static_cast<std::uint16_t>(std::find(topics.begin(), topics.end(), m.topic) - topics.begin());
    const auto id = static_cast<std::uint16_t>(number + 1);
    if (number == topics.size()) {
      topics.push_back(m.topic);
      chunk += mcap_record(3, number_bytes(id) + mcap_text(m.type) + mcap_text("ros2msg") + mcap_text(""));
      chunk += mcap_record(4, number_bytes(id) + number_bytes(id) + mcap_text(m.topic) + mcap_text("cdr") + mcap_text(""));
    }
    const std::string time = number_bytes(static_cast<std::uint64_t>(m.time_s * 1e9));
    indices += mcap_record(7, number_bytes(id) + mcap_text(time + number_bytes(static_cast<std::uint64_t>(chunk.size()))));
    chunk += mcap_record(5, number_bytes(id) + number_bytes(std::uint32_t{0}) + time + time + m.bytes);
  }
  const std::string head = std::string(16, '\0') + number_bytes(static_cast<std::uint64_t>(chunk.size()) + size_more) +
                           number_bytes(std::uint32_t{0}) + mcap_text(compression) +
                           number_bytes(static_cast<std::uint64_t>(chunk.size()));
  return kMcapMagic + mcap_record(1, mcap_text("ros2") + mcap_text("")) + mcap_record(6, head + chunk) +
         (is_indexed ? indices : "") + mcap_record(15, std::string(4, '\0')) + mcap_record(2, std::string(20, '\0')) + kMcapMagic;
}

}  // namespace panoptic::test
