// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "panoptic/analysis/map_merge.h"
#include "panoptic/analysis/object_matching.h"
#include "panoptic/base/files.h"
#include "panoptic/base/version.h"
#include "panoptic/error.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/mapfile/run_notes.h"

namespace panoptic {
namespace {

// The notes of a map that matter to a merged one.
struct RunNotes {
  SavedState state;  // that `regularize` needs; a map that no run saved has none
  Vec3d up;
  bool complete = false;
  std::string recording;
  std::string options;
};

RunNotes run_notes(const MapWithFrames& map) {
  const SavedState state = map.saved.notes.states.empty() ? SavedState{} : saved_state(map.saved);
  return {state, up_of(map.saved), is_complete(map.saved), note_or_empty(map.saved, run_note::kRecording),
          note_or_empty(map.saved, run_note::kOptions)};
}

MapNotes merged_notes(const RunNotes& a, const RunNotes& b, std::int64_t frame_shift) {
  SavedState state;
  state.label_frames = a.state.label_frames + b.state.label_frames;
  state.labelled = a.state.labelled + b.state.labelled;
  state.last_frame = std::max(a.state.last_frame, b.state.last_frame + frame_shift);
  state.up_sum = a.state.up_sum + b.state.up_sum;
  MapNotes notes = notes_of(state);
  notes.texts[run_note::kUp] = up_text((a.up + b.up).norm() > 0 ? Vec3d((a.up + b.up).normalized()) : a.up);
  notes.texts[run_note::kProgram] = fmt::format("panoptic {}", version());
  notes.texts[run_note::kOptions] = a.options;
  notes.texts[run_note::kComplete] = a.complete && b.complete ? "1" : "0";
  notes.texts[run_note::kRecording] = fmt::format("{} + {}", a.recording, b.recording);
  notes.texts[run_note::kMerged] = "1";
  return notes;
}

}  // namespace

MapWithFrames load_map_with_frames(const std::filesystem::path& path) { return {load_map(path), load_frames(path)}; }

MergedFiles merge_map_files(const std::filesystem::path& a, const std::filesystem::path& b, const std::filesystem::path& merged,
                            bool align) {
  if (is_there(merged)) {
    throw Error(fmt::format("{} is there already; choose another name or remove it", merged.string()));
  }
  MapWithFrames first = load_map_with_frames(a);
  MapWithFrames second = load_map_with_frames(b);
  require_comparable(first.saved.header(), second.saved.header(), a.string(), b.string());
  MergedFiles summary{.objects_a = first.saved.map.objects.count(), .objects_b = second.saved.map.objects.count()};
  for (const std::string& note : {note_of_format(first.saved, a), note_of_format(second.saved, b)}) {
    if (!note.empty()) summary.notes.push_back(note);
  }
  if (const ObjectHistory& left = second.saved.map.history; !left.past.empty() || !left.arrivals.empty()) {
    summary.notes.push_back(
        fmt::format("{}: its history is left out: {} objects that were gone, and which of the others came or were moved",
                    b.string(), left.past.size()));
  }
  if (align) {
    summary.alignment = align_maps(first, second, a.string(), b.string());
    second = moved_map(second, summary.alignment->a_from_b);
  }
  const RunNotes notes_a = run_notes(first);
  const RunNotes notes_b = run_notes(second);
  const MapMerge merge = merge_maps(std::move(first), second, a.string(), b.string());
  const SavedMap& saved = merge.merged.saved;
  MapUpdate update = whole_map(saved.map);
  update.frames = merge.merged.frames;
  update.notes = merged_notes(notes_a, notes_b, merge.frame_shift);
  save_map(merged, saved.header(), update);
  summary.objects = saved.map.objects.count();
  summary.blocks = saved.map.voxels.block_count();
  for (const ObjectMatch& match : merge.matches) (match.kind == MatchKind::kSame ? summary.same : summary.parts)++;
  return summary;
}

}  // namespace panoptic
