// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "panoptic/base/compression.h"
#include "panoptic/base/config.h"
#include "panoptic/base/files.h"
#include "panoptic/base/sqlite.h"
#include "panoptic/error.h"
#include "panoptic/map/label_extents.h"
#include "panoptic/map/option_fields.h"
#include "panoptic/mapfile/block_codec.h"
#include "panoptic/mapfile/history_rows.h"
#include "panoptic/mapfile/image_rows.h"
#include "panoptic/mapfile/map_lock.h"
#include "panoptic/mapfile/map_rows.h"
#include "panoptic/mapfile/map_schema.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/mapfile/object_rows.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr const char* kUnits = "metres, seconds; the world of the recording's poses";

// The log is merged into the file once it has so many pages.
constexpr const char* kWriteAhead = "PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; PRAGMA wal_autocheckpoint = 8192;";
constexpr const char* kOneFile = "PRAGMA wal_checkpoint(TRUNCATE); PRAGMA journal_mode = DELETE;";

// Blocks that one task encodes: enough to pay for its encoder.
constexpr std::size_t kBlocksPerTask = 16;

void put_meta(Database& database, std::string_view key, std::string_view value) {
  Statement(database, "INSERT OR REPLACE INTO meta(key, value) VALUES(?, ?)").bind(key).bind(value).run();
}

void put_classes(Database& database, const LabelSet& labels) {
  Statement put(database,
                "INSERT INTO classes(id, name, is_thing, red, green, blue, max_size_m, is_support, is_mobile) "
                "VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const LabelClass& c : labels.classes()) {
    put.bind(std::int64_t{number(c.id)}).bind(c.name).bind(std::int64_t{c.is_thing});
    put.bind(std::int64_t{c.color.r}).bind(std::int64_t{c.color.g}).bind(std::int64_t{c.color.b});
    put.bind(c.max_size_m).bind(std::int64_t{c.is_support}).bind(std::int64_t{c.is_mobile}).run();
  }
}

void put_header(Database& database, const MapHeader& header) {
  MapOptions options = header.options;
  put_meta(database, kMetaUnits, kUnits);
  put_meta(database, kMetaMap, to_toml(grid_fields(options)));
  put_meta(database, kMetaLabelSet, header.labels.name());
  put_meta(database, kMetaEpoch, "1");
  put_meta(database, kMetaIdsGiven, "0");
  put_meta(database, kMetaSlotsGiven, "0");
  put_meta(database, kMetaRefused, "0");
  put_meta(database, kMetaCreated, "0");
  put_meta(database, kMetaFreeSpace, "");
  put_classes(database, header.labels);
}

Statement& bind_pose(Statement& statement, const Pose& pose) {
  const Vec3d place = pose.translation();
  const Eigen::Quaterniond turn(pose.linear());
  for (const double value : {place.x(), place.y(), place.z(), turn.w(), turn.x(), turn.y(), turn.z()}) statement.bind(value);
  return statement;
}

void put_frames(Database& database, const std::vector<FrameRecord>& frames) {
  Statement put(database,
                "INSERT OR REPLACE INTO frames(position, frame, time_s, labelled, unused_because, x_m, y_m, z_m, qw, qx, qy, qz) "
                "VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const FrameRecord& f : frames) {
    put.bind(f.position).bind(f.frame).bind(f.time_s).bind(std::int64_t{f.labelled});
    if (f.unused_because.empty()) {
      put.bind_null();
    } else {
      put.bind(std::string_view(f.unused_because));
    }
    if (f.world_from_camera) bind_pose(put, *f.world_from_camera);
    put.run();
  }
}

// The poses of frames that were used, as they are now.
void correct_frames(const Database& database, const std::vector<LogRow>& log) {
  Statement put(database,
                "UPDATE frames SET x_m = ?, y_m = ?, z_m = ?, qw = ?, qx = ?, qy = ?, qz = ? "
                "WHERE frame = ? AND unused_because IS NULL");
  for (const LogRow& row : log) bind_pose(put, row.entry.world_from_camera).bind(row.entry.frame).run();
}

// Removes the file with what SQLite may have left beside it.
void remove_database(const std::filesystem::path& path) {
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) std::filesystem::remove(path.string() + suffix, ignored);
}

std::vector<Bytes> encode_blocks(const std::vector<BlockCopy>& blocks, bool in_parallel) {
  std::vector<Bytes> encoded(blocks.size());
  const auto encode_task = [&](std::size_t task) {
    BlockEncoder encoder;
    const auto planes = std::make_unique_for_overwrite<BlockPlanes>();
    const std::size_t end = std::min(blocks.size(), (task + 1) * kBlocksPerTask);
    for (std::size_t i = task * kBlocksPerTask; i < end; ++i) {
      blocks[i].voxels->unpack(*planes);
      encoded[i] = encoder.encode(*planes);
    }
  };
  const std::size_t tasks = (blocks.size() + kBlocksPerTask - 1) / kBlocksPerTask;
  if (in_parallel) {
    parallel_for(tasks, encode_task);
  } else {
    for (std::size_t task = 0; task < tasks; ++task) encode_task(task);
  }
  return encoded;
}

