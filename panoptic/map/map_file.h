// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map as one SQLite file; docs/map_format.md describes it. Saving and loading gives the same map, bit for bit, with slots and
// epochs. Files are checked from end to end when they are loaded: whatever a file holds, loading it gives a sound map or an Error
// of one line, and takes no more memory than the file could need.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/base/geometry.h"
#include "panoptic/data/labels.h"
#include "panoptic/map/compression.h"
#include "panoptic/map/map_lock.h"
#include "panoptic/map/map_schema.h"
#include "panoptic/map/panoptic_map.h"

namespace panoptic {

// What became of a position of the recording.
struct FrameRecord {
  std::int64_t position = 0;  // counts the positions that were read, from 0
  std::int64_t frame = 0;     // its number in the recording
  double time_s = 0;
  std::optional<Pose> world_from_camera;  // none if it could not be read, or is not finite
  bool labelled = false;                  // it came with a prediction
  std::string unused_because;             // empty: it was used
};

// What never changes in a map file.
struct MapHeader {
  MapOptions options;
  LabelSet labels;
};

// What whoever saves a map keeps in it besides: texts and bytes by name. The names of the format itself (docs/map_format.md) are
// taken.
struct MapNotes {
  std::map<std::string, std::string> texts;
  std::map<std::string, Bytes> states;
};

struct SavedMap {
  MapOptions options;
  PanopticMap map;
  MapNotes notes;
  std::int64_t format = kMapFormat;  // of the file that it was loaded from

  MapHeader header() const { return {options, map.labels}; }
};

// One line for users about a map that was loaded from the file: what its older format lacks. Empty if it lacks nothing.
std::string note_of_format(const SavedMap& saved, const std::filesystem::path& path);

// Throws Error if the file is no sound map. `place` says by its memory_limit_mb and swap_folder how the map lies in memory.
SavedMap load_map(const std::filesystem::path& path, const MapOptions& place = {});
std::vector<FrameRecord> load_frames(const std::filesystem::path& path);

// A block as it is to be saved.
struct BlockCopy {
  Slot slot = 0;
  BlockIndex index;
  std::uint64_t changed_at = 0;
  const VoxelBlock* voxels = nullptr;
};

// What changed since the last time.
struct MapUpdate {
  std::uint64_t epoch = 0;
  std::vector<BlockCopy> blocks;    // those that changed; blocks never vanish
  ObjectRegistry objects{1};        // all of them
  std::vector<FrameRecord> frames;  // new ones
  MapNotes notes;                   // all of them
};
// Everything of a map; good as long as the map is.
MapUpdate whole_map(const PanopticMap& map);

// Writes a map file bit by bit while the map grows. At every moment the file holds what the last successful write was given,
// also if the process is killed. Until it is closed nobody else can write the file. One thread at a time; not necessarily the one
// that the map belongs to. Throws Error.
class MapFileWriter {
 public:
  // A new file that holds this map from its first moment on. Refuses if there is a file of that name.
  static MapFileWriter create(const std::filesystem::path& path, const MapHeader& header, const MapUpdate& update);
  // Goes on in a file that was loaded as `saved` under the lock. Throws Error if that is of an older format.
  static MapFileWriter open(const std::filesystem::path& path, MapLock lock, const SavedMap& saved);

  MapFileWriter(const MapFileWriter&) = delete;
  MapFileWriter& operator=(const MapFileWriter&) = delete;
  MapFileWriter(MapFileWriter&&) noexcept;
  MapFileWriter& operator=(MapFileWriter&&) noexcept;
  ~MapFileWriter();  // as close, but says nothing

  // All of it or, if it throws, nothing; then the next update must hold what this one did. `in_parallel`: encodes on all threads,
  // else on the caller's alone, so that others are not disturbed.
  void write(const MapUpdate& update, bool in_parallel);

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

// A whole map at once; the file appears whole or not at all, and replaces an older one unless somebody writes that.
void save_map(const std::filesystem::path& path, const MapHeader& header, const MapUpdate& update);
// The same in the place of the map that the lock is on.
void replace_map(MapLock old, const std::filesystem::path& path, const MapHeader& header, const MapUpdate& update);

}  // namespace panoptic
