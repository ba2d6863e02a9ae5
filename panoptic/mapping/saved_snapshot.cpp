// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/saved_snapshot.h"

#include <utility>
#include <vector>

#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/publisher.h"

namespace panoptic {
namespace {

std::vector<Vec3f> path_of(const std::vector<FrameRecord>& frames) {
  CameraPath path;
  for (const FrameRecord& frame : frames) {
    const bool used = frame.unused_because.empty() && frame.world_from_camera;
    if (used) path.add(frame.world_from_camera->translation().cast<float>());
  }
  return path.points();
}

}  // namespace

// A mapper that is brought to where the file is publishes it.
SavedSnapshot open_snapshot(SavedMap saved, const std::vector<FrameRecord>& frames, const std::filesystem::path& path) {
  SavedSnapshot opened;
  opened.note = note_of_format(saved, path);
  MapperState state = saved.notes.states.empty() ? MapperState{} : mapper_state(saved, frames);
  RunState run;
  run.frames_done = run.frames_total = frames.size();
  run.finished = true;
  if (!is_complete(saved)) run.stopped_by = "a checkpoint of a run that goes on, or ended early";
  const std::string recording = note_or_empty(saved, run_note::kRecording);
  const Vec3d up = up_of(saved);
  Options options = options_of(saved);
  options.map = saved.options;  // without the run's memory limit
  Mapper mapper(options, saved.map.labels);
  mapper.parts().restore(std::move(saved.map), std::move(state));
  LatestSnapshot latest;
  SnapshotPublisher publisher(latest);
  MapCapture capture = publisher.capture(mapper, std::move(run));
  capture.path_m = path_of(frames);
  capture.up = up.cast<float>();
  publisher.publish(std::move(capture));
  opened.scene = scene_of(mapper, path.stem().string(), recording.empty() ? path.string() : recording);
  opened.snapshot = latest.newest();
  return opened;
}

}  // namespace panoptic
