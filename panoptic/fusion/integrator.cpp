// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/integrator.h"

#include <algorithm>
#include <cmath>

#include "panoptic/fusion/band_touch.h"
#include "panoptic/fusion/grazing.h"
#include "panoptic/map/block_key.h"
#include "panoptic/parallel.h"

namespace panoptic {
Fields fields(IntegratorOptions& o) {
  return {{"method", &o.method, "projective: voxels look up pixels (fast); raycast: pixels walk their rays (the paper)",
           one_of({"projective", "raycast"})},
          {"grazing", &o.grazing, "projective: surface seen at a grazing angle is kept thick enough to be meshed", {}},
          {"object_vote", &o.object_vote, "how much a pixel of an object counts, where others count 1", in_range(0, 100)}};
}

Integrator::Integrator(const IntegratorOptions& options, const VoxelMap& map, std::uint16_t first_object)
    : raycast_(options.method == "raycast"),
      grazing_(options.grazing),
      band_{map.truncation_m(), map.voxel_size_m()},
      voxel_size_m_(map.voxel_size_m()),
      max_weight_(map.max_weight()),
      votes_{options.object_vote, first_object} {}

FrameView Integrator::view_of(const Frame& frame, const RegisteredFrame& registered, std::span<const LabelSlot> labels) const {
  FrameView view = depth_view(frame, registered);
  view.pixels.depth_weight = registered.depth_weight.empty() ? nullptr : registered.depth_weight.data();
  view.pixels.color = registered.color.data();
  view.pixels.label = labels.data();
  view.pixels.votes = votes_;
  view.pixels.max_weight = max_weight_;
  return view;
}

Outcome Integrator::check_extent(const Frame& frame, const RegisteredFrame& registered, const VoxelMap& map) {
  constexpr double kBlocksPerSide = 4;  // of a block's side of surface: it lies askew, and the band is thick
  constexpr double kWidestView = 56;    // area at depth 1, of 150 degrees; see check(Frame)
  constexpr double kBlocksAnyway = 1000;
  const double range = double{registered.farthest_m + band_.truncation_m} / double{map.block_size_m()};
  const double most = kBlocksPerSide * kWidestView * range * range + kBlocksAnyway;
  // All that lies in view up to there is seldom more, and then there is no need to look.
  const Camera& c = frame.depth_camera;
  const double view = (c.width / c.fx) * (c.height / c.fy);
  if (view / 3 * std::pow(range + 2, 3) <= most) return {};
  touch_bands(view_of(frame, registered, {}), band_, map.block_size_m(), keys_);
  std::vector<std::uint64_t> touched;
  for (std::vector<std::uint64_t>& keys : keys_) touched.insert(touched.end(), keys.begin(), keys.end());
  std::sort(touched.begin(), touched.end());
  const auto blocks = std::unique(touched.begin(), touched.end()) - touched.begin();
  if (static_cast<double>(blocks) <= most) return {};
  return Outcome::refused(
      "depth would touch more of the map than a surface in view can; are the intrinsics and the depth scale right?");
}

void Integrator::integrate(const Frame& frame, const RegisteredFrame& registered, std::span<const LabelSlot> labels,
                           VoxelMap& map) {
  const FrameView view = view_of(frame, registered, labels);
  map.begin_epoch();
  touch(view, map);
  update(view, allocate(map), map);
}

void Integrator::integrate_labels(const Frame& frame, const RegisteredFrame& registered, std::span<const LabelSlot> labels,
                                  VoxelMap& map) {
  FrameView view = view_of(frame, registered, labels);
  view.pixels.labels_only = true;
  map.begin_epoch();
  touch(view, map);
  update(view, mark_touched(map, nullptr), map);
}

void Integrator::touch(const FrameView& view, const VoxelMap& map) {
  if (raycast_) {
    touch_rays(view, map);
  } else {
    touch_bands(view, band_, map.block_size_m(), keys_);
  }
}

void Integrator::update(const FrameView& view, std::span<const Slot> slots, VoxelMap& map) {
  if (raycast_) {
    update_by_rays(view, slots, map);
  } else {
    update_by_projection(view, slots, map);
  }
}

// The slots of all touched blocks that exist, each once; the keys of the others go to `absent`, if that is wanted.
std::vector<Slot> Integrator::mark_touched(VoxelMap& map, std::vector<std::uint64_t>* absent) const {
  std::vector<Slot> slots;
  for (const std::vector<std::uint64_t>& chunk : keys_) {
    for (const std::uint64_t key : chunk) {
      const Slot slot = map.find_slot(unpack(key));
      if (slot == VoxelMap::kNoSlot) {
        if (absent != nullptr) absent->push_back(key);
      } else if (map.changed_at(slot) != map.epoch()) {
        map.mark_changed(slot);
        slots.push_back(slot);
      }
    }
  }
  return slots;
}

// The slots of all touched blocks, each once. New blocks are allocated in ascending order of their keys.
std::vector<Slot> Integrator::allocate(VoxelMap& map) const {
  std::vector<std::uint64_t> absent;
  std::vector<Slot> slots = mark_touched(map, &absent);
  std::sort(absent.begin(), absent.end());
  absent.erase(std::unique(absent.begin(), absent.end()), absent.end());
  for (const std::uint64_t key : absent) {
    slots.push_back(map.allocate(unpack(key)));
    map.mark_changed(slots.back());
  }
  return slots;
}

void Integrator::update_by_projection(FrameView view, std::span<const Slot> slots, VoxelMap& map) {
  if (grazing_) {
    grazing_scales(view.pixels, band_, voxel_size_m_, scale_);
    view.pixels.scale = scale_.data();
  }
  depth_tiles_.build(view.pixels, band_);
  parallel_for(slots.size(), [&](std::size_t i) {
    const BlockInCamera place = view.in_camera(map.index_of(slots[i]), map.voxel_size_m());
    integrate_block(view.pixels, place, band_, bricks_in_band(view.pixels, depth_tiles_, place, band_), map.block(slots[i]));
  });
}

}  // namespace panoptic
