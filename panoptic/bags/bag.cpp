// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/bags/bag.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "panoptic/bags/messages.h"
#include "panoptic/base/files.h"
#include "panoptic/base/text.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);

struct Container {
  std::string_view name;
  std::string_view ending;
  std::string_view magic;
  OpenedPart (*open)(const fs::path& path);
};

constexpr std::array<Container, 3> kContainers = {{{"ROS 1 bag", ".bag", "#ROSBAG V", open_ros1_bag},
                                                   {".mcap", ".mcap", "\x89MCAP0\r\n", open_mcap},
                                                   {"rosbag2 .db3", ".db3", kSqliteMagic, open_sqlite_bag}}};

constexpr std::int64_t kLastTime_ns = std::int64_t{1} << 62;  // in the year 2116

std::string first_bytes(const fs::path& path) {
  constexpr std::uint64_t kEnough = 16;
  const BagBytes bytes = BagFile(path).read(0, kEnough);
  return {bytes.begin(), bytes.end()};
}

// A database may also be a map.
const Container* container_of(const fs::path& path) {
  if (!is_file(path)) return nullptr;
  const std::string start = first_bytes(path);
  for (const Container& container : kContainers) {
    if (!start.starts_with(container.magic)) continue;
    const bool may_be_map = container.magic == kSqliteMagic && lower_case(path.extension().string()) != container.ending;
    return may_be_map && !is_sqlite_bag(path) ? nullptr : &container;
  }
  return nullptr;
}

bool ends_as_bag(const fs::path& path) {
  return std::any_of(kContainers.begin(), kContainers.end(), [&](const Container& c) {
    const std::string name = lower_case(path.filename().string());
    return name.ends_with(c.ending) || name.ends_with(std::string(c.ending) + ".zstd") ||
           name.ends_with(std::string(c.ending) + ".zst") || name.ends_with(std::string(c.ending) + ".lz4") ||
           name.ends_with(std::string(c.ending) + ".gz") || name.ends_with(std::string(c.ending) + ".bz2") ||
           name.ends_with(std::string(c.ending) + ".xz");
  });
}

struct Packer {
  std::string_view magic;
  const char* remedy;
};

// Refuses a file that is no container: says how it was packed as a whole, and what unpacks it.
[[noreturn]] void refuse(const fs::path& path) {
  static const std::array<Packer, 6> kPackers = {{{"\x1F\x8B", "gzip: gunzip FILE"},
                                                  {"BZh", "bzip2: bunzip2 FILE"},
                                                  {"\x28\xB5\x2F\xFD", "zstd: unzstd FILE"},
                                                  {std::string_view("\xFD\x37zXZ\0", 6), "xz: unxz FILE"},
                                                  {"\x04\x22\x4D\x18", "lz4: unlz4 FILE"},
                                                  {"PK\x03\x04", "zip: unzip FILE"}}};
  const std::string start = first_bytes(path);
  for (const Packer& packer : kPackers) {
    if (start.starts_with(packer.magic)) {
      throw Error(fmt::format("{}: the bag is compressed as a whole; unpack it first ({})", path.string(), packer.remedy));
    }
  }
  if (start.starts_with("#ROSRECORD") || start.starts_with("#ROSLOG"))
    throw Error(fmt::format("{}: a bag of an old version, only 2.0 can be read; convert it: rosbag fix", path.string()));
  throw Error(fmt::format(
      "{}: {}; copy it again, or record it anew", path.string(),
      start.empty() ? "the bag is empty" : "by its first bytes neither a ROS 1 bag nor .mcap nor .db3, or encrypted"));
}

std::vector<fs::path> parts_in(const fs::path& folder) {
  std::vector<fs::path> parts;
  for (const std::string& name : names_in_folder(folder)) {
    if (!name.starts_with('.') && ends_as_bag(name) && is_file(folder / name)) parts.push_back(folder / name);
  }
  return parts;
}

// "sensor_msgs/msg/Image" as "sensor_msgs/Image".
std::string short_type(std::string type) {
  constexpr std::string_view kMiddle = "/msg/";
  const std::size_t at = type.find(kMiddle);
  return at == std::string::npos ? type : type.replace(at, kMiddle.size(), "/");
}

// When the messages of a file, or of a topic in it, were recorded.
struct Span {
  std::uint32_t part = 0;
  std::int64_t begin_ns = INT64_MAX;
  std::int64_t end_ns = INT64_MIN;

  void take(std::int64_t time_ns) {
    begin_ns = std::min(begin_ns, time_ns);
    end_ns = std::max(end_ns, time_ns);
  }
};

std::vector<Span> spans_of(const std::vector<BagMessage>& messages, std::optional<std::uint32_t> topic) {
  std::map<std::uint32_t, Span> by_part;
  for (const BagMessage& m : messages) {
    if (topic && m.topic != *topic) continue;
    const auto span = by_part.try_emplace(m.part, Span{m.part}).first;
    span->second.take(m.time_ns);
  }
  std::vector<Span> spans;
  for (const auto& [part, span] : by_part) spans.push_back(span);
  std::stable_sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.begin_ns < b.begin_ns; });
  return spans;
}

