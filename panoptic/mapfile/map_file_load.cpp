// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "panoptic/base/compression.h"
#include "panoptic/base/config.h"
#include "panoptic/base/sqlite.h"
#include "panoptic/error.h"
#include "panoptic/map/option_fields.h"
#include "panoptic/map_file.h"
#include "panoptic/mapfile/block_codec.h"
#include "panoptic/mapfile/history_rows.h"
#include "panoptic/mapfile/map_rows.h"
#include "panoptic/mapfile/map_schema.h"
#include "panoptic/mapfile/object_rows.h"
#include "panoptic/mapfile/space_rows.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr const char* kUseAnother = "the file is damaged: use another copy";
constexpr std::size_t kBlocksAtOnce = 512;
constexpr std::size_t kBlocksPerTask = 16;
// Blocks of real maps compress 3 times, and hardly touched ones 100 times.
constexpr std::uint64_t kMostGrowth = 500;
constexpr std::uint64_t kAlwaysAllowed = 64U << 20;
constexpr std::int64_t kMostEpoch = std::int64_t{1} << 60;
constexpr std::int64_t kMostNotes = 1000;

std::map<std::string, std::string> read_meta(Database& database) {
  std::map<std::string, std::string> meta;
  Statement row(database, "SELECT key, value FROM meta LIMIT 1000");
  while (row.step()) meta.emplace(row.text(0), row.text(1));
  return meta;
}

const std::string& meta_value(const Database& database, const std::map<std::string, std::string>& meta, const char* key) {
  const auto found = meta.find(key);
  if (found == meta.end()) database.refuse(fmt::format("meta lacks '{}'; {}", key, kUseAnother));
  return found->second;
}

std::int64_t meta_integer(const Database& database, const std::map<std::string, std::string>& meta, const char* key,
                          std::int64_t max) {
  const std::string& text = meta_value(database, meta, key);
  std::int64_t value = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0 || value > max) {
    database.refuse(fmt::format("meta '{}' is no whole number from 0 to {}; {}", key, max, kUseAnother));
  }
  return value;
}

LabelSet read_labels(Database& database, std::int64_t format, const std::string& name) {
  std::vector<LabelClass> classes;
  Statement row(database, fmt::format("SELECT id, name, is_thing, red, green, blue, max_size_m, is_support, {} FROM classes "
                                      "ORDER BY id LIMIT 1000",
                                      format < 5 ? "0" : "is_mobile")
                              .c_str());
  const auto channel = [&](int column) { return static_cast<std::uint8_t>(row.integer(column, 0, 255)); };
  while (row.step()) {
    LabelClass c;
    c.id = static_cast<ClassId>(row.integer(0, 1, 65535));
    c.name = std::string(row.text(1));
    c.is_thing = row.integer(2, 0, 1) != 0;
    c.color = {channel(3), channel(4), channel(5)};
    c.max_size_m = row.real(6);
    if (!std::isfinite(c.max_size_m) || c.max_size_m < 0)
      database.refuse(fmt::format("a class has no proper size; {}", kUseAnother));
    c.is_support = row.integer(7, 0, 1) != 0;
    c.is_mobile = row.integer(8, 0, 1) != 0;
    classes.push_back(std::move(c));
  }
  try {
    return {name, std::move(classes)};
  } catch (const Error& e) {
    database.refuse(fmt::format("its label set cannot be: {}", e.what()));
  }
}

MapHeader read_header(Database& database, std::int64_t format, const std::map<std::string, std::string>& meta) {
  MapHeader header;
  header.options.max_weight = 0;  // where the file says nothing there was no limit
  read_toml_text(meta_value(database, meta, kMetaMap), fmt::format("map file {}: meta 'map'", database.path().string()),
                 grid_fields(header.options));
  header.labels = read_labels(database, format, meta_value(database, meta, kMetaLabelSet));
  return header;
}

// A row of `blocks` on its way into the map.
struct BlockRow {
  Slot slot = 0;
  Bytes bytes;
  const char* wrong = nullptr;
};

// Rules that the blocks of a file must keep.
struct BlockRules {
  std::int64_t format;
  std::vector<bool> known_slots;  // by LabelSlot: what a voxel may hold
};

const char* decode_row(BlockDecoder& decoder, const BlockRow& row, const BlockRules& rules, VoxelBlock& block) {
  const auto planes = std::make_unique<BlockPlanes>();
  if (const char* wrong = decoder.decode(row.bytes, *planes)) return wrong;
  const bool known =
      std::all_of(planes->label.begin(), planes->label.end(), [&](std::uint16_t label) { return rules.known_slots[label]; });
  if (!known) return "a voxel has the slot of an object that is not there";
  block.pack(*planes);
  return nullptr;
}

