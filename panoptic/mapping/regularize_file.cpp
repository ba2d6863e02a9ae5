// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/regularize_file.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "panoptic/map_file.h"
#include "panoptic/mapfile/map_lock.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/mapper_parts.h"

namespace panoptic {
namespace {

// Saves the map in today's format, in the place of the file that it was loaded from.
void save_anew(const std::filesystem::path& path, MapLock lock, const SavedMap& saved, const LabelSet& labels, MapUpdate update) {
  update.frames = load_frames(path);
  if (saved.format >= kOldestRebuiltFormat) update.log = log_since(FrameLog(load_log(path), 0), 0);
  update.notes.texts.insert(saved.notes.texts.begin(), saved.notes.texts.end());
  update.notes.states.insert(saved.notes.states.begin(), saved.notes.states.end());
  update.notes.texts[run_note::kFromFormat] = std::to_string(saved.format);
  replace_map(std::move(lock), path, {saved.options, labels}, update);
}

// The right to write a map file: of an older format it is saved anew.
using MapOwner = std::variant<MapLock, MapFileWriter>;

// Writes everything that changed after that epoch into the file; the mapper has taken the saved map over. Returns how many
// blocks changed.
std::size_t write_changes(const std::filesystem::path& path, const SavedMap& saved, MapOwner& owner, const Mapper& mapper,
                          std::uint64_t before) {
  MapUpdate update = whole_map(mapper.map());
  update.notes = notes_of(mapper.parts().state());
  const auto is_unchanged = [&](const BlockCopy& block) { return block.changed_at <= before; };
  const auto unchanged = static_cast<std::size_t>(std::count_if(update.blocks.begin(), update.blocks.end(), is_unchanged));
  const std::size_t changed = update.blocks.size() - unchanged;
  if (MapLock* lock = std::get_if<MapLock>(&owner)) {
    save_anew(path, std::move(*lock), saved, mapper.map().labels, std::move(update));
    return changed;
  }
  std::erase_if(update.blocks, is_unchanged);
  update.space.chunks.clear();
  MapFileWriter& writer = std::get<MapFileWriter>(owner);
  writer.write(update, true);
  writer.close();
  return changed;
}

}  // namespace

RegularizedFile regularize_map_file(const std::filesystem::path& path, const std::vector<std::string>& settings) {
  MapOwner owner = MapLock(path);
  SavedMap saved = load_map(path);
  Options options = options_of(saved);
  for (const std::string& setting : settings) set_option(options, setting);
  options.regularizer.enabled = true;
  if (saved.format == kMapFormat) owner = MapFileWriter::open(path, std::get<MapLock>(std::move(owner)), saved);
  MapperState state = mapper_state(saved, load_frames(path));
  state.regularizer.handled.clear();  // all of it, from what the frames voted for
  const std::uint64_t before = saved.map.voxels.epoch();
  Mapper mapper(options, saved.map.labels);
  mapper.parts().restore(std::move(saved.map), std::move(state));
  if (saved.format != kMapFormat) mapper.parts().forget_votes_without_voxels();  // they may be of objects that are no more
  mapper.regularize();
  if (is_complete(saved)) mapper.parts().forget_votes_without_voxels();
  RegularizedFile file;
  file.note = note_of_format(saved, path);
  file.changed = write_changes(path, saved, owner, mapper, before);
  file.blocks = mapper.map().voxels.block_count();
  file.objects = mapper.map().objects.count();
  return file;
}

}  // namespace panoptic
