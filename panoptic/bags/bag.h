// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Bags: messages of many topics with the time when each was recorded. Three containers (ROS 1 .bag, rosbag2 .db3, .mcap) reduce
// to one list of messages, which says where each lies; bytes are read when they are asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/bags/bag_file.h"

namespace panoptic {

struct BagTopic {
  std::string name;
  std::string type;           // "sensor_msgs/Image"; that of ROS 2, "sensor_msgs/msg/Image", is called so too
  std::string serialization;  // "ros1", "cdr"; of others no message can be read
  std::uint64_t messages = 0;
};

constexpr std::uint32_t kNoChunk = UINT32_MAX;

struct BagMessage {
  std::int64_t time_ns = 0;        // when it was recorded
  std::uint32_t topic = 0;         // index into the topics
  std::uint32_t part = 0;          // the file, where a bag was split
  std::uint32_t chunk = kNoChunk;  // in which its record lies
  std::uint64_t place = 0;         // offset of the record in the chunk or the file; number of the row
};

// The contents of one file, or of all.
struct BagContents {
  std::vector<BagTopic> topics;
  std::vector<BagMessage> messages;
  std::vector<std::string> left_out;  // a line each: what was damaged or cut off
};

// A file can unpack to much more than its size: nothing that is kept of it may grow beyond these.
constexpr std::size_t kMostConnections = 10'000;  // of topics and their publishers
constexpr std::size_t kMostNameBytes = 4096;      // of a topic and its type
constexpr std::uint64_t most_messages(std::uint64_t file_bytes) { return 100'000 + file_bytes / 8; }
// Throws Error naming the file, if there are more.
void require_few_messages(const BagContents& contents, const BagFile& file);
void require_few_connections(std::size_t connections, const BagFile& file);

// The index of the topic, which is added if it is new.
std::uint32_t topic_index(std::vector<BagTopic>& topics, const BagTopic& topic);

// One file of a bag. Threads may read at once.
class BagPart {
 public:
  BagPart() = default;
  virtual ~BagPart() = default;
  BagPart(const BagPart&) = delete;
  BagPart& operator=(const BagPart&) = delete;

  // The message, or its first bytes; nothing if the file is damaged there. Throws FileError if the disk fails.
  virtual std::optional<BagBytes> read(const BagMessage& message, std::uint64_t at_most) const = 0;
};

struct OpenedPart {
  std::unique_ptr<BagPart> part;
  BagContents contents;
};

OpenedPart open_ros1_bag(const std::filesystem::path& path);
OpenedPart open_mcap(const std::filesystem::path& path);
OpenedPart open_sqlite_bag(const std::filesystem::path& path);
// True for an SQLite file that is a bag by its tables. A map file is none.
bool is_sqlite_bag(const std::filesystem::path& path);

// True for a file that is a bag by its first bytes or by its ending, and for a folder that holds such files. A map file is none.
bool is_bag(const std::filesystem::path& path);

class Bag {
 public:
  // A file, or a folder with the parts of a bag that was split. Throws Error for what is none, is packed or encrypted as a whole,
  // or was recorded at another time than the other parts, or twice.
  explicit Bag(const std::filesystem::path& path);

  const std::string& name() const { return name_; }
  const std::string& container() const { return container_; }  // "ROS 1 bag", "rosbag2 .db3", ".mcap"
  const std::vector<BagTopic>& topics() const { return contents_.topics; }
  const std::vector<BagMessage>& messages() const { return contents_.messages; }  // by time
  const std::vector<std::string>& left_out() const { return contents_.left_out; }

  // The message, or its first bytes. Throws Error if they are damaged, FileError if the disk fails.
  BagBytes read(const BagMessage& message, std::uint64_t at_most = UINT64_MAX) const;

 private:
  void add(const std::filesystem::path& path);
  void require_one_recording(const std::vector<std::filesystem::path>& files) const;

  std::string name_;
  std::string container_;
  BagContents contents_;
  std::vector<std::unique_ptr<BagPart>> parts_;
};

}  // namespace panoptic
