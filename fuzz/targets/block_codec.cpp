// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/block_codec.h"

#include <cstring>
#include <memory>

#include "fuzz/input.h"

namespace panoptic::fuzz {
namespace {

// By bits: a weight of -0 is not one of 0.
bool is_same(const BlockPlanes& a, const BlockPlanes& b) {
  return std::memcmp(static_cast<const void*>(&a), static_cast<const void*>(&b), sizeof a) == 0;
}

void decode(Input bytes) {
  static BlockEncoder encoder;
  static BlockDecoder decoder;
  const auto block = std::make_unique<BlockPlanes>();
  if (decoder.decode(bytes, *block) != nullptr) return;
  const auto again = std::make_unique<BlockPlanes>();
  require(decoder.decode(encoder.encode(*block), *again) == nullptr, "what was encoded can be decoded");
  require(is_same(*block, *again), "a block survives saving and loading bit for bit");
}

}  // namespace

// The first byte says whether the rest is a block as it is stored, or what has still to be compressed: changed bytes within a
// compressed frame seldom get through zstd.
void block_codec(Input input) {
  if (input.empty()) return;
  static Compressor compressor;
  const Input rest = input.subspan(1);
  if (input[0] % 2 == 0) return decode(rest);
  decode(compressor.compress(rest));
}

}  // namespace panoptic::fuzz
