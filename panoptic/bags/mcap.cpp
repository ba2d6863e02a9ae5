// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// .mcap (https://mcap.dev/spec). The file is walked from record to record: what follows a chunk says where its messages lie. A
// chunk without that is unpacked and looked through; the summary at the end is not needed.
#include <fmt/format.h>

#include <map>
#include <utility>

#include "panoptic/bags/chunked.h"
#include "panoptic/base/bytes.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kMagicBytes = 8;
constexpr std::uint64_t kHeadBytes = 1 + 8;
constexpr std::uint64_t kMostSmallBytes = std::uint64_t{4} << 20;  // of a schema or a channel

enum Op : std::uint8_t { kFooter = 2, kSchema = 3, kChannel = 4, kMessage = 5, kChunk = 6, kMessageIndex = 7 };

// A string with its length before it, taken from the front.
std::string_view take_text(BagSpan& left) {
  const std::uint64_t bytes = ByteReader(left).take<std::uint32_t>();
  if (left.size() < sizeof(std::uint32_t) || bytes > left.size() - sizeof(std::uint32_t)) {
    left = {};
    return {};
  }
  const auto* text = reinterpret_cast<const char*>(left.data()) + sizeof(std::uint32_t);
  left = left.subspan(sizeof(std::uint32_t) + bytes);
  return {text, bytes};
}

template <typename Number>
Number take(BagSpan& left) {
  const Number number = ByteReader(left).take<Number>();
  left = left.subspan(std::min(sizeof(Number), left.size()));
  return number;
}

constexpr std::uint64_t kMessageHeadBytes = 2 + 4 + 8 + 8;  // channel, sequence, log time, publish time

std::optional<PayloadPlace> payload_of(BagSpan record) {
  if (record.size() < kHeadBytes + kMessageHeadBytes || take<std::uint8_t>(record) != kMessage) return std::nullopt;
  const auto bytes = take<std::uint64_t>(record);
  if (bytes < kMessageHeadBytes) return std::nullopt;
  return PayloadPlace{kHeadBytes + kMessageHeadBytes, bytes - kMessageHeadBytes};
}

struct Channel {
  std::uint16_t schema = 0;
  std::string topic;
  std::string encoding;
};

class Walk {
 public:
  explicit Walk(std::shared_ptr<const BagFile> file) : file_(std::move(file)), window_(*file_) {}

  OpenedPart part() {
    if (!walk()) {
      contents_.left_out.push_back(
          fmt::format("{}: cut off or damaged: no footer ends it, and what is not whole is left out", file_->name()));
    }
    look_through_chunks();
    name_topics();
    return {std::make_unique<ChunkedPart>(file_, std::move(chunks_), payload_of), std::move(contents_)};
  }

 private:
  // False if the file ends before its footer.
  bool walk() {
    std::uint64_t offset = kMagicBytes;
    while (true) {
      BagSpan head = window_.at(offset, kHeadBytes);
      if (head.size() < kHeadBytes) return false;
      const auto op = take<std::uint8_t>(head);
      const auto bytes = take<std::uint64_t>(head);
      if (op == kFooter) return true;
      const std::uint64_t data = offset + kHeadBytes;
      const bool is_whole = bytes <= file_->size() - data;
      if (op == kChunk) take_chunk(data, bytes, is_whole);
      if (!is_whole) return false;
      if (op == kMessageIndex) take_index(data, bytes);
      if (op == kMessage) take_message(window_.at(data, kMessageHeadBytes), kNoChunk, offset);
      if ((op == kSchema || op == kChannel) && bytes <= kMostSmallBytes) take_name(op, window_.at(data, bytes));
      offset = data + bytes;
    }
  }

  void take_name(std::uint8_t op, BagSpan left) {
    const auto id = take<std::uint16_t>(left);
    const auto schema = op == kSchema ? std::uint16_t{0} : take<std::uint16_t>(left);
    const std::string_view name = take_text(left);
    if (name.size() > kMostNameBytes) return;
    if (op == kSchema) {
      schemas_[id] = std::string(name);
      require_few_connections(schemas_.size(), *file_);
      return;
    }
    const std::string_view encoding = take_text(left);
    if (encoding.size() > kMostNameBytes) return;
    channels_[id] = {schema, std::string(name), std::string(encoding)};
    require_few_connections(channels_.size(), *file_);
  }

  void take_message(BagSpan head, std::uint32_t chunk, std::uint64_t place) {
    if (head.size() < kMessageHeadBytes) return;
    const auto channel = take<std::uint16_t>(head);
    take<std::uint32_t>(head);
    contents_.messages.push_back({static_cast<std::int64_t>(take<std::uint64_t>(head)), channel, 0, chunk, place});
    require_few_messages(contents_, *file_);
  }

