// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// From frames and what networks see in them to one labelled map.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/labels.h"
#include "panoptic/mesh.h"
#include "panoptic/moving.h"
#include "panoptic/options.h"
#include "panoptic/outcome.h"
#include "panoptic/pose_update.h"
#include "panoptic/segmentation.h"
#include "panoptic/source.h"

namespace panoptic {

class FrameStatistics;
class MapperParts;
struct PanopticMap;  // map.h
class Profile;

// Memory grows with the mapped volume and the number of objects, and by 4 to 12 kB a frame with map.log (FrameLog; with
// "copy" and no map file by its images, too). Not
// thread-safe: one thread at a time (inside, the work is spread over parallel_for's threads). The same frames give the same map,
// bit for bit.
class Mapper {
 public:
  // Throws Error if an option is out of its range (`panoptic options` lists them) or options contradict each other.
  Mapper(const Options& options, LabelSet labels);
  ~Mapper();
  Mapper(Mapper&&) noexcept;
  Mapper& operator=(Mapper&&) noexcept;
  Mapper(const Mapper&) = delete;
  Mapper& operator=(const Mapper&) = delete;

  // Fuses one frame, then does what is due between frames (object maintenance, regularizer). A frame that cannot be used (NaN
  // pose, wrong size, no depth ...) changes nothing and is counted in frames(). An empty segmentation leaves labels alone. Frame
  // and segmentation are read during the call alone, where they lie: their memory may be another program's.
  Outcome add(const Frame& frame, const Segmentation& segmentation);

  // The two halves of `add`, for runs where labels come later than frames. If nothing else is added or regularized between the
  // two, they leave the map that `add` leaves. add_geometry counts the frame. add_labels REQUIRES that add_geometry used this
  // frame, takes the pose that the map has of it now (see update_poses), and does object maintenance when it is due. Neither
  // regularizes: call regularize.
  Outcome add_geometry(const Frame& frame);
  Outcome add_labels(const Frame& frame, const Segmentation& segmentation);

  // Counts a frame that could not even be read.
  void skip(const SkippedFrame& frame);

  // Regularizes the labels of what changed since the last time (nothing if regularizer.enabled is false), and forgets objects
  // that no voxel holds and no frames' vote is for.
  void regularize();

  // After the last frame, once: object maintenance that must wait until then (it drops what was seen too seldom), and the last
  // regularization.
  void finish();

  // The map follows corrected poses: it is fused anew from all its frames, in their order, each with its newest pose and with
  // the objects that its segments were given when it was added (through ObjectRegistry::merged), without networks and without
  // tracking. Then comes object maintenance and the regularizer; after finish, all that finish does. The same poses give the same
  // map, bit for bit, whatever the map was before. Objects keep their ids; evidence is gathered from the log. Nothing changes if
  // no pose moved by more than map.pose_tolerance_m. Throws Error, and the map stays as it was: a pose that is no rigid motion, a
  // frame that cannot be read or fused again, map.log = none, or a log that is beyond its limit. `read`: not needed where the log
  // has copies of the frames (map.log = copy).
  Correction update_poses(std::span<const PoseUpdate> poses, const ReadFrame& read = {});

  // The surface as it is now; only blocks that changed since the last call are extracted anew.
  Mesh mesh();

  const PanopticMap& map() const;
  const FrameStatistics& frames() const;
  std::uint64_t labelled() const;  // frames that came with a prediction
  // Per segment of the last frame that was added, or whose labels were: which one it is in the map. Stuff and whole classes have
  // their class number; kUnknown: none. Empty after update_poses.
  std::vector<PanopticId> segment_ids() const;
  // The things that moved and were seen to in three frames or more, ascending by their ids; never a part of the map.
  std::vector<MovingTrack> moving_tracks() const;
  // Stages "register", "reference", "track", "integrate", "free space", their sum "fusion", "maintain", "regularize" and "mesh";
  // callers add their own.
  Profile& profile();
  const Profile& profile() const;
  // The upward direction of the world as the cameras were mostly held: the mean of their -y axes, unit length. The -y
  // axis of the world before the first frame.
  Vec3d up() const;

  // For the library's own code: mapping/mapper_parts.h.
  MapperParts& parts() { return *parts_; }
  const MapperParts& parts() const { return *parts_; }

 private:
  std::unique_ptr<MapperParts> parts_;
};

}  // namespace panoptic