void put_blocks(const Database& database, const std::vector<BlockCopy>& blocks, const std::vector<Bytes>& encoded) {
  Statement put(database,
                "INSERT OR REPLACE INTO blocks(slot, x, y, z, changed_at, checksum, voxels) VALUES(?, ?, ?, ?, ?, ?, ?)");
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto& [slot, index, changed_at, voxels] = blocks[i];
    const auto changed = static_cast<std::int64_t>(changed_at);
    const std::int64_t sum = row_checksum({slot, index.x, index.y, index.z, changed}, encoded[i]);
    put.bind(std::int64_t{slot}).bind(std::int64_t{index.x}).bind(std::int64_t{index.y}).bind(std::int64_t{index.z});
    put.bind(changed).bind(sum).bind(std::span<const std::uint8_t>(encoded[i])).run();
  }
}

}  // namespace

struct MapFileWriter::State {
  State(const std::filesystem::path& path, const MapHeader& header)
      : database(path, DatabaseAccess::kWrite),
        voxel_size_m(header.options.voxel_size_m),
        objects(database, double{header.options.voxel_size_m}) {}

  void put_states(const std::map<std::string, Bytes>& states);
  LabelExtents all_extents(const std::vector<BlockCopy>& blocks);

  std::optional<MapLock> lock;  // none of a file that nobody else knows of; outlives the connection
  Database database;
  float voxel_size_m;
  ObjectTableWriter objects;
  std::vector<LabelExtents> extents;             // by slot, as far as was written
  std::map<std::string, std::uint64_t> written;  // states: checksum of what was written last
};

void MapFileWriter::State::put_states(const std::map<std::string, Bytes>& states) {
  Statement put(database, "INSERT OR REPLACE INTO state(name, size, checksum, bytes) VALUES(?, ?, ?, ?)");
  for (const auto& [name, bytes] : states) {
    const std::uint64_t now = checksum(bytes);
    const auto before = written.find(name);
    if (before != written.end() && before->second == now) continue;
    const Bytes compressed = Compressor().compress(bytes);
    const auto size = static_cast<std::int64_t>(bytes.size());
    put.bind(std::string_view(name)).bind(size).bind(row_checksum({size}, compressed));
    put.bind(std::span<const std::uint8_t>(compressed)).run();
  }
}

// Extents in the whole map, with these blocks as they are now.
LabelExtents MapFileWriter::State::all_extents(const std::vector<BlockCopy>& blocks) {
  for (const BlockCopy& block : blocks) {
    if (block.slot >= extents.size()) extents.resize(std::size_t{block.slot} + 1);
    extents[block.slot] = label_extents(*block.voxels, block.index, voxel_size_m);
  }
  LabelExtents all;
  for (const LabelExtents& of_block : extents) {
    for (const auto& [label, extent] : of_block) all[label].add(extent);
  }
  return all;
}

MapFileWriter::MapFileWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
MapFileWriter::MapFileWriter(MapFileWriter&&) noexcept = default;
MapFileWriter& MapFileWriter::operator=(MapFileWriter&&) noexcept = default;

MapFileWriter::~MapFileWriter() {
  if (!state_) return;
  try {
    close();
  } catch (const std::exception&) {  // the log stays beside the file, and is read with it
  }
}

// A whole map under a name that nobody looks for, until it is given its own; then it is somebody's from the first moment.
class MapFileWriter::Aside {
 public:
  Aside(std::filesystem::path path, const MapHeader& header, const MapUpdate& update)
      : path_(std::move(path)), partial_(partial_beside(path_)) {
    if (is_there(path_.string() + "-wal") || is_there(path_.string() + "-journal")) {
      throw Error(fmt::format("{} is being written, or was when its run ended early: finish that run, or choose another name",
                              path_.string()));
    }
    remove_database(partial_);
    try {
      write(header, update);
    } catch (...) {
      remove_database(partial_);
      throw;
    }
  }
  ~Aside() { remove_database(partial_); }
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;

  [[nodiscard]] MapLock put_new() const {
    MapLock lock(partial_);
    if (rename_to_new(partial_, path_)) return lock;
    throw Error(fmt::format("{} is there already, made by another run just now; choose another name", path_.string()));
  }

  [[nodiscard]] MapLock put_over_old() const {
    MapLock lock(partial_);
    rename_file(partial_, path_);
    return lock;
  }

