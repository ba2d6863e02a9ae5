// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Freezes the state of a mapper into snapshots (mapping/snapshot.h) while it goes on mapping.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/mapper.h"
#include "panoptic/mapping/snapshot.h"
#include "panoptic/profile.h"

namespace panoptic {

// A frame with a prediction whose labels are in the map.
struct LabelledFrame {
  std::shared_ptr<const Frame> frame;
  std::shared_ptr<const Segmentation> segmentation;
  std::vector<PanopticId> segment_ids;  // Mapper::segment_ids after it was added
};

// Where the camera was: never more than kMaxPathPoints, as evenly as that allows, and the newest place.
class CameraPath {
 public:
  void add(const Vec3f& place_m);
  std::vector<Vec3f> points() const;

 private:
  std::vector<Vec3f> kept_;
  Vec3f newest_ = Vec3f::Zero();
  std::uint64_t seen_ = 0;
  std::uint64_t every_ = 1;  // every so many places one is kept
};

// The parts of the mapper that a snapshot needs, copied in a moment: chunks by pointer, objects, counters.
struct MapCapture {
  std::vector<SnapshotChunk> chunks;    // by slot, without versions
  std::vector<SnapshotObject> objects;  // without what their surface tells
  std::vector<Vec3f> path_m;
  Vec3f up = Vec3f::Zero();
  SnapshotFrame frame;
  std::optional<LabelledFrame> labelled;
  RunState run;
};

// In three steps, so that mapping has to pause for the second one alone: `fused` and `labelled` note what was added to the
// mapper, `capture` copies, `publish` builds the snapshot. Costs nothing but the notes while nobody captures, and changes
// nothing in the map. fused, labelled and capture: one thread at a time, with the mapper to themselves. publish: one thread at a
// time; it may run beside the others.
class SnapshotPublisher {
 public:
  explicit SnapshotPublisher(LatestSnapshot& latest) : latest_(latest) {}

  void fused(std::shared_ptr<const Frame> frame);
  void labelled(LabelledFrame frame) { labelled_ = std::move(frame); }

  // Brings the surface up to date. `run`: what the mapper does not know (positions read, rates, drops); frames used and
  // labelled, stage times and memory are filled in here.
  MapCapture capture(Mapper& mapper, RunState run);

  void publish(MapCapture capture);

 private:
  // The surface of one object in one chunk.
  struct ObjectPart {
    PanopticId id = PanopticId::kUnknown;
    std::uint64_t vertices = 0;
    Vec3f min_m = Vec3f::Zero();
    Vec3f max_m = Vec3f::Zero();
  };
  static std::vector<ObjectPart> parts_of(const MeshChunk& chunk);
  void take_up_chunks(const MapCapture& capture, Snapshot& snapshot);
  void measure_objects(MapCapture& capture, Snapshot& snapshot) const;
  void follow_poses(const MapperParts& mapper);

  LatestSnapshot& latest_;
  std::shared_ptr<const Frame> newest_;
  std::optional<LabelledFrame> labelled_;
  CameraPath path_;
  std::uint64_t times_anew_ = 0;  // MapperParts::times_anew of the poses here
  std::uint64_t revision_ = 0;
  std::vector<SnapshotChunk> chunks_;           // of the last snapshot
  std::vector<std::vector<ObjectPart>> parts_;  // of each of them
};

StageTime stage_time(const DurationHistogram& times);

// Facts that stay the same as long as the run lasts. `title`: the name of the recording.
SnapshotScene scene_of(const Mapper& mapper, std::string title, std::string dataset);

}  // namespace panoptic