void decode_rows(const Database& database, std::vector<BlockRow>& rows, VoxelMap& map, const BlockRules& rules) {
  parallel_for((rows.size() + kBlocksPerTask - 1) / kBlocksPerTask, [&](std::size_t task) {
    BlockDecoder decoder(rules.format);
    const std::size_t end = std::min(rows.size(), (task + 1) * kBlocksPerTask);
    for (std::size_t i = task * kBlocksPerTask; i < end; ++i) {
      rows[i].wrong = decode_row(decoder, rows[i], rules, map.block(rows[i].slot));
    }
  });
  for (const BlockRow& row : rows) {
    if (row.wrong != nullptr) database.refuse(fmt::format("block {}: {}; {}", row.slot, row.wrong, kUseAnother));
  }
  rows.clear();
}

void require_plausible_count(Database& database) {
  const auto blocks = static_cast<std::uint64_t>(database.integer("SELECT count(*) FROM blocks"));
  const auto file_bytes =
      static_cast<std::uint64_t>(database.integer("SELECT page_count * page_size FROM pragma_page_count, pragma_page_size"));
  if (blocks <= (kMostGrowth * file_bytes + kAlwaysAllowed) / sizeof(BlockPlanes)) return;
  database.refuse(fmt::format("it claims {} blocks in {} bytes, more than any map; {}", blocks, file_bytes, kUseAnother));
}

void read_blocks(Database& database, VoxelMap& map, std::int64_t epoch, const BlockRules& rules) {
  require_plausible_count(database);
  std::vector<BlockRow> rows;
  std::vector<std::uint64_t> changed_at;
  Statement row(database, "SELECT slot, x, y, z, changed_at, checksum, voxels FROM blocks ORDER BY slot");
  const auto coordinate = [&](int column) {
    return static_cast<std::int32_t>(row.integer(column, -kMaxBlockCoordinate, kMaxBlockCoordinate));
  };
  while (row.step()) {
    const auto slot = static_cast<Slot>(map.block_count());
    row.integer(0, slot, slot);
    const BlockIndex index{coordinate(1), coordinate(2), coordinate(3)};
    changed_at.push_back(static_cast<std::uint64_t>(row.integer(4, 1, epoch)));
    const auto bytes = row.bytes(6);
    if (row_checksum({slot, index.x, index.y, index.z, row.integer(4)}, bytes) != row.integer(5)) {
      database.refuse(fmt::format("block {}: its checksum is wrong; {}", slot, kUseAnother));
    }
    if (map.find(index) != nullptr) {
      database.refuse(fmt::format("block {}: it is at ({}, {}, {}), where there is one already; {}", slot, index.x, index.y,
                                  index.z, kUseAnother));
    }
    map.allocate(index);
    rows.push_back({slot, Bytes(bytes.begin(), bytes.end()), nullptr});
    if (rows.size() == kBlocksAtOnce) decode_rows(database, rows, map, rules);
  }
  decode_rows(database, rows, map, rules);
  map.restore_epochs(static_cast<std::uint64_t>(epoch), std::move(changed_at));
}

RegistryState read_registry(Database& database, std::int64_t format, const std::map<std::string, std::string>& meta,
                            std::uint16_t first_thing) {
  constexpr std::int64_t kMostIds = std::numeric_limits<std::uint32_t>::max();
  const std::int64_t most_slots = number(LabelSlot::kNoVote) - first_thing;
  const std::int64_t ids = meta_integer(database, meta, kMetaIdsGiven, format == 1 ? most_slots : kMostIds - first_thing);
  const std::int64_t slots = format == 1 ? ids : meta_integer(database, meta, kMetaSlotsGiven, std::min(ids, most_slots));
  const GivenCounts given{static_cast<std::uint32_t>(ids), static_cast<std::uint16_t>(slots)};
  RegistryState registry = read_objects(database, format, first_thing, given);
  registry.next_id = static_cast<PanopticId>(first_thing + ids);
  if (format > 1) registry.refused = static_cast<std::uint64_t>(meta_integer(database, meta, kMetaRefused, kMostEpoch));
  registry.created_since_retirement = static_cast<std::size_t>(meta_integer(database, meta, kMetaCreated, kMostEpoch));
  return registry;
}

