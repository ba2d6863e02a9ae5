// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The inside of a Mapper: the stages, the order of events, and what the online pipeline and the map file need of them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "panoptic/crf/regularizer.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/fusion/integrator.h"
#include "panoptic/fusion/label_tracker.h"
#include "panoptic/fusion/motion_mask.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/fusion/space_observer.h"
#include "panoptic/map.h"
#include "panoptic/map/frame_log.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapper.h"
#include "panoptic/meshing/mesher.h"
#include "panoptic/objects/moving_tracks.h"
#include "panoptic/objects/object_maintenance.h"
#include "panoptic/objects/presence.h"
#include "panoptic/pose_update.h"
#include "panoptic/profile.h"

namespace panoptic {

// The state of a mapper beside its map.
struct MapperState : SavedState {
  FrameStatistics frames;
  std::vector<FrameLog::Entry> log;
};
// The state that a map file tells: its notes, the frames that it lists, and its log. Throws Error if they are not of one map.
MapperState mapper_state(const SavedMap& saved, const std::vector<FrameRecord>& frames, std::vector<FrameLog::Entry> log = {});

// A frame seen from its depth camera, with the segments that were seen in it.
struct FrameToLabel {
  const Frame& frame;
  const Segmentation& segmentation;
  const RegisteredFrame& registered;
};

// Which objects the segments of a frame are. Good until the next frame.
struct Association {
  std::span<const LabelSlot> labels;       // per depth pixel, and the extra pixel of RegisteredFrame; kNoVote: no label
  std::span<const LabelSlot> segment_ids;  // per segment
  std::span<const std::uint32_t> segment_areas_px;
};

// Functions that a caller puts in place of a stage, or after one. Empty: the stage of the mapper, or nothing.
struct ReplacedStages {
  std::function<Association(const FrameToLabel&, PanopticMap&)> associate;        // in place of Eq. 2-5 and 12
  std::function<void(const FrameToLabel&, std::span<const LabelSlot>)> labelled;  // after the labels were integrated
};

class MapperParts;

// A map that is fused anew with corrected poses beside the one of a mapper.
struct MapAnew {
  Correction correction;  // `frames` is 0 if no pose moved: then there is nothing to be done
  FrameLog log;           // with the corrected poses
  std::uint64_t epoch = 0;
  std::unique_ptr<MapperParts> parts;
};

// Used like a Mapper: one thread at a time.
class MapperParts {
 public:
  // Throws Error if the options contradict each other.
  MapperParts(const Options& options, LabelSet labels, ReplacedStages replaced = {});

  // The functions of Mapper.
  Outcome add(const Frame& frame, const Segmentation& segmentation);
  Outcome add_geometry(const Frame& frame);
  Outcome add_labels(const Frame& given, const Segmentation& segmentation);
  void skip(const SkippedFrame& frame) { frames_.count_skipped(frame); }
  void regularize();
  void finish();
  Correction update_poses(std::span<const PoseUpdate> poses, const ReadFrame& read);
  // The same without the tasks that follow.
  Correction fuse_anew(std::span<const PoseUpdate> poses, const ReadFrame& read);
  // fuse_anew in steps, so that the long one can run beside others who look at the mapper, skip, and ask for its surface; nothing
  // else must happen to it between the first step and the last. begin_anew reads it; fuse makes the new map; take_over exchanges
  // the two in a moment, and leaves the old one to be destroyed. settle are the tasks that follow, before or after take_over.
  MapAnew begin_anew(std::span<const PoseUpdate> poses) const;
  void fuse(MapAnew& anew, const ReadFrame& read) const;
  void take_over(MapAnew& anew);
  void settle();
  // The pose that the map has of a frame: it may have been corrected since the frame was handed over.
  Pose pose_of(const Frame& frame) const;
  // How often the map was made anew: blocks have other slots since the last time.
  std::uint64_t times_anew() const { return times_anew_; }
  const FrameLog& log() const { return log_; }
  // Whether corrections need nobody who reads frames again. From any thread.
  bool keeps_copies() const { return options_.map.log == "copy"; }
  // Copies of frames go into a map file from now on, now and then. REQUIRES that nothing was added yet.
  void copy_to_file() { log_.copy_to_file(); }
  Mesh mesh();
  // The same for whoever will hardly ask again: it keeps nothing to make the next time faster, if nothing was kept before.
  Mesh last_mesh();
  const PanopticMap& map() const { return map_; }
  const FrameStatistics& frames() const { return frames_; }
  std::uint64_t labelled() const { return labelled_; }
  std::vector<PanopticId> segment_ids() const;
  Profile& profile() { return profile_; }
  const Profile& profile() const { return profile_; }
  Vec3d up() const;
  // The things that move in the last frame that was added.
  const MovingSight& moving() const { return *moving_; }
  const MovingTracks& moving_tracks() const { return moving_tracks_; }

