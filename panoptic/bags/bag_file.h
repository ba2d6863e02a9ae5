// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The open file of a bag: bytes at given places, and chunks that are unpacked when a message in them is asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/base/os.h"

namespace panoptic {

using BagBytes = std::vector<std::uint8_t>;

constexpr std::uint64_t kMostChunkBytes = std::uint64_t{1} << 30;    // packed or not
constexpr std::uint64_t kMostMessageBytes = std::uint64_t{1} << 28;  // four images of 64 Mi pixels

enum class ChunkPacking : std::uint8_t { kNone, kBzip2, kLz4, kZstd };

// How a chunk is packed by the name that bags give it. Throws Error, beginning with `place`, for a name that is not known.
ChunkPacking packing_of(std::string_view name, const std::string& place);

struct BagChunk {
  std::uint64_t offset = 0;  // of its packed bytes in the file
  std::uint64_t packed_bytes = 0;
  std::uint64_t bytes = 0;
  ChunkPacking packing = ChunkPacking::kNone;
};

// Threads may read at once.
class BagFile {
 public:
  explicit BagFile(const std::filesystem::path& path);  // throws FileError

  const std::string& name() const { return name_; }
  std::uint64_t size() const { return size_; }

  // The bytes at an offset: as many as there are, at most `bytes`. Throws FileError if the disk fails.
  BagBytes read(std::uint64_t offset, std::uint64_t bytes) const;

  // The unpacked bytes; nothing if they are damaged or the file ends before. Those used last are kept.
  using SharedBytes = std::shared_ptr<const BagBytes>;
  SharedBytes unpacked(const BagChunk& chunk) const;

 private:
  struct Kept {
    std::uint64_t offset = 0;
    SharedBytes bytes;
  };
  std::string name_;
  os::File file_;
  std::uint64_t size_ = 0;
  mutable std::mutex mutex_;
  mutable std::list<Kept> kept_;  // the one used last is in front
};

}  // namespace panoptic
