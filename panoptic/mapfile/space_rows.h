// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Free space in a map file: a row per chunk, and the last view in `meta`. docs/map_format.md has the layout.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "panoptic/base/compression.h"
#include "panoptic/base/sqlite.h"
#include "panoptic/free_space.h"

namespace panoptic {

// The changes of free space since it was last saved.
struct SpaceUpdate {
  std::optional<SpaceView> last_view;  // none: nothing was ever recorded
  int log2_frames_per_tick = 0;
  std::vector<SpaceChunk> chunks;
};
SpaceUpdate space_since(const FreeSpaceMap& space, std::uint64_t epoch);

// The chunk, its place left out.
Bytes encode_chunk(const SpaceChunk& chunk);
// Fills everything but the place, which is given. Returns nullptr, or what is wrong with the bytes; the chunk then holds
// anything.
const char* decode_chunk(std::span<const std::uint8_t> bytes, SpaceChunk& chunk);

void put_space(const Database& database, const SpaceUpdate& update);
std::string text_of_view(const SpaceUpdate& update);

// Throws Error: damaged.
void read_space(const Database& database, const std::string& view, FreeSpaceMap& space);

}  // namespace panoptic
