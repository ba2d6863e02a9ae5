// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Saving a map: bit by bit while it grows, or at once.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "panoptic/map_file.h"
#include "panoptic/mapfile/log_rows.h"
#include "panoptic/mapfile/map_lock.h"
#include "panoptic/mapfile/space_rows.h"

namespace panoptic {

// A copy of a block, to be saved.
struct BlockCopy {
  Slot slot = 0;
  BlockIndex index;
  std::uint64_t changed_at = 0;
  const VoxelBlock* voxels = nullptr;
};

// The changes of a map since it was last saved.
struct MapUpdate {
  std::uint64_t epoch = 0;
  bool anew = false;                // blocks and free space of before are gone; all that there are now are given
  std::vector<BlockCopy> blocks;    // those that changed
  SpaceUpdate space;                // chunks that changed
  std::vector<LogRow> log;          // entries that changed
  ObjectRegistry objects{1};        // all of them
  ObjectHistory history;            // all of it
  std::vector<FrameRecord> frames;  // new ones
  MapNotes notes;                   // all of them
};
// The whole map as an update; valid as long as the map.
MapUpdate whole_map(const PanopticMap& map);

// Writes a map file bit by bit while the map grows. At every moment the file holds what the last successful write was given,
// also if the process is killed. Until it is closed nobody else can write the file. One thread at a time; not necessarily the one
// that the map belongs to. Throws Error.
class MapFileWriter {
 public:
  // Creates a file that holds this map from its first moment on. Refuses if there is a file of that name.
  static MapFileWriter create(const std::filesystem::path& path, const MapHeader& header, const MapUpdate& update);
  // Goes on in a file that was loaded as `saved` under the lock. Throws Error if that is of an older format.
  static MapFileWriter open(const std::filesystem::path& path, MapLock lock, const SavedMap& saved);

  MapFileWriter(const MapFileWriter&) = delete;
  MapFileWriter& operator=(const MapFileWriter&) = delete;
  MapFileWriter(MapFileWriter&&) noexcept;
  MapFileWriter& operator=(MapFileWriter&&) noexcept;
  ~MapFileWriter();  // as close, but says nothing

  // Writes all of it or, if it throws, nothing; then the next update must hold the changes of this one too. `in_parallel`:
  // encodes on all threads, else on the caller's alone, so that others are not disturbed.
  void write(const MapUpdate& update, bool in_parallel);

  // Writes the images of new entries of the log alone, all or nothing. They are of no use to anybody before `write` was given the
  // entries, and may be written again.
  void write_images(const std::vector<LogRow>& rows);

  // Merges the write-ahead log into the file: after that it is one file again. Nothing can be written any more.
  void close();

 private:
  struct State;
  class Aside;
  friend void save_map(const std::filesystem::path&, const MapHeader&, const MapUpdate&);
  friend void replace_map(MapLock, const std::filesystem::path&, const MapHeader&, const MapUpdate&);
  explicit MapFileWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// Saves a whole map at once; the file appears whole or not at all, and replaces an older one unless somebody writes that.
void save_map(const std::filesystem::path& path, const MapHeader& header, const MapUpdate& update);
// Saves a map in the place of the one that the lock is on.
void replace_map(MapLock old, const std::filesystem::path& path, const MapHeader& header, const MapUpdate& update);

}  // namespace panoptic
