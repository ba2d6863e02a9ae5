// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/bags/chunked.h"

#include <algorithm>
#include <utility>

namespace panoptic {
namespace {

constexpr std::uint64_t kHeadBytes = 4096;                      // holds the head of any record, and small messages whole
constexpr std::uint64_t kWindowBytes = std::uint64_t{8} << 10;  // small: most of a bag is jumped over

}  // namespace

std::optional<BagBytes> ChunkedPart::read(const BagMessage& message, std::uint64_t at_most) const {
  if (message.chunk == kNoChunk) return read_from_file(message.place, file_->size(), at_most);
  const BagChunk& chunk = chunks_[message.chunk];
  if (chunk.packing == ChunkPacking::kNone) {
    if (message.place >= chunk.bytes) return std::nullopt;
    return read_from_file(chunk.offset + message.place, chunk.offset + chunk.bytes, at_most);
  }
  const BagFile::SharedBytes bytes = file_->unpacked(chunk);
  if (bytes == nullptr || message.place >= bytes->size()) return std::nullopt;
  const BagSpan record = BagSpan(*bytes).subspan(message.place);
  const auto payload = find_(record);
  if (!payload || payload->offset > record.size() || payload->bytes > record.size() - payload->offset) return std::nullopt;
  const BagSpan found = record.subspan(payload->offset, std::min(payload->bytes, at_most));
  return BagBytes(found.begin(), found.end());
}

std::optional<BagBytes> ChunkedPart::read_from_file(std::uint64_t offset, std::uint64_t end, std::uint64_t at_most) const {
  if (offset >= end) return std::nullopt;
  const std::uint64_t record_bytes = end - offset;
  BagBytes head = file_->read(offset, std::min(record_bytes, kHeadBytes));
  const auto payload = find_(head);
  if (!payload || payload->offset > record_bytes || payload->bytes > record_bytes - payload->offset) return std::nullopt;
  const std::uint64_t wanted = std::min(payload->bytes, at_most);
  if (wanted > kMostMessageBytes) return std::nullopt;
  if (payload->offset + wanted <= head.size()) {
    const auto begin = head.begin() + static_cast<std::ptrdiff_t>(payload->offset);
    return BagBytes(begin, begin + static_cast<std::ptrdiff_t>(wanted));
  }
  BagBytes bytes = file_->read(offset + payload->offset, wanted);
  return bytes.size() == wanted ? std::optional(std::move(bytes)) : std::nullopt;
}

BagSpan BagWindow::at(std::uint64_t offset, std::uint64_t bytes) {
  if (offset < begin_ || offset + bytes > begin_ + bytes_.size()) {
    begin_ = offset;
    bytes_ = file_.read(offset, std::max(bytes, kWindowBytes));
  }
  const BagSpan from = BagSpan(bytes_).subspan(std::min<std::uint64_t>(offset - begin_, bytes_.size()));
  return from.first(std::min<std::uint64_t>(bytes, from.size()));
}

}  // namespace panoptic