 private:
  void write(const MapHeader& header, const MapUpdate& update) const {
    {
      Database database(partial_, DatabaseAccess::kCreate);
      set_page_size(database);
      Transaction transaction(database);
      create_map_tables(database);
      put_header(database, header);
      transaction.commit();
    }
    auto state = std::make_unique<State>(partial_, header);
    state->database.execute(kWriteAhead);
    MapFileWriter writer(std::move(state));
    writer.write(update, true);
    writer.close();
  }

  std::filesystem::path path_;
  std::filesystem::path partial_;
};

MapFileWriter MapFileWriter::create(const std::filesystem::path& path, const MapHeader& header, const MapUpdate& update) {
  if (is_there(path)) throw Error(fmt::format("{} is there already; choose another name or remove it", path.string()));
  MapLock lock = Aside(path, header, update).put_new();
  return open(path, std::move(lock), load_map(path));
}

MapFileWriter MapFileWriter::open(const std::filesystem::path& path, MapLock lock, const SavedMap& saved) {
  if (saved.format != kMapFormat) {
    throw Error(fmt::format("{} has format {}, and what is written now has {}: it can be read and saved anew, not gone on with",
                            path.string(), saved.format, kMapFormat));
  }
  auto state = std::make_unique<State>(path, saved.header());
  state->lock.emplace(std::move(lock));
  state->database.execute(kWriteAhead);
  const VoxelMap& voxels = saved.map.voxels;
  state->extents.resize(voxels.block_count());
  parallel_for(voxels.block_count(), [&](std::size_t i) {
    const auto slot = static_cast<Slot>(i);
    state->extents[i] = label_extents(voxels.block(slot), voxels.index_of(slot), voxels.voxel_size_m());
  });
  return MapFileWriter(std::move(state));
}

void MapFileWriter::write(const MapUpdate& update, bool in_parallel) {
  Database& database = state_->database;
  const std::vector<Bytes> encoded = encode_blocks(update.blocks, in_parallel);
  if (update.anew) state_->extents.clear();
  auto rows = object_rows(update.objects, state_->all_extents(update.blocks));
  const RegistryState& registry = update.objects.state();
  try {
    Transaction transaction(database);
    if (update.anew) database.execute("DELETE FROM blocks; DELETE FROM free_space;");
    put_blocks(database, update.blocks, encoded);
    put_space(database, update.space);
    put_log(database, update.log);
    put_images(database, update.log);
    state_->objects.write(std::move(rows), registry);
    put_history(database, update.history);
    put_frames(database, update.frames);
    if (update.anew) correct_frames(database, update.log);
    state_->put_states(update.notes.states);
    put_meta(database, kMetaEpoch, std::to_string(update.epoch));
    put_meta(database, kMetaIdsGiven, std::to_string(number(registry.next_id) - update.objects.first_thing()));
    put_meta(database, kMetaSlotsGiven, std::to_string(registry.objects.size()));
    put_meta(database, kMetaRefused, std::to_string(registry.refused));
    put_meta(database, kMetaCreated, std::to_string(registry.created_since_retirement));
    if (update.space.last_view) put_meta(database, kMetaFreeSpace, text_of_view(update.space));
    for (const auto& [name, text] : update.notes.texts) put_meta(database, name, text);
    transaction.commit();
  } catch (...) {
    state_->objects.forget();
    throw;
  }
  for (const auto& [name, bytes] : update.notes.states) state_->written[name] = checksum(bytes);
}

void MapFileWriter::write_images(const std::vector<LogRow>& rows) {
  Transaction transaction(state_->database);
  put_images(state_->database, rows);
  transaction.commit();
}

void MapFileWriter::close() {
  const std::unique_ptr<State> state = std::move(state_);
  state->database.execute(kOneFile);
}

MapUpdate whole_map(const PanopticMap& map) {
  const VoxelMap& voxels = map.voxels;
  MapUpdate update{
      .epoch = voxels.epoch(), .space = space_since(map.free_space, 0), .objects = map.objects, .history = map.history};
  for (Slot slot = 0; slot < voxels.block_count(); ++slot) {
    update.blocks.push_back({slot, voxels.index_of(slot), voxels.changed_at(slot), &voxels.block(slot)});
  }
  return update;
}

void save_map(const std::filesystem::path& path, const MapHeader& header, const MapUpdate& update) {
  if (is_there(path)) {
    replace_map(MapLock(path), path, header, update);
  } else {
    const MapLock lock = MapFileWriter::Aside(path, header, update).put_new();
  }
}

void save_map(const std::filesystem::path& path, const SavedMap& saved, const std::vector<FrameRecord>& frames) {
  MapUpdate update = whole_map(saved.map);
  update.frames = frames;
  update.notes = saved.notes;
  save_map(path, saved.header(), update);
}

void replace_map(MapLock old, const std::filesystem::path& path, const MapHeader& header, const MapUpdate& update) {
  const MapLock held = std::move(old);
  const MapLock lock = MapFileWriter::Aside(path, header, update).put_over_old();
}

}  // namespace panoptic
