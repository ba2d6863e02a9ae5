// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A frozen, complete, shared copy of the map for those who look at it. Whoever holds a Snapshot reads it without a lock, from
// any thread, for as long as it likes; mapping goes on meanwhile and publishes newer ones.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"
#include "panoptic/labels.h"
#include "panoptic/meshing/mesher.h"
#include "panoptic/online.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

// The surface in one block. The same index and version always mean the same content; a chunk that lost its surface stays,
// empty, with a new version.
struct SnapshotChunk {
  BlockIndex index;
  std::uint64_t version = 0;                 // the revision of the snapshot that first had this content
  std::shared_ptr<const MeshChunk> surface;  // never null
};

// The newest frame that was fused, and what was seen in it.
struct SnapshotFrame {
  std::int64_t index = -1;  // -1: no frame yet
  double time_s = 0;
  Camera color_camera;
  Pose world_from_color = Pose::Identity();       // the colour camera
  std::shared_ptr<const SharedImage<Rgb>> color;  // null: not kept (a finished result that is opened again)
  // The newest frame with labels, which may be older than `index`: its colours and the panoptic id of each of its colour
  // pixels.
  std::int64_t labelled_index = -1;
  std::shared_ptr<const SharedImage<Rgb>> labelled_color;
  std::shared_ptr<const Image<PanopticId>> labelled_ids;
};

struct StageTime {
  std::uint64_t count = 0;
  double p50_ms = 0;
  double p95_ms = 0;
  double last_ms = 0;
};

struct RunState {
  std::uint64_t frames_done = 0;   // positions of the recording that were read, used or not
  std::uint64_t frames_total = 0;  // 0 = not known (frames are pushed by an application)
  std::uint64_t frames_used = 0;
  std::uint64_t frames_labelled = 0;
  std::map<std::string, std::uint64_t> dropped;  // by the stage that was behind
  double geometry_hz = 0;                        // over the last seconds
  double label_hz = 0;
  double elapsed_s = 0;
  double memory_mb = 0;    // of the process now
  bool finished = false;   // no newer snapshot will come
  std::string stopped_by;  // why, if it ended before the recording did
  std::map<std::string, StageTime> stages;
};

struct Snapshot {
  std::uint64_t revision = 0;           // rises with every snapshot that is published; 0 = nothing yet
  std::vector<SnapshotChunk> chunks;    // by slot: in one run the chunk of a block keeps its place
  std::vector<SnapshotObject> objects;  // ascending ids; those with surface
  std::vector<Vec3f> path_m;            // where the camera was, thinned to at most kMaxPathPoints
  Vec3f up = Vec3f(0, -1, 0);           // upwards in the world, unit length, as far as it is known by now
  SnapshotFrame frame;
  RunState run;
};
inline constexpr std::size_t kMaxPathPoints = 20000;

// Facts that stay the same as long as a run lasts.
struct SnapshotScene {
  std::string title;    // "kitchen"
  std::string dataset;  // description of the recording
  LabelSet labels;
  float voxel_size_m = 0;
  float block_size_m = 0;
  bool has_confidence = true;  // false: a finished result that is opened again; its surface does not tell
};

// The newest snapshot. Thread-safe; both calls take a mutex for the time of copying a pointer.
class LatestSnapshot {
 public:
  void publish(std::shared_ptr<const Snapshot> snapshot) {
    const std::lock_guard lock(mutex_);
    latest_ = std::move(snapshot);
  }
  // Never null: before the first publish an empty one with revision 0.
  std::shared_ptr<const Snapshot> newest() const {
    const std::lock_guard lock(mutex_);
    return latest_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const Snapshot> latest_ = std::make_shared<const Snapshot>();
};

}  // namespace panoptic
