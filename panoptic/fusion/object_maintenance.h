// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Keeps the objects of the map whole and few: joins pieces of one thing, tells things on a table from the table, gives ids to
// things that no mask ever told apart, and forgets what was hardly ever seen. The paper has none of this; what each rule gains
// on real recordings is in docs/accuracy.md.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/base/geometry.h"
#include "panoptic/fusion/frame_votes.h"
#include "panoptic/fusion/support_planes.h"
#include "panoptic/fusion/surface_voxels.h"
#include "panoptic/map/object_registry.h"
#include "panoptic/map/voxel_map.h"

namespace panoptic {

struct MaintenanceOptions {
  bool enabled = true;
  int every_frames = 20;
  // Two objects of one class are one if this share of the smaller one is this near to the larger one, unless they were seen as
  // two masks in this share of the frames of the one seen less.
  float merge_share = 0.2F;
  float merge_distance_m = 0.07F;
  float together_share = 0.2F;
  bool carve = true;             // things on tables are things of their own, also where no network knows them
  float carve_height_m = 0.02F;  // above the table top
  // At the end:
  float floor_height_m = 0.03F;  // level surface this near to the floor's plane is floor; 0 = as the networks say
  int min_observations = 6;      // objects seen less often are dropped; with few labelled frames, those seen in less than 1 of 35
  float min_thing_m2 = 0.05F;    // unnamed things with less surface are dropped
  float min_region_m2 = 0.12F;   // unknown regions from this surface on are things
  float stray_share = 0.15F;     // pieces of an object smaller than this share of its largest piece are dropped
  float size_margin = 1.15F;     // an object this much longer than its class can be (label set, max_size_m) is of another class
};
Fields fields(MaintenanceOptions& options);

// What is known of the recording by now.
struct SoFar {
  Vec3d up = -Vec3d::UnitY();         // roughly upwards in the world, unit length
  std::int64_t frame = 0;             // number of the newest frame that was used
  std::uint64_t labelled_frames = 0;  // those that came with a prediction; without any there is nothing to maintain
};

// Frames with a mask of each of two objects; first < second.
using SeenTogether = std::map<std::pair<PanopticId, PanopticId>, std::uint32_t>;

// Not thread-safe. The same calls give the same map, at any thread count.
class ObjectMaintenance {
 public:
  ObjectMaintenance(const MaintenanceOptions& options, LabelSet labels);

  // Objects that were seen as separate masks in one frame are not one thing. Call it for every frame.
  void saw_together(std::span<const PanopticId> objects);

  // Between frames: merges objects and carves things out of tables. Starts a new epoch and marks the blocks that it changes. What
  // it decides is decided for `votes` too.
  void run(VoxelMap& map, ObjectRegistry& objects, FrameVotes& votes, const SoFar& so_far);
  // After the last frame: also drops, levels and names, which must wait until all evidence is in.
  void finish(VoxelMap& map, ObjectRegistry& objects, FrameVotes& votes, const SoFar& so_far);

  // All that it remembers of earlier frames; what else it keeps is only faster than reading the map.
  const SeenTogether& seen_together() const { return together_; }
  void restore(SeenTogether together) { together_ = std::move(together); }

 private:
  struct Pass {
    VoxelMap& map;
    ObjectRegistry& objects;
    FrameVotes& votes;
    SurfaceVoxels& surface;
    Vec3d up;
    std::int64_t frame = 0;
    std::uint64_t min_observations = 0;
  };

  Pass begin(VoxelMap& map, ObjectRegistry& objects, FrameVotes& votes, const SoFar& so_far);
  static VoxelsByLabel objects_of(const Pass& pass);
  static bool is_voted_on(const Pass& pass, std::uint32_t i);
  bool merge(Pass& pass);
  void carve_supports(Pass& pass) const;
  std::vector<std::uint32_t> things_on(const Pass& pass, const SupportTop& top, LabelSlot support,
                                       const std::vector<bool>& unnamed) const;
  void carve(Pass& pass, const std::vector<std::uint32_t>& piece, LabelSlot support) const;
  void drop_strays(Pass& pass) const;
  void rule_out_by_size(Pass& pass) const;
  void level_floor(Pass& pass) const;
  void drop_faint(Pass& pass) const;
  void name_unknown_regions(Pass& pass) const;
  void name_others(Pass& pass) const;
  bool is_faint(const Pass& pass, const Object& object, std::size_t voxels) const;
  bool are_apart(const Object& a, const Object& b) const;

  MaintenanceOptions options_;
  LabelSet labels_;
  SurfaceVoxels surface_;  // kept from one time to the next, because most blocks stay as they are
  SeenTogether together_;
};

}  // namespace panoptic
