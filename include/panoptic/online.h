// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Mapping while frames arrive: every stage on a thread of its own (docs/online.md).
//
//   push ──▶ queue ──▶ fusion ──▶ Mapper  ◀── regularizer   every regularize_every_s, beside the mapping
//     │                  ▲          │
//     ▼                  │          ▼
//   newest frame ──▶ networks     mesher and publisher      every mesh_every_s
//                    side by side
//
// Depth and colour of every frame are integrated as it comes; its labels, if the networks had time for it, when its prediction is
// there, with that frame's own pose. What is dropped: a frame that comes while `waiting_frames` wait for fusion is dropped whole;
// of the frames that come while the networks are at work, the newest alone is predicted, and the others stay without labels.
//
// Corrected poses (update_poses, loops of a tracker) are followed by fusion, in a new map beside the old one: who looks on sees
// the old one until they change places, and frames wait.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/labels.h"
#include "panoptic/mesh.h"
#include "panoptic/options.h"
#include "panoptic/pose_update.h"
#include "panoptic/predictor.h"
#include "panoptic/profile.h"
#include "panoptic/segmentation.h"
#include "panoptic/source.h"

namespace panoptic {

// An object of a published map: one that has surface.
struct SnapshotObject {
  PanopticId id = PanopticId::kUnknown;
  ClassId class_id = ClassId::kUnknown;
  std::vector<ClassProbability> probabilities;  // Eq. 12, sorted by class id
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
  std::uint64_t observations = 0;
  std::uint64_t vertices = 0;   // of the surface; chunk borders count twice
  Vec3f min_m = Vec3f::Zero();  // axis-aligned box of those vertices, world
  Vec3f max_m = Vec3f::Zero();
};

// The map as it was published last: a copy that stays as it is.
struct PublishedMap {
  std::uint64_t revision = 0;           // rises with every snapshot; 0 = nothing yet
  std::int64_t frame = -1;              // the newest frame in it; -1: none
  Mesh mesh;                            // vertices on the border of two blocks are there twice
  std::vector<SnapshotObject> objects;  // ascending ids
  std::vector<Vec3f> path_m;            // where the camera was, thinned
  bool finished = false;                // no newer one will come
};

class LatestSnapshot;
class Mapper;
class RunRecorder;
class RunTracker;

// How an online run went. Every frame that was read was used, skipped or dropped.
struct OnlineReport {
  std::uint64_t read = 0;     // frames and skipped positions that were handed over
  std::uint64_t used = 0;     // for geometry
  std::uint64_t skipped = 0;  // unusable
  std::uint64_t dropped = 0;  // since fusion was behind
  std::uint64_t lost = 0;     // handed over, but a failure or the end came first
  // Counts of the frames that were used:
  std::uint64_t labelled = 0;
  std::uint64_t passed_over = 0;  // since the networks were busy with another
  double geometry_hz = 0;         // from the first to the last
  double label_hz = 0;
  std::vector<Correction> corrections;  // in their order
  Profile latency;                      // since the frame was read: "fused", "labelled", "visible" (in a published snapshot)
  std::string stopped_by;               // why, if it ended early; else empty
  std::exception_ptr failure;           // what a stage threw: the map holds what was fused by then; else null
};

// Threads: all may be called from any thread, but finish and the destructor from the one that made the pipeline. From
// construction until finish returns the pipeline alone uses the mapper and the predictor.
class OnlinePipeline {
 public:
  // `predictor`: nullptr for geometry and colour alone. `latest`: where snapshots go; nullptr: nobody looks on. `total`: frames
  // that will be pushed, for those who look on; 0 = not known.
  struct Parts {
    Mapper& mapper;
    Predictor* predictor = nullptr;
    LatestSnapshot* latest = nullptr;
    std::uint64_t total = 0;
    // For tests: each stage calls it on its own thread, with its name, before every piece of work; it may sleep and throw.
    std::function<void(std::string_view stage)> before_work = [](std::string_view) {};
    // Told of every frame, and asked to save after each whose geometry was fused; nullptr: nobody is. The pipeline alone uses it
    // until finish returns.
    RunRecorder* recorder = nullptr;
    // Reads a frame that was pushed once more, for update_poses, on the fusion thread or one of its own; empty: poses stay, or
    // are followed with the copies that the log has (map.log = copy).
    ReadFrame read_again = {};
    // Gives each frame its pose just before it is fused; a frame where the camera is lost is skipped. REQUIRES what update_poses
    // does, for its loops. nullptr: frames come with their poses. The pipeline alone uses it until finish returns.
    RunTracker* tracker = nullptr;
  };
  OnlinePipeline(const Parts& parts, const OnlineOptions& options);
  ~OnlinePipeline();  // as stop and finish
  OnlinePipeline(const OnlinePipeline&) = delete;
  OnlinePipeline& operator=(const OnlinePipeline&) = delete;

  // Takes a frame, as it comes from a camera, and keeps it until its labels are fused and no snapshot shows it any more: borrowed
  // images that have no owner are copied. Never waits: false if it was dropped because fusion is behind, or if the run is
  // over.
  bool push(Frame frame);
  // The same for recordings that should be mapped whole: waits for room. False if the run is over.
  bool push_when_free(Frame frame);
  // The map follows corrected poses (Mapper::update_poses) as soon as the frames that were pushed before are in it: dropped
  // frames have no pose there. Waits for room. Labels that come later are fused with the corrected poses. False if the run is
  // over. What cannot be done ends the run. REQUIRES options with map.log = "copy", or "reference" and Parts::read_again.
  bool update_poses(std::vector<PoseUpdate> poses);
  // The map is being fused anew: frames that are pushed have to wait, or are dropped, until that is done.
  bool is_correcting() const;
  // Counts a frame that could not even be read.
  void skip(const SkippedFrame& frame);

  // The newest snapshot, every online.mesh_every_s. Takes the time of copying the surface, and holds up nobody.
  PublishedMap published() const;

  // Takes no more frames; what was taken is still mapped. The first reason counts.
  void stop(const std::string& why);
  // No more frames are taken: stop was called or a stage failed.
  bool stopped() const;

  // After the last frame: maps what was taken, ends all threads, does what Mapper::finish does (unless a stage failed), and
  // publishes the last snapshot. Throws nothing; a second call gives the same report.
  OnlineReport finish();

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace panoptic
