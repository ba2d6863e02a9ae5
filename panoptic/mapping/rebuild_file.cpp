// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/rebuild_file.h"

#include <fmt/format.h>

#include <charconv>
#include <utility>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/map_file.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/frame_finder.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/run_outputs.h"

namespace panoptic {
namespace {

// The records of the map's frames, those that were used with the poses that they have now.
std::vector<FrameRecord> corrected(std::vector<FrameRecord> records, const FrameLog& log) {
  for (FrameRecord& record : records) {
    const auto n = record.unused_because.empty() ? log.find(record.frame) : std::nullopt;
    if (n) record.world_from_camera = log.entries()[*n].world_from_camera;
  }
  return records;
}

// A trajectory has poses of frames that could not be used, too: these are the times of all.
std::vector<FrameTime> times_of(const std::vector<FrameRecord>& records) {
  std::vector<FrameTime> times;
  for (const FrameRecord& record : records) times.push_back({record.frame, record.time_s});
  return times;
}

void require_log(const std::filesystem::path& map, const SavedMap& saved, const std::vector<FrameLog::Entry>& log) {
  if (saved.format < kOldestRebuiltFormat) throw Error(note_of_format(saved, map) + "; map the recording anew");
  if (!log.empty()) return;
  throw Error(
      fmt::format("{} has no log of its frames: it was merged from others, or made without (map.log); map the recording "
                  "anew, with map.log = reference or copy",
                  map.string()));
}

// Reads frames of the recording, if there is one.
ReadFrame reading(const Dataset* recording, const SavedMap& saved, const std::vector<FrameRecord>& records) {
  if (recording == nullptr) return {};
  FrameFinder finder(*recording);
  const std::string range = note_or_empty(saved, run_note::kFrames);
  finder.note(records, range.empty() ? FrameRange{} : parse_frame_range(range));
  return [finder = std::move(finder)](std::int64_t frame) { return finder.read(frame); };
}

}  // namespace

bool has_copies(const std::filesystem::path& map) {
  const LogSize log = size_of_log(map);
  return log.frames > 0 && log.copies == log.frames;
}

MappedRecording mapped_recording(const std::filesystem::path& map) {
  const SavedMap saved = load_map(map);
  MappedRecording mapped{note_or_empty(saved, run_note::kRecording), note_or_empty(saved, run_note::kCalibration), {}, {}};
  const std::string range = note_or_empty(saved, run_note::kFrames);
  mapped.is_part = !range.empty();
  mapped.complete = is_complete(saved);
  mapped.is_tracked = !note_or_empty(saved, run_note::kTracked).empty();
  if (mapped.is_part) mapped.range = parse_frame_range(range);
  if (mapped.recording.empty()) throw Error(fmt::format("{} does not say of which recording it was made", map.string()));
  const std::string tolerance = note_or_empty(saved, run_note::kPairTolerance);
  double value = 0;
  const auto [end, error] = std::from_chars(tolerance.data(), tolerance.data() + tolerance.size(), value);
  if (error == std::errc() && end == tolerance.data() + tolerance.size()) mapped.pair_tolerance_s = value;
  return mapped;
}

RebuiltFile rebuild_map_file(const std::filesystem::path& map, const std::filesystem::path& poses, const Dataset* recording,
                             const std::filesystem::path& output, const RebuildProgress& progress) {
  if (is_there(output)) throw Error(fmt::format("{} is there already: choose another name or remove it", output.string()));
  SavedMap saved = load_map(map);
  std::vector<FrameRecord> records = load_frames(map);
  std::vector<FrameLog::Entry> log = load_log(map);
  require_log(map, saved, log);
  const CorrectedPoses updates = read_corrected_poses(poses, times_of(records));

  const ReadFrame read = reading(recording, saved, records);
  MapperState state = mapper_state(saved, records, std::move(log));
  Mapper mapper(options_of(saved), saved.map.labels);
  const bool complete = is_complete(saved);
  const MapHeader header = saved.header();
  mapper.parts().restore(std::move(saved.map), std::move(state));
  RebuiltFile rebuilt;
  std::size_t done = 0;
  const ReadFrame read_and_tell = [&](std::int64_t frame) {
    if (progress) progress(done++, mapper.parts().log().size());
    return read(frame);
  };
  rebuilt.correction = mapper.parts().fuse_anew(updates.poses, read ? read_and_tell : read);
  if (rebuilt.correction.frames > 0 && complete) mapper.finish();
  rebuilt.used = mapper.frames().used();
  rebuilt.given = updates.poses.size() - rebuilt.correction.unknown;
  rebuilt.left_over = updates.left_over + rebuilt.correction.unknown;
  rebuilt.objects = mapper.map().objects.count();

  MapUpdate update = whole_map(mapper.map());
  update.frames = corrected(std::move(records), mapper.parts().log());
  update.log = log_since(mapper.parts().log(), 0);
  update.notes = notes_of(mapper.parts().state());
  for (const auto& [name, text] : saved.notes.texts) update.notes.texts.emplace(name, text);
  update.notes.texts[run_note::kUp] = up_text(mapper.up());
  update.notes.texts[run_note::kRebuilt] = std::filesystem::absolute(poses).lexically_normal().string();
  save_map(output, header, update);
  return rebuilt;
}

}  // namespace panoptic
