// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/map_result.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "apps/panoptic/commands.h"
#include "panoptic/fusion/mesher.h"
#include "panoptic/session/checkpoint.h"
#include "panoptic/session/map_merging.h"
#include "panoptic/session/publisher.h"
#include "panoptic/session/session_notes.h"

namespace panoptic {
namespace {

std::string note(const SavedMap& saved, const char* name) {
  const auto found = saved.notes.texts.find(name);
  return found == saved.notes.texts.end() ? "" : found->second;
}

double probability_of_class(const ObjectRegistry& objects, LabelSlot slot) {
  const ClassId class_id = objects.class_of(slot);
  for (const ClassProbability& p : objects.probabilities(slot)) {
    if (p.class_id == class_id) return p.probability;
  }
  return 0;
}

std::vector<Vec3f> path_of(const std::vector<FrameRecord>& frames) {
  CameraPath path;
  for (const FrameRecord& frame : frames) {
    const bool used = frame.unused_because.empty() && frame.world_from_camera;
    if (used) path.add(frame.world_from_camera->translation().cast<float>());
  }
  return path.points();
}

}  // namespace

bool is_map_file(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

LabelledMap labelled_map(const std::string& path, std::vector<std::string>& warnings) {
  const SavedMap saved = load_map_and_tell(path);
  LabelledMap map;
  map.labels = saved.map.labels;
  map.voxel_size_m = saved.map.voxels.voxel_size_m();
  for (const Object& object : saved.map.objects.state().objects) {
    if (object.id == PanopticId::kUnknown) continue;
    const auto observations = static_cast<double>(object.observations);
    map.confidence[object.id] = object_confidence(probability_of_class(saved.map.objects, object.slot), observations);
  }
  Mesher mesher(options_of(saved).mesher);
  mesher.update(saved.map);
  map.mesh = mesher.assemble(saved.map);
  if (!is_complete(saved)) {
    warnings.push_back(fmt::format("{}: a checkpoint; this is the map of the first frames of its recording", path));
  }
  for (std::string& line : foreign_classes(map.labels)) warnings.push_back(std::move(line));
  return map;
}

// By way of a session that was brought to where the file is: then a map file looks as the run that wrote it did.
OpenedResult open_map_result(const std::string& path) {
  MapWithFrames map = load_map_with_frames(path);
  SavedMap& saved = map.saved;
  tell_note(note_of_format(saved, path));
  SessionState state = saved.notes.states.empty() ? SessionState{} : session_state(saved, map.frames);
  RunState run;
  run.frames_done = run.frames_total = map.frames.size();
  run.finished = true;
  if (!is_complete(saved)) run.stopped_by = "a checkpoint of a run that goes on, or ended early";
  const std::string recording = note(saved, "recording");
  const Vec3d up = up_of(saved);
  Options options = options_of(saved);
  options.map = saved.options;  // without the run's memory limit
  Session session(options, saved.map.labels);
  session.restore(std::move(saved.map), std::move(state));
  LatestSnapshot latest;
  SnapshotPublisher publisher(latest);
  SessionCapture capture = publisher.capture(session, std::move(run));
  capture.path_m = path_of(map.frames);
  capture.up = up.cast<float>();
  publisher.publish(std::move(capture));
  const std::string title = std::filesystem::path(path).stem().string();
  return {scene_of(session, title, recording.empty() ? path : recording), latest.newest()};
}

}  // namespace panoptic
