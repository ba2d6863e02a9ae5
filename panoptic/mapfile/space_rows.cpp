// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/space_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <sstream>

#include "panoptic/base/bytes.h"
#include "panoptic/map/space_cells.h"
#include "panoptic/mapfile/map_rows.h"

namespace panoptic {
namespace {

constexpr const char* kUseAnother = "the file is damaged: use another copy";
constexpr std::size_t kBytesPerCell = 4;
constexpr std::size_t kMostCells = std::size_t{kBlockCells} * kBlockCells;
constexpr std::size_t kBytesPerDoubt = 2 + 3 * 8 + 3 * 4;
constexpr std::size_t kMostBytes = 8 + kBytesPerCell * kMostCells + 4 + kBytesPerDoubt * kMostCells;
constexpr std::int64_t kMostTime = std::int64_t{1} << 60;
constexpr int kMostLog2 = 60;

void append_doubt(Bytes& bytes, const CellIndex& cell, const Doubt& doubt) {
  append_number(bytes, static_cast<std::uint8_t>(number_of(block_of(cell))));
  append_number(bytes, static_cast<std::uint8_t>(number_of(cell)));
  for (const std::uint64_t plane : doubt.count) append_number(bytes, plane);
  for (int a = 0; a < 3; ++a) append_number(bytes, doubt.seen_from_m[a]);
}

std::pair<CellIndex, Doubt> take_doubt(ByteReader& reader, BlockIndex chunk) {
  const int block = reader.take<std::uint8_t>() & (kBlockCells - 1);
  const int number = reader.take<std::uint8_t>() & (kBlockCells - 1);
  std::pair<CellIndex, Doubt> entry{cell_of(block_in(chunk, block), number), {}};
  for (std::uint64_t& plane : entry.second.count) plane = reader.take<std::uint64_t>();
  for (int a = 0; a < 3; ++a) entry.second.seen_from_m[a] = reader.take<float>();
  return entry;
}

// No cell was seen later than the last view.
bool is_within(const SpaceChunk& chunk, const SpaceView& view, int log2) {
  const std::uint64_t last_tick = (view.time >> log2) + 1;
  const auto fits = [&](std::uint32_t cell) { return empty_tick_of(cell) <= last_tick && occupied_tick_of(cell) <= last_tick; };
  return std::all_of(chunk.blocks.begin(), chunk.blocks.end(),
                     [&](const SpaceChunk::Cells& cells) { return std::all_of(cells.begin(), cells.end(), fits); });
}

struct SavedView {
  SpaceView view;
  int log2 = 0;
};

std::optional<SavedView> view_of_text(const std::string& text) {
  SavedView saved;
  std::int64_t time = -1;
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  in >> saved.log2 >> time;
  for (int a = 0; a < 3; ++a) in >> saved.view.camera_m[a];
  for (int a = 0; a < 3; ++a) in >> saved.view.axis[a];
  const bool whole = !in.fail() && (in >> std::ws).eof();
  if (!whole || saved.log2 < 0 || saved.log2 > kMostLog2 || time < 0 || time > kMostTime) return std::nullopt;
  saved.view.time = static_cast<std::uint64_t>(time);
  const bool fits = (saved.view.time >> saved.log2) < kMostTicks;
  return fits && saved.view.camera_m.allFinite() && saved.view.axis.allFinite() ? std::optional(saved) : std::nullopt;
}

// A chunk that is compressed best takes a few hundred times as much in memory.
void require_plausible_chunks(const Database& database) {
  constexpr std::int64_t kMostGrowth = 500;
  constexpr std::int64_t kAlwaysAllowed = 64 << 20;
  Statement row(database,
                "SELECT (SELECT count(*) FROM free_space), page_count * page_size FROM pragma_page_count, pragma_page_size");
  row.step();
  const std::int64_t chunks = row.integer(0);
  const std::int64_t file_bytes = row.integer(1);
  if (chunks <= (kMostGrowth * file_bytes + kAlwaysAllowed) / static_cast<std::int64_t>(kBytesPerCell * kMostCells)) return;
  database.refuse(
      fmt::format("it claims {} chunks of free space in {} bytes, more than any map; {}", chunks, file_bytes, kUseAnother));
}

}  // namespace

SpaceUpdate space_since(const FreeSpaceMap& space, std::uint64_t epoch) {
  return {space.last_view(), space.log2_frames_per_tick(), space.changed_since(epoch)};
}

Bytes encode_chunk(const SpaceChunk& chunk) {
  Bytes bytes;
  append_number(bytes, chunk.present);
  for (std::size_t plane = 0; plane < kBytesPerCell; ++plane) {
    for (const SpaceChunk::Cells& cells : chunk.blocks) {
      for (const std::uint32_t cell : cells) bytes.push_back(static_cast<std::uint8_t>(cell >> (8 * plane)));
    }
  }
  append_number(bytes, static_cast<std::uint32_t>(chunk.doubts.size()));
  for (const auto& [cell, doubt] : chunk.doubts) append_doubt(bytes, cell, doubt);
  return Compressor().compress(bytes);
}

const char* decode_chunk(std::span<const std::uint8_t> bytes, SpaceChunk& chunk) {
  Bytes payload(kMostBytes);
  const std::size_t size = Decompressor().decompress(bytes, payload);
  if (size == Decompressor::kDamaged) return "its bytes cannot be decompressed";
  ByteReader reader(std::span<const std::uint8_t>(payload.data(), size));
  chunk.present = reader.take<std::uint64_t>();
  chunk.blocks.assign(static_cast<std::size_t>(std::popcount(chunk.present)), SpaceChunk::Cells{});
  for (std::size_t plane = 0; plane < kBytesPerCell; ++plane) {
    for (SpaceChunk::Cells& cells : chunk.blocks) {
      for (std::uint32_t& cell : cells) cell |= std::uint32_t{reader.take<std::uint8_t>()} << (8 * plane);
    }
  }
  const auto doubts = reader.take<std::uint32_t>();
  if (reader.is_short() || doubts > kMostCells || reader.left() != doubts * kBytesPerDoubt)
    return "its bytes have another length";
  chunk.doubts.clear();
  for (std::uint32_t i = 0; i < doubts; ++i) chunk.doubts.push_back(take_doubt(reader, chunk.index));
  return FreeSpaceMap::is_sound(chunk) ? nullptr : "it holds what no map has";
}

void put_space(const Database& database, const SpaceUpdate& update) {
  Statement put(database, "INSERT OR REPLACE INTO free_space(x, y, z, checksum, cells) VALUES(?, ?, ?, ?, ?)");
  for (const SpaceChunk& chunk : update.chunks) {
    const Bytes encoded = encode_chunk(chunk);
    const auto& [x, y, z] = chunk.index;
    put.bind(std::int64_t{x}).bind(std::int64_t{y}).bind(std::int64_t{z}).bind(row_checksum({x, y, z}, encoded));
    put.bind(std::span<const std::uint8_t>(encoded)).run();
  }
}

std::string text_of_view(const SpaceUpdate& update) {
  if (!update.last_view) return "";
  const auto& [camera_m, axis, time] = *update.last_view;
  return fmt::format("{} {} {} {} {} {} {} {}", update.log2_frames_per_tick, time, camera_m.x(), camera_m.y(), camera_m.z(),
                     axis.x(), axis.y(), axis.z());
}

void read_space(const Database& database, const std::string& view, FreeSpaceMap& space) {
  require_plausible_chunks(database);
  const std::optional<SavedView> saved = view_of_text(view);
  if (!saved && !view.empty()) database.refuse(fmt::format("meta 'free_space' tells no view; {}", kUseAnother));
  if (saved) space.restore_view(saved->view, saved->log2);
  Statement row(database, "SELECT x, y, z, checksum, cells FROM free_space ORDER BY x, y, z");
  while (row.step()) {
    const auto coordinate = [&](int column) {
      return static_cast<std::int32_t>(row.integer(column, -kMaxBlockCoordinate, kMaxBlockCoordinate));
    };
    SpaceChunk chunk{{coordinate(0), coordinate(1), coordinate(2)}, 0, {}, {}};
    const auto bytes = row.bytes(4);
    const char* wrong = nullptr;
    if (row_checksum({chunk.index.x, chunk.index.y, chunk.index.z}, bytes) != row.integer(3)) {
      wrong = "its checksum is wrong";
    } else if (wrong = decode_chunk(bytes, chunk); wrong == nullptr && (!saved || !is_within(chunk, saved->view, saved->log2))) {
      wrong = "it was seen after the last view";
    }
    if (wrong != nullptr) {
      database.refuse(
          fmt::format("free space at ({}, {}, {}): {}; {}", chunk.index.x, chunk.index.y, chunk.index.z, wrong, kUseAnother));
    }
    space.put(chunk);
  }
}

}  // namespace panoptic
