// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Encodes voxel blocks in few bytes, bit for bit: voxels that hold nothing cost nothing, the others are predicted from their
// neighbours and what is left is compressed. docs/map_format.md has the layout.
#pragma once

#include <cstdint>
#include <span>

#include "panoptic/base/compression.h"
#include "panoptic/mapfile/map_schema.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

// Keeps working memory: use one per thread.
class BlockEncoder {
 public:
  Bytes encode(const BlockPlanes& block);

 private:
  Compressor compressor_;
  Bytes payload_;
};

class BlockDecoder {
 public:
  // Decodes blocks of that format. Format 1 has no sum of votes, which is then made up (votes_of_format_1).
  explicit BlockDecoder(std::int64_t format = kMapFormat) : format_(format) {}

  // Decodes into a block that holds nothing. Returns nullptr, or what is wrong with the bytes; the block then holds anything.
  // Whatever the bytes are, it takes no more time and memory than an ordinary block. Distances and weights are finite, weights
  // not negative, and no label weighs more than all votes.
  const char* decode(std::span<const std::uint8_t> bytes, BlockPlanes& block);

 private:
  std::int64_t format_;
  Decompressor decompressor_;
  Bytes payload_;
};

}  // namespace panoptic
