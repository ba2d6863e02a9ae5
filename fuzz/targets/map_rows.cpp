// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Changed bytes of a file seldom get past SQLite. Here a sound map is changed through SQL, as somebody with bad intentions
// would, and its checksums are made to fit. The input: 1 byte of
// flags (1: leave the checksums wrong, 2: do not save what was loaded), then changes, each
//   1 byte   which cell, see kCells
//   1 byte   which row
//   1 byte   what kind of value
//   1 byte   its length n, then n bytes
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include "fuzz/input.h"
#include "fuzz/small_map.h"
#include "panoptic/base/files.h"
#include "panoptic/base/sqlite.h"
#include "panoptic/mapfile/map_rows.h"
#include "panoptic/mapfile/map_writer.h"

namespace panoptic::fuzz {
namespace {

struct Cell {
  const char* table;
  const char* key;
  const char* column;  // nullptr: the row is removed
};
constexpr Cell kCells[] = {{"meta", "key", "key"},
                           {"meta", "key", "value"},
                           {"meta", "key", nullptr},
                           {"classes", "id", "id"},
                           {"classes", "id", "name"},
                           {"classes", "id", "is_thing"},
                           {"classes", "id", "red"},
                           {"classes", "id", "max_size_m"},
                           {"classes", "id", nullptr},
                           {"blocks", "slot", "slot"},
                           {"blocks", "slot", "x"},
                           {"blocks", "slot", "changed_at"},
                           {"blocks", "slot", "checksum"},
                           {"blocks", "slot", "voxels"},
                           {"blocks", "slot", nullptr},
                           {"objects", "id", "id"},
                           {"objects", "id", "slot"},
                           {"objects", "id", "first_frame"},
                           {"objects", "id", "observations"},
                           {"objects", "id", "score_sum"},
                           {"objects", "id", "evidence"},
                           {"objects", "id", "ruled_out"},
                           {"objects", "id", "votes"},
                           {"objects", "id", "best_views"},
                           {"objects", "id", "parts"},
                           {"objects", "id", nullptr},
                           {"merged", "id", "id"},
                           {"merged", "id", "merged_into"},
                           {"left_slots", "slot", "slot"},
                           {"left_slots", "slot", "id"},
                           {"frames", "position", "position"},
                           {"frames", "position", "time_s"},
                           {"frames", "position", "labelled"},
                           {"frames", "position", "unused_because"},
                           {"frames", "position", "x_m"},
                           {"frames", "position", "qw"},
                           {"state", "name", "name"},
                           {"state", "name", "size"},
                           {"state", "name", "bytes"},
                           {"state", "name", nullptr}};

enum Kind : std::uint8_t { kInteger, kReal, kText, kBlob, kCompressed, kNull, kKinds };

std::int64_t integer_in(Input bytes) {
  std::array<std::uint8_t, 8> little{};
  std::memcpy(little.data(), bytes.data(), std::min(bytes.size(), little.size()));
  // Short values count from zero to both sides, so that small numbers of either sign are near.
  if (bytes.size() == 1) return static_cast<std::int8_t>(bytes[0]);
  return std::bit_cast<std::int64_t>(little);
}

void bind(Statement& statement, Kind kind, Input value) {
  static Compressor compressor;
  switch (kind) {
    case kInteger:
      statement.bind(integer_in(value));
      break;
    case kReal:
      statement.bind(value.size() < 8 ? static_cast<double>(integer_in(value)) : std::bit_cast<double>(integer_in(value)));
      break;
    case kText:
      statement.bind(text_of(value));
      break;
    case kBlob:
      statement.bind(value);
      break;
    case kCompressed:
      statement.bind(compressor.compress(value));
      break;
    default:
      statement.bind_null();
  }
}

void change(Database& database, const Cell& cell, int row, Kind kind, Input value) {
  const std::string where =
      std::string(" WHERE ") + cell.key + " = (SELECT " + cell.key + " FROM " + cell.table + " ORDER BY 1 LIMIT 1 OFFSET ?)";
  const std::string what = cell.column == nullptr ? std::string("DELETE FROM ") + cell.table
                                                  : std::string("UPDATE ") + cell.table + " SET " + cell.column + " = ?";
  Statement statement(database, what + where);
  if (cell.column != nullptr) bind(statement, kind, value);
  statement.bind(std::int64_t{row}).run();
}

void seal(Database& database) {
  Statement blocks(database, "SELECT slot, x, y, z, changed_at, voxels FROM blocks");
  Statement block_sum(database, "UPDATE blocks SET checksum = ? WHERE slot = ?");
  while (blocks.step()) {
    const std::int64_t slot = blocks.integer(0);
    const std::int64_t sum =
        row_checksum({slot, blocks.integer(1), blocks.integer(2), blocks.integer(3), blocks.integer(4)}, blocks.bytes(5));
    block_sum.bind(sum).bind(slot).run();
  }
  Statement states(database, "SELECT name, size, bytes FROM state");
  Statement state_sum(database, "UPDATE state SET checksum = ? WHERE name = ?");
  while (states.step()) state_sum.bind(row_checksum({states.integer(1)}, states.bytes(2))).bind(states.text(0)).run();
}

void apply(const std::filesystem::path& path, Input changes, bool is_sealed) {
  constexpr std::size_t kHead = 4;
  Database database(path, DatabaseAccess::kWrite);
  database.execute("PRAGMA journal_mode = MEMORY; PRAGMA synchronous = OFF;");
  Transaction transaction(database);
  while (changes.size() >= kHead) {
    const Cell& cell = kCells[changes[0] % std::size(kCells)];
    const std::size_t length = std::min<std::size_t>(changes[3], changes.size() - kHead);
    const Input value = changes.subspan(kHead, length);
    succeeds([&] { change(database, cell, changes[1] % 8, static_cast<Kind>(changes[2] % kKinds), value); });
    changes = changes.subspan(kHead + length);
  }
  if (is_sealed) seal(database);
  transaction.commit();
}

// Whatever was loaded can be saved and loaded again.
void save_and_load(const SavedMap& saved, std::vector<FrameRecord> frames, const std::filesystem::path& copy) {
  MapUpdate update = whole_map(saved.map);
  update.frames = std::move(frames);
  update.notes = saved.notes;
  save_map(copy, saved.header(), update);
  const SavedMap again = load_map(copy);
  require(again.map.voxels.hash() == saved.map.voxels.hash(), "a map survives saving and loading");
  require(again.map.objects.state() == saved.map.objects.state(), "objects survive saving and loading");
}

}  // namespace

void map_rows(Input input) {
  static const Scratch kScratch("map_rows");
  static const std::string kSound = [] {
    save_small_map(kScratch.path() / "sound.panoptic");
    return read_file(kScratch.path() / "sound.panoptic");
  }();
  if (input.empty()) return;
  const std::filesystem::path path = kScratch.put("a.panoptic", bytes_of(kSound));
  if (!succeeds([&] { apply(path, input.subspan(1), input[0] % 2 == 0); })) return;
  std::optional<SavedMap> saved;
  std::vector<FrameRecord> frames;
  const bool is_sound = succeeds([&] {
    saved = load_map(path);
    frames = load_frames(path);
  });
  if (!is_sound || (input[0] & 2) != 0) return;
  const auto again = [&] { save_and_load(*saved, std::move(frames), kScratch.path() / "copy.panoptic"); };
  require(succeeds(again), "a map that was loaded can be saved and loaded");
}

}  // namespace panoptic::fuzz