// Flags by LabelSlot: the slots that a voxel may hold. Only in format 1 may it be the slot of an object that is no more.
std::vector<bool> known_slots(const RegistryState& registry, std::int64_t format, std::uint16_t first_thing) {
  std::vector<bool> known(kLabelSlots, false);
  std::fill_n(known.begin(), first_thing, true);
  for (std::size_t i = 0; i < registry.objects.size(); ++i) {
    known[first_thing + i] = format == 1 || registry.objects[i].id != PanopticId::kUnknown;
  }
  return known;
}

std::map<std::string, Bytes> read_states(Database& database) {
  constexpr std::int64_t kMostSize = 1 << 30;
  std::map<std::string, Bytes> states;
  Statement row(database, "SELECT name, size, checksum, bytes FROM state LIMIT 1000");
  Decompressor decompressor;
  while (row.step()) {
    const std::string name(row.text(0));
    const auto compressed = row.bytes(3);
    const std::int64_t size = row.integer(1, 0, kMostSize);
    if (row_checksum({size}, compressed) != row.integer(2)) {
      database.refuse(fmt::format("state '{}': its checksum is wrong; {}", name, kUseAnother));
    }
    // zstd packs at most 2^15 equal bytes into one, roughly.
    if (static_cast<std::uint64_t>(size) > (std::uint64_t{compressed.size()} << 16)) {
      database.refuse(fmt::format("state '{}' claims {} bytes; {}", name, size, kUseAnother));
    }
    Bytes bytes(static_cast<std::size_t>(size));
    if (decompressor.decompress(compressed, bytes) != bytes.size()) {
      database.refuse(fmt::format("state '{}' cannot be decompressed; {}", name, kUseAnother));
    }
    states.emplace(name, std::move(bytes));
  }
  return states;
}

}  // namespace

SavedMap load_map(const std::filesystem::path& path, const MapOptions& place) {
  Database database(path, DatabaseAccess::kRead);
  const std::int64_t format = require_map(database);
  Transaction snapshot(database, false);  // all of one moment, also while another process writes
  std::map<std::string, std::string> meta = read_meta(database);
  if (static_cast<std::int64_t>(meta.size()) >= kMostNotes) database.refuse(fmt::format("meta is too long; {}", kUseAnother));
  MapHeader header = read_header(database, format, meta);
  const std::uint16_t first = header.labels.first_thing();
  RegistryState registry = read_registry(database, format, meta, first);
  header.options.memory_limit_mb = place.memory_limit_mb;
  header.options.swap_folder = place.swap_folder;
  VoxelMap map(header.options);
  read_blocks(database, map, std::max<std::int64_t>(1, meta_integer(database, meta, kMetaEpoch, kMostEpoch)),
              {format, known_slots(registry, format, first)});
  FreeSpaceMap space(map.voxel_size_m());
  if (format > 2) read_space(database, meta_value(database, meta, kMetaFreeSpace), space);
  for (const char* name : kFormatNames) meta.erase(name);
  MapNotes notes{std::move(meta), read_states(database)};
  PanopticMap whole(std::move(header.labels), std::move(map), ObjectRegistry(first, std::move(registry)));
  whole.free_space = std::move(space);
  if (format > 4) whole.history = read_history(database, whole.labels);
  return {std::move(header.options), std::move(whole), std::move(notes), format};
}

std::string note_of_format(const SavedMap& saved, const std::filesystem::path& path) {
  const std::vector<std::string> lacks = lacks_of(saved.format);
  if (lacks.empty()) return "";
  return fmt::format("{} has format {}, which lacks {}", path.string(), saved.format, fmt::join(lacks, ", "));
}

std::vector<FrameRecord> load_frames(const std::filesystem::path& path) {
  Database database(path, DatabaseAccess::kRead);
  require_map(database);
  std::vector<FrameRecord> frames;
  Statement row(
      database,
      "SELECT position, frame, time_s, labelled, unused_because, x_m, y_m, z_m, qw, qx, qy, qz FROM frames ORDER BY position");
  while (row.step()) {
    FrameRecord record{.position = row.integer(0), .frame = row.integer(1)};
    record.time_s = row.is_null(2) ? 0 : row.real(2);
    record.labelled = row.integer(3, 0, 1) != 0;
    if (!row.is_null(4)) record.unused_because = std::string(row.text(4));
    if (!row.is_null(5)) {
      Pose pose = Pose::Identity();
      pose.translation() = Vec3d(row.real(5), row.real(6), row.real(7));
      pose.linear() = Eigen::Quaterniond(row.real(8), row.real(9), row.real(10), row.real(11)).normalized().toRotationMatrix();
      if (is_finite(pose)) record.world_from_camera = pose;
    }
    frames.push_back(std::move(record));
  }
  return frames;
}

}  // namespace panoptic
