// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One mapping run: the order of events, and nothing else.
#pragma once

#include <memory>
#include <optional>
#include <span>
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
#include "panoptic/map/panoptic_map.h"
#include "panoptic/session/frame_log.h"
#include "panoptic/session/options.h"

namespace panoptic {

// What a session remembers beside its map and objects.
struct SessionState {
  SeenTogether together;
  RegularizerState regularizer;
  FrameLog frames;
  std::uint64_t label_frames = 0;
  std::uint64_t labelled = 0;
  Vec3d up_sum = Vec3d::Zero();
  std::int64_t last_frame = 0;
};

// Memory grows with the mapped volume and the number of objects, never with the number of frames. Not thread-safe: one thread
// at a time (inside, the work is spread over parallel_for's threads). The same frames give the same map, bit for bit.
class Session {
 public:
  // Throws Error if the options contradict each other.
  Session(const Options& options, LabelSet labels);

  // Fuses one frame. An unusable frame (NaN pose, wrong size, no depth ...) changes nothing, is counted in frames(), and the
  // reason is returned. An empty segmentation leaves labels alone. Regularizes after every regularizer.every_frames used frames.
  std::optional<std::string> add(const Frame& frame, const Segmentation& segmentation);

  // The two halves of add, for runs where labels come later than frames: all geometry first and the labels of the same frame
  // later leave the map that add would have left, but for what else happened in between. add_geometry counts the frame; what
  // add_labels refuses is only returned. add_labels REQUIRES that add_geometry took this frame. Neither regularizes.
  std::optional<std::string> add_geometry(const Frame& frame);
  std::optional<std::string> add_labels(const Frame& frame, const Segmentation& segmentation);

  // Counts a frame that could not even be read.
  void skip(const SkippedFrame& frame) { frames_.count_skipped(frame); }

  // Regularizes the labels of what changed since the last time (nothing if regularizer.enabled is false), and forgets objects
  // that no voxel holds and no frames' vote is for.
  void regularize();
  // Forgets the votes for objects that no voxel holds, and those objects: for when no more frames come.
  void forget_votes_without_voxels();

  // The same in steps, so that the long one can run beside the mapping: choose_submaps and gather read the map, solve reads only
  // its argument (and may be called while another thread uses the session), write_back changes the map: not where a frame did
  // meanwhile, and what is about objects that were merged since is about what they are now, or dropped if they are no more.
  std::vector<std::vector<Slot>> choose_submaps();
  SubmapGraph gather(const std::vector<Slot>& blocks) const;
  SubmapChanges solve(const SubmapGraph& submap) const { return regularizer_.solve(submap); }
  void write_back(SubmapChanges changes);

  // After the last frame: object maintenance that must wait until then, and the last regularization.
  void finish();

  // The surface as it is now; only blocks that changed since the last call are extracted anew.
  Mesh mesh();

  // The surface in chunks, by slot, brought up to date; whoever copies the pointers may read them at any time later.
  const std::vector<std::shared_ptr<const MeshChunk>>& surface();

  const PanopticMap& map() const { return map_; }
  const FrameLog& frames() const { return frames_; }
  std::uint64_t labelled() const { return labelled_; }  // frames that came with a prediction
  // Per segment of the last frame that was added, or whose labels were: which it is in the map.
  std::vector<PanopticId> segment_ids() const;
  // Stages "register", "reference", "track", "integrate", their sum "fusion", "maintain", "regularize" and "mesh"; callers add
  // their own.
  Profile& profile() { return profile_; }
  const Profile& profile() const { return profile_; }
  // Upwards in the world, as the cameras were mostly held: the mean of their -y axes. Unit length.
  Vec3d up() const;

  // To save a session, and to go on from there: then the same frames give the same map as without the interruption, bit for bit.
  // restore REQUIRES a session with the options and labels of the one that was saved, to which nothing was added.
  SessionState state() const;
  void restore(PanopticMap map, SessionState state);

 private:
  class Stages;

  std::optional<std::string> why_refused(const Frame& frame, const Segmentation& segmentation) const;
  std::optional<std::string> why_unfit(const Frame& frame, const RegisteredFrame& registered);
  const std::vector<LabelSlot>& track(const Frame& frame, const Segmentation& segmentation, const RegisteredFrame& registered,
                                      Stages& stages);
  void count_frame(const Frame& frame);
  void count_labels(const Segmentation& segmentation);
  void note_together();
  void retire_objects();
  std::optional<std::uint16_t> now_called(std::uint16_t label, PanopticId next_id) const;
  SoFar so_far() const { return {up(), last_frame_, labelled_}; }

  PanopticMap map_;
  Registration registration_;
  LabelTracker tracker_;
  Integrator integrator_;
  std::uint64_t maintain_every_;
  ObjectMaintenance maintenance_;
  bool regularizes_;
  std::uint64_t regularize_every_;
  Regularizer regularizer_;
  Mesher mesher_;
  std::vector<LabelSlot> reference_;
  std::vector<LabelSlot> no_votes_;  // of a frame without labels
  FrameLog frames_;
  std::uint64_t label_frames_ = 0;  // frames that labels were integrated of, or could have been
  std::uint64_t labelled_ = 0;
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
