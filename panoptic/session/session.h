// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One mapping run: the order of events, and nothing else.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/base/profile.h"
#include "panoptic/data/frame.h"
#include "panoptic/data/mesh.h"
#include "panoptic/data/segmentation.h"
#include "panoptic/fusion/integrator.h"
#include "panoptic/fusion/label_tracker.h"
#include "panoptic/fusion/mesher.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/fusion/regularizer.h"
#include "panoptic/map/object_registry.h"
#include "panoptic/map/voxel_map.h"
#include "panoptic/session/frame_log.h"
#include "panoptic/session/options.h"

namespace panoptic {

// Memory grows with the mapped volume and the number of objects, never with the number of frames. Not thread-safe: one thread
// at a time (inside, the work is spread over parallel_for's threads). The same frames give the same map, bit for bit.
class Session {
 public:
  // Throws Error if the options contradict each other.
  Session(const Options& options, LabelSet labels);

  // Fuses one frame. An unusable frame (NaN pose, wrong size, no depth ...) changes nothing, is counted in frames(), and the
  // reason is returned. An empty segmentation leaves labels alone. Regularizes after every regularizer.every_frames used frames.
  std::optional<std::string> add(const Frame& frame, const Segmentation& segmentation);

  // Counts a frame that could not even be read.
  void skip(const SkippedFrame& frame) { frames_.count_skipped(frame); }

  // Regularizes the labels of what changed since the last time (nothing if regularizer.enabled is false), and forgets objects
  // that lost their last voxel.
  void regularize();

  // After the last frame: object maintenance that must wait until then, and the last regularization.
  void finish();

  // The surface as it is now; only blocks that changed since the last call are extracted anew.
  Mesh mesh();

  const VoxelMap& map() const { return map_; }
  const ObjectRegistry& objects() const { return objects_; }
  const LabelSet& labels() const { return labels_; }
  const FrameLog& frames() const { return frames_; }
  // Stages "register", "reference", "track", "integrate", their sum "fusion", "maintain", "regularize" and "mesh"; callers add
  // their own.
  Profile& profile() { return profile_; }
  const Profile& profile() const { return profile_; }
  // Upwards in the world, as the cameras were mostly held: the mean of their -y axes. Unit length.
  Vec3d up() const;

 private:
  void note_together();
  SoFar so_far() const { return {up(), last_frame_, frames_.used()}; }

  LabelSet labels_;
  VoxelMap map_;
  ObjectRegistry objects_;
  Registration registration_;
  LabelTracker tracker_;
  Integrator integrator_;
  std::uint64_t maintain_every_;
  ObjectMaintenance maintenance_;
  bool regularizes_;
  std::uint64_t regularize_every_;
  Regularizer regularizer_;
  Mesher mesher_;
  std::vector<PanopticId> reference_;
  FrameLog frames_;
  Profile profile_;
  Vec3d up_sum_ = Vec3d::Zero();
  std::int64_t last_frame_ = 0;
  double farthest_camera_m_ = 0;  // from the origin, along an axis
};

// The predictor that the options ask for: the prediction folder, else the networks, else nullptr (geometry and colour alone).
// Throws Error.
std::unique_ptr<Predictor> make_predictor(const Options& options);

// The label set of a run: the predictor's, or without one what the options name.
LabelSet labels_of(const Options& options, const Predictor* predictor);

}  // namespace panoptic
