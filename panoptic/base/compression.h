// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The seam to zstd: bytes in and out, with sizes that are known beforehand.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace panoptic {

using Bytes = std::vector<std::uint8_t>;

// FNV-1a of 64 bits; give an earlier checksum to go on from it.
constexpr std::uint64_t kEmptyChecksum = 0xCBF29CE484222325U;
std::uint64_t checksum(std::span<const std::uint8_t> bytes, std::uint64_t before = kEmptyChecksum);

// The nature of bytes. kNoise: it is their statistics that count, for hardly anything repeats; half the time.
enum class Contents : std::uint8_t { kRepeating, kNoise };

// Both keep their working memory: one per thread.
class Compressor {
 public:
  explicit Compressor(Contents contents = Contents::kRepeating);
  ~Compressor();
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;

  // One frame that holds the parts one after the other. Each has its own statistics, so put together what is alike.
  Bytes compress(std::span<const std::span<const std::uint8_t>> parts);
  Bytes compress(std::span<const std::uint8_t> bytes) { return compress(std::span(&bytes, 1)); }

 private:
  struct State;
  std::unique_ptr<State> state_;
};

class Decompressor {
 public:
  Decompressor();
  ~Decompressor();
  Decompressor(const Decompressor&) = delete;
  Decompressor& operator=(const Decompressor&) = delete;

  // Fills the front of `to` and returns how much that was; nothing if the frame is damaged or holds more than fits. Takes no
  // memory for what the frame claims.
  static constexpr std::size_t kDamaged = SIZE_MAX;
  std::size_t decompress(std::span<const std::uint8_t> frame, std::span<std::uint8_t> to);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
