// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// rosbag2's .db3: an SQLite file with the tables `topics` and `messages`. Messages may be packed one by one (zstd).
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <mutex>
#include <utility>

#include "panoptic/bags/bag.h"
#include "panoptic/base/sqlite.h"
#include "panoptic/base/unpacking.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::string_view kKind = "rosbag2 file";

// A packed message begins with zstd's magic number, which no serialized one does: those begin with a zero.
bool is_packed(const BagBytes& bytes) {
  constexpr std::uint8_t kMagic[] = {0x28, 0xB5, 0x2F, 0xFD};
  return bytes.size() >= sizeof kMagic && std::equal(std::begin(kMagic), std::end(kMagic), bytes.begin());
}

bool has_tables(const Database& database) {
  Statement tables(database, "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name IN ('topics', 'messages')");
  return tables.step() && tables.integer(0) == 2;
}

class SqlitePart : public BagPart {
 public:
  explicit SqlitePart(const std::filesystem::path& path) : database_(path, DatabaseAccess::kRead, kKind) {}

  std::optional<BagBytes> read(const BagMessage& message, std::uint64_t at_most) const override {
    const std::scoped_lock lock(mutex_);
    const auto row = static_cast<std::int64_t>(message.place);
    auto bytes = database_.blob("messages", "data", row, at_most);
    if (!bytes || !is_packed(*bytes)) return bytes;
    if (at_most != UINT64_MAX) bytes = database_.blob("messages", "data", row, SIZE_MAX);
    const auto size = zstd_size(*bytes);
    if (!size || *size > kMostMessageBytes) return std::nullopt;
    UnpackedBytes unpacked = unpacked_zstd(*bytes, *size);
    if (unpacked && unpacked->size() > at_most) unpacked->resize(at_most);
    return unpacked;
  }

  Database& database() { return database_; }

 private:
  Database database_;
  mutable std::mutex mutex_;
};

}  // namespace

bool is_sqlite_bag(const std::filesystem::path& path) {
  try {
    return has_tables(Database(path, DatabaseAccess::kRead, kKind));
  } catch (const Error&) {
    return false;  // damaged: whoever opens it says so
  }
}

OpenedPart open_sqlite_bag(const std::filesystem::path& path) {
  auto part = std::make_unique<SqlitePart>(path);
  Database& database = part->database();
  if (!has_tables(database)) database.refuse("has no tables of topics and messages; is it a bag of ROS 2?");
  BagContents contents;
  std::map<std::int64_t, std::uint32_t> topic_of;
  Statement topics(database, "SELECT id, name, type, serialization_format FROM topics ORDER BY id");
  while (topics.step()) {
    const std::int64_t id = topics.integer(0);
    topic_of[id] =
        topic_index(contents.topics, {std::string(topics.text(1)), std::string(topics.text(2)), std::string(topics.text(3)), 0});
  }
  std::size_t lost = 0;
  Statement messages(database, "SELECT id, topic_id, timestamp FROM messages ORDER BY id");
  while (messages.step()) {
    const auto found = topic_of.find(messages.integer(1));
    if (found == topic_of.end()) {
      ++lost;
      continue;
    }
    contents.messages.push_back(
        {messages.integer(2), found->second, 0, kNoChunk, static_cast<std::uint64_t>(messages.integer(0))});
  }
  if (lost > 0) contents.left_out.push_back(fmt::format("{}: {} messages of no known topic", path.string(), lost));
  return {std::move(part), std::move(contents)};
}

}  // namespace panoptic