  void take_chunk(std::uint64_t data, std::uint64_t bytes, bool is_whole) {
    constexpr std::uint64_t kMostHead = 8 + 8 + 8 + 4 + 4 + 64 + 8;
    BagSpan left = window_.at(data, std::min(bytes, kMostHead));
    const std::size_t given = left.size();
    take<std::uint64_t>(left);
    take<std::uint64_t>(left);
    BagChunk chunk;
    chunk.bytes = take<std::uint64_t>(left);
    take<std::uint32_t>(left);
    chunk.packing = packing_of(take_text(left), file_->name());
    chunk.packed_bytes = take<std::uint64_t>(left);
    chunk.offset = data + (given - left.size());
    const std::uint64_t room = file_->size() - std::min(file_->size(), chunk.offset);
    if (!is_whole && chunk.packing != ChunkPacking::kNone) return;
    if (chunk.packing == ChunkPacking::kNone) chunk.bytes = chunk.packed_bytes = std::min(chunk.packed_bytes, room);
    chunks_.push_back(chunk);
    is_indexed_.push_back(false);
  }

  // An index of one channel: time and offset of each message in the chunk before.
  void take_index(std::uint64_t data, std::uint64_t bytes) {
    constexpr std::uint64_t kStart = 2 + 4;
    constexpr std::uint64_t kEntryBytes = 16;
    if (bytes < kStart || chunks_.empty()) return;
    BagSpan start = window_.at(data, kStart);
    const auto channel = take<std::uint16_t>(start);
    const std::uint64_t count = std::min<std::uint64_t>(take<std::uint32_t>(start), bytes - kStart) / kEntryBytes;
    if (count > 0) is_indexed_.back() = true;
    for (std::uint64_t i = 0; i < count; ++i) {
      BagSpan entry = window_.at(data + kStart + i * kEntryBytes, kEntryBytes);
      const auto time = static_cast<std::int64_t>(take<std::uint64_t>(entry));
      contents_.messages.push_back(
          {time, channel, 0, static_cast<std::uint32_t>(chunks_.size() - 1), take<std::uint64_t>(entry)});
    }
  }

  // Messages of chunks without an index, and channels where the summary at the end of the file is missing.
  void look_through_chunks() {
    bool knows_all = true;
    for (const BagMessage& m : contents_.messages) knows_all = knows_all && knows(static_cast<std::uint16_t>(m.topic));
    for (std::uint32_t i = 0; i < chunks_.size(); ++i) {
      if (is_indexed_[i] && knows_all) continue;
      if (!look_through(i))
        contents_.left_out.push_back(fmt::format("{}: chunk {} is damaged: its messages are left out", file_->name(), i));
    }
  }

  bool knows(std::uint16_t channel) const {
    const auto found = channels_.find(channel);
    return found != channels_.end() && (found->second.schema == 0 || schemas_.contains(found->second.schema));
  }

  bool look_through(std::uint32_t i) {
    const BagFile::SharedBytes bytes = file_->unpacked(chunks_[i]);
    if (bytes == nullptr) return false;
    BagSpan left(*bytes);
    while (!left.empty()) {
      const auto place = static_cast<std::uint64_t>(left.data() - bytes->data());
      if (left.size() < kHeadBytes) return false;
      const auto op = take<std::uint8_t>(left);
      const auto size = take<std::uint64_t>(left);
      if (size > left.size()) return false;
      if (op == kSchema || op == kChannel) take_name(op, left.first(size));
      if (op == kMessage && !is_indexed_[i]) take_message(left.first(size), i, place);
      left = left.subspan(size);
    }
    return true;
  }

  // Channels become topics: several publishers may have one.
  void name_topics() {
    std::map<std::uint32_t, std::uint32_t> topic_of;
    for (const auto& [id, channel] : channels_) {
      const auto schema = schemas_.find(channel.schema);
      const std::string type = schema == schemas_.end() ? "" : schema->second;
      topic_of[id] = topic_index(contents_.topics, {channel.topic, type, channel.encoding, 0});
    }
    std::vector<BagMessage> known;
    known.reserve(contents_.messages.size());
    for (BagMessage& message : contents_.messages) {
      const auto found = topic_of.find(message.topic);
      if (found == topic_of.end()) continue;
      message.topic = found->second;
      known.push_back(message);
    }
    const std::size_t lost = contents_.messages.size() - known.size();
    if (lost > 0) contents_.left_out.push_back(fmt::format("{}: {} messages of no known channel", file_->name(), lost));
    contents_.messages = std::move(known);
  }

  std::shared_ptr<const BagFile> file_;
  BagWindow window_;
  BagContents contents_;
  std::vector<BagChunk> chunks_;
  std::vector<bool> is_indexed_;
  std::map<std::uint16_t, Channel> channels_;
  std::map<std::uint16_t, std::string> schemas_;
};

}  // namespace

OpenedPart open_mcap(const std::filesystem::path& path) { return Walk(std::make_shared<const BagFile>(path)).part(); }

}  // namespace panoptic