// Files that lie in one folder by chance must not become one recording.
void require_no_gaps(std::vector<Span> spans, const std::vector<fs::path>& files, const std::string& folder) {
  constexpr std::int64_t kLongestGap_ns = 60'000'000'000;
  constexpr double kSeconds = 1e-9;
  for (std::size_t i = 1; i < spans.size(); ++i) {
    spans[i].end_ns = std::max(spans[i].end_ns, spans[i - 1].end_ns);
    const std::int64_t gap_ns = spans[i].begin_ns - spans[i - 1].end_ns;
    if (gap_ns <= kLongestGap_ns) continue;
    throw Error(fmt::format("{}: {} begins {:.0f} s after what is before it ends, so they are no parts of one bag; name one file",
                            folder, files[spans[i].part].filename().string(), static_cast<double>(gap_ns) * kSeconds));
  }
}

// A copy beside the bag would map everything twice. At the seam of two parts the order may be a little off.
void require_no_copies(const std::vector<Span>& spans, const std::vector<fs::path>& files, const std::string& folder) {
  constexpr std::int64_t kMostOverlap_ns = 1'000'000'000;
  for (std::size_t i = 1; i < spans.size(); ++i) {
    const Span& a = spans[i - 1];
    const Span& b = spans[i];
    const std::int64_t overlap_ns = std::min(a.end_ns, b.end_ns) - b.begin_ns;
    const std::int64_t shorter_ns = std::min(a.end_ns - a.begin_ns, b.end_ns - b.begin_ns);
    if (overlap_ns <= std::min(kMostOverlap_ns, shorter_ns / 2)) continue;
    throw Error(fmt::format("{}: {} and {} hold images of one topic at one time, so they are no parts of one bag; name one file",
                            folder, files[a.part].filename().string(), files[b.part].filename().string()));
  }
}

}  // namespace

void require_few_messages(const BagContents& contents, const BagFile& file) {
  if (contents.messages.size() <= most_messages(file.size())) return;
  throw Error(fmt::format("{}: {} bytes unpack to more than {} messages, which is no recording; the file is damaged", file.name(),
                          file.size(), most_messages(file.size())));
}

void require_few_connections(std::size_t connections, const BagFile& file) {
  if (connections <= kMostConnections) return;
  throw Error(fmt::format("{}: more than {} topics and publishers; record the topics of the cameras and the poses alone",
                          file.name(), kMostConnections));
}

std::uint32_t topic_index(std::vector<BagTopic>& topics, const BagTopic& topic) {
  const std::string type = short_type(topic.type);
  const auto found = std::find_if(topics.begin(), topics.end(), [&](const BagTopic& t) {
    return t.name == topic.name && t.type == type && t.serialization == topic.serialization;
  });
  if (found != topics.end()) return static_cast<std::uint32_t>(found - topics.begin());
  topics.push_back({topic.name, type, topic.serialization, 0});
  return static_cast<std::uint32_t>(topics.size() - 1);
}

bool is_bag(const fs::path& path) {
  if (is_folder(path)) return !parts_in(path).empty();
  return is_file(path) && (ends_as_bag(path) || container_of(path) != nullptr);
}

Bag::Bag(const fs::path& path) : name_(path.string()) {
  if (is_folder(path)) {
    for (const fs::path& part : parts_in(path)) add(part);
  } else {
    add(path);
  }
  for (const BagMessage& m : contents_.messages) ++contents_.topics[m.topic].messages;
  if (parts_.size() > 1) require_one_recording(parts_in(path));
  std::stable_sort(contents_.messages.begin(), contents_.messages.end(),
                   [](const BagMessage& a, const BagMessage& b) { return a.time_ns < b.time_ns; });
}

void Bag::require_one_recording(const std::vector<fs::path>& files) const {
  require_no_gaps(spans_of(contents_.messages, {}), files, name_);
  for (std::uint32_t topic = 0; topic < contents_.topics.size(); ++topic) {
    const std::string& type = contents_.topics[topic].type;
    if (type == kImageType || type == kCompressedImageType) require_no_copies(spans_of(contents_.messages, topic), files, name_);
  }
}

void Bag::add(const fs::path& path) {
  const Container* container = container_of(path);
  if (container == nullptr) refuse(path);
  if (!container_.empty() && container_ != container->name)
    throw Error(fmt::format("{}: bags of several kinds in one folder; name one file", name_));
  container_ = container->name;
  OpenedPart opened = container->open(path);
  std::vector<std::uint32_t> index_of;
  for (const BagTopic& topic : opened.contents.topics) index_of.push_back(topic_index(contents_.topics, topic));
  for (BagMessage message : opened.contents.messages) {
    message.time_ns = std::clamp<std::int64_t>(message.time_ns, 0, kLastTime_ns);
    message.topic = index_of[message.topic];
    message.part = static_cast<std::uint32_t>(parts_.size());
    contents_.messages.push_back(message);
  }
  contents_.left_out.insert(contents_.left_out.end(), opened.contents.left_out.begin(), opened.contents.left_out.end());
  parts_.push_back(std::move(opened.part));
}

BagBytes Bag::read(const BagMessage& message, std::uint64_t at_most) const {
  auto bytes = parts_[message.part]->read(message, at_most);
  if (bytes) return std::move(*bytes);
  throw Error(fmt::format("{}: a message of {} is damaged", name_, contents_.topics[message.topic].name));
}

}  // namespace panoptic
