// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// ROS 1 bags, version 2.0 (http://wiki.ros.org/Bags/Format/2.0). The file is walked from record to record: what follows a chunk
// says where its messages lie. A chunk without that (the bag was not closed) is unpacked and looked through.
#include <fmt/format.h>

#include <map>
#include <utility>

#include "panoptic/bags/chunked.h"
#include "panoptic/base/bytes.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint32_t kMostHeaderBytes = 64 << 10;
constexpr std::uint32_t kUsualHeadBytes = 1024;
constexpr std::int64_t kSecond_ns = 1'000'000'000;

enum Op : std::uint8_t { kMessage = 2, kBagHeader = 3, kIndex = 4, kChunk = 5, kConnection = 7 };

std::string_view text_of(BagSpan bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

// The value of "name=value" among the fields of a header; nothing if it is absent or they are damaged.
std::optional<BagSpan> field(BagSpan header, std::string_view name) {
  while (header.size() >= sizeof(std::uint32_t)) {
    const std::uint64_t bytes = ByteReader(header).take<std::uint32_t>();
    header = header.subspan(sizeof(std::uint32_t));
    if (bytes > header.size()) return std::nullopt;
    const BagSpan whole = header.first(bytes);
    header = header.subspan(bytes);
    const std::size_t equals = text_of(whole).find('=');
    if (equals == std::string_view::npos) return std::nullopt;
    if (text_of(whole).substr(0, equals) == name) return whole.subspan(equals + 1);
  }
  return std::nullopt;
}

template <typename Number>
std::optional<Number> number(BagSpan header, std::string_view name) {
  const auto value = field(header, name);
  if (!value || value->size() != sizeof(Number)) return std::nullopt;
  return ByteReader(*value).take<Number>();
}

std::int64_t to_time_ns(std::uint64_t stored) {
  return static_cast<std::int64_t>(stored & UINT32_MAX) * kSecond_ns + static_cast<std::int64_t>(stored >> 32);
}

// The head of a record: its fields, and where its data lies behind its beginning.
struct Record {
  std::uint8_t op = 0;
  BagSpan header;
  std::uint64_t data_offset = 0;
  std::uint64_t data_bytes = 0;
};

std::optional<Record> record_in(BagSpan bytes) {
  ByteReader reader(bytes);
  const std::uint64_t header_bytes = reader.take<std::uint32_t>();
  if (reader.is_short() || header_bytes > kMostHeaderBytes || header_bytes + sizeof(std::uint32_t) > reader.left())
    return std::nullopt;
  const BagSpan header = bytes.subspan(sizeof(std::uint32_t), header_bytes);
  const auto op = number<std::uint8_t>(header, "op");
  if (!op) return std::nullopt;
  const std::uint64_t data_bytes = ByteReader(bytes.subspan(sizeof(std::uint32_t) + header_bytes)).take<std::uint32_t>();
  return Record{*op, header, 2 * sizeof(std::uint32_t) + header_bytes, data_bytes};
}

std::optional<PayloadPlace> payload_of(BagSpan bytes) {
  const auto record = record_in(bytes);
  if (!record || record->op != kMessage) return std::nullopt;
  return PayloadPlace{record->data_offset, record->data_bytes};
}

class Walk {
 public:
  explicit Walk(std::shared_ptr<const BagFile> file) : file_(std::move(file)), window_(*file_) {}

  OpenedPart part() {
    std::uint64_t offset = kMagic.size();
    while (offset < file_->size()) {
      auto record = record_in(window_.at(offset, kUsualHeadBytes));
      if (!record) record = record_in(window_.at(offset, kMostHeaderBytes + 2 * sizeof(std::uint32_t)));
      const std::uint64_t left = file_->size() - offset;
      if (!record) {
        cut_off_at(offset);
        break;
      }
      const bool is_whole = record->data_offset <= left && record->data_bytes <= left - record->data_offset;
      if (!is_whole) cut_off_at(offset);
      take(*record, offset + record->data_offset, is_whole);
      if (!is_whole) break;
      offset += record->data_offset + record->data_bytes;
    }
    look_through_chunks();
    name_topics();
    return {std::make_unique<ChunkedPart>(file_, std::move(chunks_), payload_of), std::move(contents_)};
  }

 private:
  void cut_off_at(std::uint64_t offset) {
    contents_.left_out.push_back(fmt::format("{}: cut off or damaged at byte {} of {}: what comes after is left out",
                                             file_->name(), offset, file_->size()));
  }

  void take(const Record& record, std::uint64_t data, bool is_whole) {
    switch (record.op) {
      case kBagHeader:
        check_header(record.header);
        break;
      case kChunk:
        take_chunk(record, data, is_whole);
        break;
      case kIndex:
        if (is_whole) take_index(record, data);
        break;
      case kConnection:
        if (is_whole && record.data_bytes <= kMostConnectionBytes) {
          const BagBytes header(record.header.begin(), record.header.end());  // the window moves on
          take_connection(header, window_.at(data, record.data_bytes));
        }
        break;
      default:  // chunk infos, which the chunks themselves replace
        break;
    }
  }

  void check_header(BagSpan header) const {
    const auto encryptor = field(header, "encryptor");
    if (!encryptor || encryptor->empty() || text_of(*encryptor) == "rosbag/NoEncryptor") return;
    throw Error(
        fmt::format("{}: the bag is encrypted ({}); decrypt it first: rosbag decrypt FILE", file_->name(), text_of(*encryptor)));
  }

  void take_chunk(const Record& record, std::uint64_t data, bool is_whole) {
    const auto compression = field(record.header, "compression");
    const auto size = number<std::uint32_t>(record.header, "size");
    if (!compression || !size) return;
    BagChunk chunk{data, record.data_bytes, *size, packing_of(text_of(*compression), file_->name())};
    if (chunk.packing == ChunkPacking::kNone) chunk.bytes = chunk.packed_bytes;
    if (!is_whole && chunk.packing != ChunkPacking::kNone) return;
    if (!is_whole) chunk.packed_bytes = chunk.bytes = file_->size() - std::min(file_->size(), data);
    chunks_.push_back(chunk);
    is_indexed_.push_back(false);
  }

  // An index of one connection: time and offset of each message in the chunk before.
  void take_index(const Record& record, std::uint64_t data) {
    constexpr std::uint64_t kEntryBytes = 12;
    const auto connection = number<std::uint32_t>(record.header, "conn");
    if (!connection || chunks_.empty()) return;
    is_indexed_.back() = true;
    for (std::uint64_t i = 0; i < record.data_bytes / kEntryBytes; ++i) {
      ByteReader entry(window_.at(data + i * kEntryBytes, kEntryBytes));
      const std::int64_t time_ns = to_time_ns(entry.take<std::uint64_t>());
      contents_.messages.push_back({time_ns, *connection, 0, last_chunk(), entry.take<std::uint32_t>()});
    }
  }

  void take_connection(BagSpan header, BagSpan data) {
    const auto id = number<std::uint32_t>(header, "conn");
    const auto topic = field(header, "topic");
    const auto type = field(data, "type");
    if (!id || !topic || !type || topic->size() > kMostNameBytes || type->size() > kMostNameBytes) return;
    connections_[*id] = {std::string(text_of(*topic)), std::string(text_of(*type)), "ros1", 0};
    require_few_connections(connections_.size(), *file_);
  }

  std::uint32_t last_chunk() const { return static_cast<std::uint32_t>(chunks_.size() - 1); }

  // Messages of chunks without an index, and connections where the list at the end of the file is missing.
  void look_through_chunks() {
    bool knows_all = true;
    for (const BagMessage& m : contents_.messages) knows_all = knows_all && connections_.contains(m.topic);
    for (std::uint32_t i = 0; i < chunks_.size(); ++i) {
      if (is_indexed_[i] && knows_all) continue;
      if (!look_through(i))
        contents_.left_out.push_back(fmt::format("{}: chunk {} is damaged: its messages are left out", file_->name(), i));
    }
  }

  bool look_through(std::uint32_t i) {
    const BagFile::SharedBytes bytes = file_->unpacked(chunks_[i]);
    if (bytes == nullptr) return false;
    BagSpan left(*bytes);
    while (!left.empty()) {
      const auto record = record_in(left);
      if (!record || record->data_offset > left.size() || record->data_bytes > left.size() - record->data_offset) return false;
      const auto time = number<std::uint64_t>(record->header, "time");
      const auto connection = number<std::uint32_t>(record->header, "conn");
      if (record->op == kConnection) take_connection(record->header, left.subspan(record->data_offset, record->data_bytes));
      if (record->op == kMessage && time && connection && !is_indexed_[i]) {
        contents_.messages.push_back(
            {to_time_ns(*time), *connection, 0, i, static_cast<std::uint64_t>(left.data() - bytes->data())});
        require_few_messages(contents_, *file_);
      }
      left = left.subspan(record->data_offset + record->data_bytes);
    }
    return true;
  }

  // Connections become topics: several publishers may have one.
  void name_topics() {
    std::map<std::uint32_t, std::uint32_t> topic_of;
    for (const auto& [id, topic] : connections_) topic_of[id] = topic_index(contents_.topics, topic);
    std::vector<BagMessage> known;
    known.reserve(contents_.messages.size());
    for (BagMessage& message : contents_.messages) {
      const auto found = topic_of.find(message.topic);
      if (found == topic_of.end()) continue;
      message.topic = found->second;
      known.push_back(message);
    }
    const std::size_t lost = contents_.messages.size() - known.size();
    if (lost > 0) contents_.left_out.push_back(fmt::format("{}: {} messages of no known connection", file_->name(), lost));
    contents_.messages = std::move(known);
  }

  static constexpr std::uint64_t kMostConnectionBytes = std::uint64_t{4} << 20;

  std::shared_ptr<const BagFile> file_;
  BagWindow window_;
  BagContents contents_;
  std::vector<BagChunk> chunks_;
  std::vector<bool> is_indexed_;
  std::map<std::uint32_t, BagTopic> connections_;
};

}  // namespace

OpenedPart open_ros1_bag(const std::filesystem::path& path) {
  auto file = std::make_shared<const BagFile>(path);
  const BagBytes start = file->read(0, kMagic.size());
  if (text_of(start) != kMagic) {
    throw Error(fmt::format("{}: a bag of version '{}', only 2.0 can be read; convert it: rosbag fix", path.string(),
                            text_of(start).substr(0, text_of(start).find('\n'))));
  }
  return Walk(std::move(file)).part();
}

}  // namespace panoptic
