// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Chunks of the surface as browsers fetch them: quantised and compressed (docs/viewer_protocol.md). The one seam to
// meshoptimizer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <unordered_map>

#include "apps/viewer/surface.h"

namespace panoptic {

// Positions are whole steps of block size / kStepsPerBlock on one grid through the whole world, so that chunks meet exactly.
inline constexpr int kStepsPerBlock = 32768;

// One chunk of the message /api/chunks, its head included.
std::string encode_chunk(const SnapshotSurface& surface, std::size_t chunk, float block_size_m);

// The message: "PFC2", the number of chunks, the chunks.
std::string join_chunks(std::span<const std::shared_ptr<const std::string>> chunks);

// Keeps encoded chunks, so that several browsers cost one encoding; at most one thread encodes at a time. Bounded: the chunk
// that nobody asked for the longest goes first. Thread-safe.
class ChunkCache {
 public:
  ChunkCache(float block_size_m, std::size_t max_bytes) : block_size_m_(block_size_m), max_bytes_(max_bytes) {}

  std::shared_ptr<const std::string> encoded(const SnapshotSurface& surface, std::size_t chunk);

  void clear();
  std::size_t bytes() const;
  std::uint64_t encodings() const;  // how often it had to encode

 private:
  struct Entry {
    std::uint64_t block;
    std::uint64_t version;
    std::shared_ptr<const std::string> bytes;
  };
  void drop(std::list<Entry>::iterator entry);

  float block_size_m_;
  std::size_t max_bytes_;
  mutable std::mutex mutex_;
  std::list<Entry> entries_;                                                // the one that was asked for last first
  std::unordered_map<std::uint64_t, std::list<Entry>::iterator> entry_of_;  // by packed block index
  std::size_t bytes_ = 0;
  std::uint64_t encodings_ = 0;
};

}  // namespace panoptic
