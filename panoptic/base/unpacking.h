// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Unpacking of bytes whose unpacked size a file claims: memory grows with what really comes out, so a lie costs none.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace panoptic {

using PackedBytes = std::span<const std::uint8_t>;
using UnpackedBytes = std::optional<std::vector<std::uint8_t>>;

// All three: exactly `size` bytes, or nothing if the stream is damaged, cut off, or of another size.
UnpackedBytes unpacked_lz4(PackedBytes packed, std::size_t size);  // LZ4's frame format
UnpackedBytes unpacked_bzip2(PackedBytes packed, std::size_t size);
UnpackedBytes unpacked_zstd(PackedBytes packed, std::size_t size);  // one frame or several

// The size that a zstd frame says of itself; nothing if it is none, or does not say.
std::optional<std::size_t> zstd_size(PackedBytes packed);

enum class Unpacking { kGoesOn, kDone, kDamaged };

// `step` fills the front of a span, says by `filled` how much that was, and returns how it stands.
template <typename Step>
UnpackedBytes unpacked_in_steps(std::size_t packed_size, std::size_t size, const Step& step) {
  constexpr std::size_t kFirst = 64 << 10;
  constexpr std::size_t kUsualRatio = 4;
  std::vector<std::uint8_t> bytes(std::min(size, std::max(kFirst, kUsualRatio * packed_size)));
  std::size_t done = 0;
  std::uint8_t beyond = 0;  // a byte more than was claimed
  while (true) {
    if (done == bytes.size() && done < size) bytes.resize(std::min(size, 2 * bytes.size()));
    const bool is_full = done == size;
    std::size_t filled = 0;
    const std::span<std::uint8_t> to = is_full ? std::span(&beyond, 1) : std::span(bytes).subspan(done);
    const Unpacking state = step(to, filled);
    if (is_full && filled > 0) return std::nullopt;
    done += filled;
    if (state == Unpacking::kDone) break;
    if (state == Unpacking::kDamaged) return std::nullopt;
  }
  return done == size ? UnpackedBytes(std::move(bytes)) : std::nullopt;
}

}  // namespace panoptic
