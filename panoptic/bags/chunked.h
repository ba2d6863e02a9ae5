// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The likeness of ROS 1 bags and .mcap: records one after the other, most of them in chunks that may be packed.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "panoptic/bags/bag.h"

namespace panoptic {

using BagSpan = std::span<const std::uint8_t>;

// Where the bytes of a message lie in its record. The record may be cut off behind its head.
struct PayloadPlace {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};
using FindPayload = std::optional<PayloadPlace> (*)(BagSpan record);

// Messages of a file with chunks; those without a chunk lie in the file itself.
class ChunkedPart : public BagPart {
 public:
  ChunkedPart(std::shared_ptr<const BagFile> file, std::vector<BagChunk> chunks, FindPayload find)
      : file_(std::move(file)), chunks_(std::move(chunks)), find_(find) {}

  std::optional<BagBytes> read(const BagMessage& message, std::uint64_t at_most) const override;

 private:
  std::optional<BagBytes> read_from_file(std::uint64_t offset, std::uint64_t end, std::uint64_t at_most) const;

  std::shared_ptr<const BagFile> file_;
  std::vector<BagChunk> chunks_;
  FindPayload find_;
};

// Reads a file from front to back in large pieces.
class BagWindow {
 public:
  explicit BagWindow(const BagFile& file) : file_(file) {}
  // Fewer bytes where the file ends; valid until the next call.
  BagSpan at(std::uint64_t offset, std::uint64_t bytes);

 private:
  const BagFile& file_;
  std::uint64_t begin_ = 0;
  BagBytes bytes_;
};

}  // namespace panoptic