  // Forgets the votes for objects that no voxel holds, and those objects: for when no more frames come.
  void forget_votes_without_voxels();

  // `regularize` in steps, so that the long one can run beside the mapping: choose_tiles and gather read the map, solve reads
  // only its argument (and may be called while another thread uses the mapper), write_back changes the map: not where a frame did
  // meanwhile, and what is about objects that were merged since is about what they are now, or dropped if they are no more.
  std::vector<std::vector<Slot>> choose_tiles();
  TileGraph gather(const std::vector<Slot>& blocks) const;
  TileChanges solve(const TileGraph& tile) const { return regularizer_.solve(tile); }
  void write_back(TileChanges changes);

  // The surface in chunks, by slot, brought up to date; whoever copies the pointers may read them at any time later.
  const std::vector<std::shared_ptr<const MeshChunk>>& surface();

  // To save a mapper, and to go on from there: then the same frames give the same map as without the interruption, bit for bit.
  // restore REQUIRES a mapper with the options and labels of the one that was saved, to which nothing was added.
  MapperState state() const;
  void restore(PanopticMap map, MapperState state);

 private:
  // Frames are counted when their geometry is integrated, label frames when their labels are, or could have been.
  enum class Counted { kFrame, kLabelFrame };
  // Work between frames: after every so many of what is counted.
  struct Task {
    const char* stage;
    Counted counted;
    std::uint64_t every;
    void (MapperParts::*run)();
  };
  // How long the stages of the frame that is being added take.
  class StageTimer {
   public:
    explicit StageTimer(Profile& profile) : profile_(profile) {}
    void restart();
    void done(const char* stage);
    void all_done(const char* sum) { profile_.add(sum, stopwatch_.seconds()); }

   private:
    Profile& profile_;
    Stopwatch stopwatch_;
    double before_s_ = 0;
  };
  // A frame that passed every check; `registered` is null if it did not.
  struct Accepted {
    Outcome outcome;
    const RegisteredFrame* registered = nullptr;
  };

  Accepted accept(const Frame& frame, const Segmentation& segmentation, StageTimer& timer, const char* stage = "register");
  Outcome check_frame(const Frame& frame, const Segmentation& segmentation) const;
  Outcome count_refused(const Frame& frame, Outcome outcome);
  std::span<const LabelSlot> associate(const FrameToLabel& to_label, StageTimer& timer);
  Association track(const FrameToLabel& to_label, StageTimer& timer);
  void see_space(const Frame& frame, const RegisteredFrame& registered);
  void find_gone();
  void check_memory() const;
  void count_frame(const Frame& frame);
  void count_labels(const Frame& frame, const Segmentation& segmentation);
  void log_labels(const Frame& frame, const Segmentation& segmentation);
  FrameLog corrected_log(std::span<const PoseUpdate> poses, Correction& correction) const;
  void retrace();
  void note_covisible();
  void run_due_tasks(Counted counted);
  // Does one piece of work and adds how long it took to the profile.
  template <typename Work>
  void timed(const char* stage, const Work& work) {
    const Stopwatch stopwatch;
    work();
    profile_.add(stage, stopwatch.seconds());
  }
  void maintain();
  void regularize_changes();
  ObjectPresence::FramesBefore frames_before(double time_s) const;
  bool has_times(double newest_s) const;
  double seconds_of(std::int64_t frame) const;
  void prune_if_due();
  void prune();
  std::optional<std::uint16_t> now_called(std::uint16_t label, PanopticId next_id) const;
  SoFar so_far() const { return {up(), last_frame_, labelled_}; }

  Options options_;
  PanopticMap map_;
  ReplacedStages replaced_;
  Registration registration_;
  LabelTracker tracker_;
  Integrator integrator_;
  SpaceObserver space_;
  MotionMask motion_mask_;
  const MovingSight* moving_ = nullptr;
  MovingTracks moving_tracks_;
  bool knows_presence_;
  ObjectPresence presence_;
  ObjectMaintenance maintenance_;
  Regularizer regularizer_;
  Mesher mesher_;
  bool regularizes_;
  std::vector<Task> tasks_;
  std::vector<LabelSlot> reference_;
  std::vector<LabelSlot> no_votes_;  // of a frame without labels
  Association association_;          // of the last frame with labels
  FrameStatistics frames_;
  FrameLog log_;
  bool finished_ = false;
  std::uint64_t times_anew_ = 0;
  std::uint64_t label_frames_ = 0;
  std::uint64_t labelled_ = 0;
  Profile profile_;
  Vec3d up_sum_ = Vec3d::Zero();
  std::int64_t last_frame_ = 0;
  double farthest_camera_m_ = 0;  // from the origin, along an axis
};

}  // namespace panoptic
