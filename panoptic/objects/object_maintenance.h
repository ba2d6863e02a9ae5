// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Keeps the objects of the map whole and few: joins pieces of one thing, tells things on a table from the table, gives ids to
// things that no mask ever told apart, and forgets what was hardly ever seen. The paper has none of this; what each rule gains
// on real recordings is in docs/accuracy.md.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/geometry.h"
#include "panoptic/map.h"
#include "panoptic/map/frame_votes.h"
#include "panoptic/map/maintenance_state.h"
#include "panoptic/objects/support_planes.h"
#include "panoptic/objects/surface_voxels.h"
#include "panoptic/options.h"

namespace panoptic {

Fields fields(MaintenanceOptions& options);

// Facts about the recording that are known by now.
struct SoFar {
  Vec3d up = -Vec3d::UnitY();         // roughly upwards in the world, unit length
  std::int64_t frame = 0;             // number of the newest frame that was used
  std::uint64_t labelled_frames = 0;  // those that came with a prediction; without any there is nothing to maintain
};

// Not thread-safe. The same calls give the same map, at any thread count.
class ObjectMaintenance {
 public:
  explicit ObjectMaintenance(const MaintenanceOptions& options) : options_(options) {}

  // Notes objects that were seen as separate masks in one frame: they are not one thing. Call it for every frame.
  void saw_together(std::span<const PanopticId> objects);

  // Between frames: merges objects and carves things out of tables, those alone that have surface where something
  // changed since the last time, or near it: what shrank elsewhere waits for the end. Starts a new epoch and marks the blocks
  // that it changes. Its decisions replace the frames' votes too.
  void run(PanopticMap& map, FrameVotes& votes, const SoFar& so_far);
  // After the last frame: also drops, levels and names, which must wait until all evidence is in.
  void finish(PanopticMap& map, FrameVotes& votes, const SoFar& so_far);

  // All that it remembers of earlier frames. Everything else that it keeps only saves reading the map again.
  const MaintenanceState& state() const { return state_; }
  void restore(MaintenanceState state) { state_ = std::move(state); }

 private:
  struct Pass {
    PanopticMap& map;
    FrameVotes& votes;
    SurfaceVoxels& surface;
    Vec3d up;
    std::int64_t frame = 0;
    std::uint64_t min_observations = 0;
    std::vector<bool> changed;  // by label, whether it has surface near what changed since the last time
  };

  // Which objects are looked at. Those that a frame saw are judged once, by what the frames said.
  enum class Judged : std::uint8_t { kAll, kUnobserved };

  Pass begin(PanopticMap& map, FrameVotes& votes, const SoFar& so_far);
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
  void drop_faint(Pass& pass, Judged judged) const;
  void name_unknown_regions(Pass& pass) const;
  void name_others(Pass& pass) const;
  bool is_faint(const Pass& pass, const Object& object, std::span<const std::uint32_t> voxels) const;
  static bool is_sure(const Pass& pass, const Object& object, std::span<const std::uint32_t> voxels);
  static bool is_sure_part(const Pass& pass, std::uint32_t i);
  static std::vector<bool> sure_objects(const Pass& pass);  // by slot
  bool are_apart(const Object& a, const Object& b) const;

  MaintenanceOptions options_;
  SurfaceVoxels surface_;  // kept from one time to the next, because most blocks stay as they are
  MaintenanceState state_;
};

}  // namespace panoptic
