// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Rooms of boxes for the tests of object maintenance, z upwards.
#pragma once

#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "panoptic/objects/object_maintenance.h"
#include "tests/fusion/small_maps.h"

namespace panoptic::test {

inline constexpr ClassId kWall{1};
inline constexpr ClassId kFloor{2};
inline constexpr ClassId kChair{5};
inline constexpr ClassId kSofa{6};
inline constexpr ClassId kTable{7};
inline constexpr ClassId kBag{9};
inline constexpr std::uint16_t kFirst = 10;
inline constexpr std::uint64_t kFrames = 1000;
inline constexpr std::int64_t kLastFrame = 1234;
inline const Vec3d kUp = Vec3d::UnitZ();

inline LabelSet labels() {
  return {"room",
          {{kWall, "wall", false, {}},
           {kFloor, "floor", false, {}},
           {kChair, "chair", true, {}, 1.6},
           {kSofa, "sofa", true, {}, 4.0},
           {kTable, "table", true, {}, 0, true},
           {kBag, "bag", true, {}, 0.8}}};
}

// A map, with what one does to it.
struct World {
  PanopticMap map;
  FrameVotes votes;
  ObjectMaintenance maintenance;

  explicit World(const MaintenanceOptions& options = {}, LabelSet label_set = labels())
      : map(MapOptions{}, std::move(label_set)), maintenance(options) {}

  LabelSlot seen(ClassId class_id, int times = 20, const std::vector<ClassProbability>& probabilities = {}, float score = 0.5F) {
    const LabelSlot id = *map.objects.create();
    for (int t = 0; t < times; ++t) map.objects.observe(id, {class_id, score, probabilities}, t);
    return id;
  }

  void run() { maintenance.run(map, votes, {kUp, kLastFrame, kFrames}); }
  void finish(std::uint64_t frames = kFrames) { maintenance.finish(map, votes, {kUp, kLastFrame, frames}); }

  // The surface label of a place (at the voxel that holds it).
  LabelSlot at(const Vec3d& p) const {
    const SurfaceVoxels surface(map.voxels);
    for (std::uint32_t i = 0; i < surface.size(); ++i) {
      if ((place_m(surface[i], map.voxels.voxel_size_m()) - p).cwiseAbs().maxCoeff() <= 0.5 * map.voxels.voxel_size_m()) {
        return surface[i].label;
      }
    }
    ADD_FAILURE() << "no surface at " << p.transpose();
    return LabelSlot::kNoVote;
  }

  std::size_t count(LabelSlot id) const {
    const VoxelsByLabel voxels = SurfaceVoxels(map.voxels).by_label();
    const auto found = voxels.find(id);
    return found == voxels.end() ? 0 : found->second.size();
  }

  std::set<LabelSlot> ids() const {
    std::set<LabelSlot> result;
    for (const auto& [id, voxels] : SurfaceVoxels(map.voxels).by_label()) {
      if (number(id) >= kFirst) result.insert(id);
    }
    return result;
  }
};

inline LabelSlot stuff(ClassId id) { return LabelSet::of_class(id); }

inline Solid table_top(LabelSlot label) { return solid_box({-0.6, -0.4, 0.55}, {0.6, 0.4, 0.7}, label); }
inline Solid box_on_table(LabelSlot label) { return solid_box({0, 0, 0.6}, {0.2, 0.2, 0.9}, label); }

inline void add_to(World& world, const std::vector<Solid>& solids) {
  add_solids(world.map.voxels, solids, {-1.2, -0.9, -0.2}, {1.2, 0.9, 1.2});
}

inline std::vector<ClassProbability> maybe_a_sofa(float share) { return {{kSofa, share}, {kBag, 1 - share}}; }

}  // namespace panoptic::test
