// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/presence.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "panoptic/map/label_extents.h"
#include "panoptic/map/space_cells.h"
#include "panoptic/map/voxel_grid.h"

namespace panoptic {
namespace {

// Two boxes of one thing seen from other sides differ by as much along an edge.
constexpr double kLeastAlike = 0.5;

bool is_surface(const Brick& brick, int voxel, float voxel_size_m) {
  if ((brick.stored() >> voxel & 1) == 0) return false;
  const int k = brick.place(voxel);
  return brick.plane(FloatPlane::kWeight)[k] > 0 &&
         std::abs(brick.plane(FloatPlane::kDistance)[k]) < kSurfaceBand_voxels * voxel_size_m;
}

VoxelIndex voxel_of(const CellIndex& brick, int voxel) {
  return {brick[0] * kBrickSide + (voxel & 3), brick[1] * kBrickSide + (voxel >> 2 & 3), brick[2] * kBrickSide + (voxel >> 4)};
}

LabelExtent extent_of(const LostSurface& lost) {
  LabelExtent extent;
  for (const auto& [cell, voxels] : lost.voxels) {
    for (std::uint64_t left = voxels; left != 0; left &= left - 1) {
      const VoxelIndex at = voxel_of(cell, std::countr_zero(left));
      LabelExtent one{.voxels = 1, .min = at, .max = at, .sum = {at[0], at[1], at[2]}};
      extent.add(one);
    }
  }
  return extent;
}

// Two views from different places looked through the voxel, and none has seen a surface there since.
bool is_doubted(const FreeSpaceMap& space, const CellIndex& cell, int voxel) {
  const Doubt* doubt = space.doubt(cell);
  return doubt != nullptr && ((doubt->count[1] | doubt->count[2]) >> voxel & 1) != 0;
}

// Surface that is still in the map although it lies where views see nothing: in a cell that is free, or doubted.
std::map<LabelSlot, std::uint64_t> surface_seen_empty(const PanopticMap& map) {
  std::map<LabelSlot, std::uint64_t> empty;
  for (Slot slot = 0; slot < map.voxels.block_count(); ++slot) {
    const BlockIndex index = map.voxels.index_of(slot);
    const SpaceChunk::Cells* cells = map.free_space.cells_of(index);
    if (cells == nullptr) continue;
    visit_surface(map.voxels.block(slot), index, map.voxels.voxel_size_m(), [&](LabelSlot label, const VoxelIndex& at) {
      if (!map.labels.is_object(label)) return;
      const CellIndex cell{at[0] >> 2, at[1] >> 2, at[2] >> 2};
      const int voxel = (at[0] & 3) | (at[1] & 3) << 2 | (at[2] & 3) << 4;
      const bool is_free = space_of((*cells)[static_cast<std::size_t>(number_of(cell))]) == Space::kFree;
      if (is_free || is_doubted(map.free_space, cell, voxel)) ++empty[label];
    });
  }
  return empty;
}

// Forgets every voxel with this label.
void clear_label(LabelSlot label, FrameVotes& votes, VoxelMap& map) {
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    bool changed = false;
    for (int b = 0; b < kBlockBricks; ++b) {
      std::uint64_t own = 0;
      const Brick& brick = std::as_const(map).block(slot).brick(b);
      for (std::uint64_t left = brick.stored(); left != 0; left &= left - 1) {
        const int v = std::countr_zero(left);
        own |= std::uint64_t{brick.label(v) == number(label)} << v;
      }
      if (own == 0) continue;
      map.block(slot).forget(b, own);
      votes.forget(slot, b, own);
      changed = true;
    }
    if (changed) map.mark_changed(slot);
  }
}

PastObject past_of(const Object& object, const ObjectRegistry& objects) {
  const std::vector<ClassProbability> probabilities = objects.probabilities(object.slot);
  PastObject past;
  past.id = object.id;
  past.class_id = objects.class_of(object.slot);
  for (const ClassProbability& p : probabilities) {
    if (p.class_id == past.class_id) past.probability = p.probability;
  }
  past.first_frame = object.first_frame;
  past.last_frame = object.last_frame;
  past.observations = object.observations;
  return past;
}

// How alike two boxes are, whichever way they stand: the product of the shares of their edges; 0 if they cannot be of one thing.
double likeness(const ExtentBox& a, const ExtentBox& b) {
  const auto edges = [](const ExtentBox& box) {
    std::array<double, 3> e{};
    for (int axis = 0; axis < 3; ++axis) e[static_cast<std::size_t>(axis)] = box.max_m[axis] - box.min_m[axis];
    std::sort(e.begin(), e.end());
    return e;
  };
  const auto ea = edges(a);
  const auto eb = edges(b);
  double alike = 1;
  for (std::size_t n = 0; n < 3; ++n) {
    const double share = std::min(ea[n], eb[n]) / std::max({ea[n], eb[n], 1e-6});
    if (share < kLeastAlike) return 0;
    alike *= share;
  }
  return alike;
}

}  // namespace

void ObjectPresence::looks_through(Slot slot, int brick, std::uint64_t voxels, std::int64_t frame, const PanopticMap& map) {
  const Brick& held = map.voxels.block(slot).brick(brick);
  const CellIndex cell = cell_of(map.voxels.index_of(slot), brick);
  for (std::uint64_t left = voxels; left != 0; left &= left - 1) {
    const int v = std::countr_zero(left);
    if (!is_surface(held, v, map.voxels.voxel_size_m())) continue;
    const Object* object = map.objects.find(static_cast<LabelSlot>(held.label(v)));
    if (object == nullptr) continue;
    LostSurface& lost = state_.lost[object->id];
    lost.voxels[cell] |= std::uint64_t{1} << v;
    lost.frame = frame;
  }
}

void ObjectPresence::came_up(std::span<const CellIndex> cells, std::int64_t frame) {
  for (const CellIndex& cell : cells) state_.came_up.try_emplace(cell, frame);
}

std::vector<CellIndex> ObjectPresence::settled(std::span<const CellIndex> cells, std::uint64_t time) {
  constexpr std::uint64_t kLongestGap = 10;
  constexpr std::uint64_t kStay = 60;
  std::vector<CellIndex> settled;
  for (const CellIndex& cell : cells) {
    Stay& stay = state_.stays.try_emplace(cell, Stay{time, time}).first->second;
    if (time > stay.last + kLongestGap) stay.since = time;
    stay.last = time;
    if (time >= stay.since + kStay) settled.push_back(cell);
  }
  std::erase_if(state_.stays, [&](const auto& entry) { return time > entry.second.last + kLongestGap; });
  return settled;
}

// To judge an object takes a look at the whole map.
bool ObjectPresence::has_news(bool is_last) const {
  const double growth = is_last ? 0 : 1.25;
  return std::any_of(state_.lost.begin(), state_.lost.end(), [&](const auto& entry) {
    return static_cast<double>(entry.second.count()) > growth * static_cast<double>(entry.second.looked_at);
  });
}

// Without what has a surface again; objects that were merged are one.
std::map<PanopticId, LostSurface> ObjectPresence::still_lost(const PanopticMap& map) const {
  const float voxel_m = map.voxels.voxel_size_m();
  std::map<PanopticId, LostSurface> left;
  for (const auto& [id, lost] : state_.lost) {
    const Object* object = map.objects.find(map.objects.survivor(id));
    if (object == nullptr) continue;
    LostSurface& of_object = left[object->id];
    of_object.frame = std::max(of_object.frame, lost.frame);
    for (const auto& [cell, voxels] : lost.voxels) {
      const Slot slot = map.voxels.find_slot(block_of(cell));
      std::uint64_t gone = voxels;
      for (std::uint64_t bits = slot == VoxelMap::kNoSlot ? 0 : voxels; bits != 0; bits &= bits - 1) {
        const int v = std::countr_zero(bits);
        if (is_surface(map.voxels.block(slot).brick(number_of(cell)), v, voxel_m)) gone &= ~(std::uint64_t{1} << v);
      }
      if (gone != 0) of_object.voxels[cell] |= gone;
    }
  }
  return left;
}

void ObjectPresence::find_gone(const Now& now, FrameVotes& votes, PanopticMap& map) {
  if (!has_news(now.is_last)) return;
  state_.lost = still_lost(map);
  const LabelExtents extents = label_extents(map.voxels);
  const std::map<LabelSlot, std::uint64_t> empty = surface_seen_empty(map);
  for (auto entry = state_.lost.begin(); entry != state_.lost.end();) {
    auto& [id, lost] = *entry;
    const Object& object = *map.objects.find(id);
    const LabelExtent gone = extent_of(lost);
    const auto held = extents.find(object.slot);
    LabelExtent whole = held == extents.end() ? LabelExtent{} : held->second;
    const auto doubtful = empty.find(object.slot);
    const std::uint64_t more = doubtful == empty.end() ? 0 : doubtful->second;
    if (gone.voxels + more < whole.voxels - more || gone.voxels == 0 || object.last_frame > lost.frame) {
      lost.looked_at = gone.voxels;
      ++entry;
      continue;
    }
    whole.add(gone);
    PastObject past = past_of(object, map.objects);
    past.gone_frame = now.frame;
    past.box = box_of(whole, double{map.voxels.voxel_size_m()});
    past.voxels = whole.voxels;
    if (past.observations >= now.min_observations && past.class_id != ClassId::kUnknown) map.history.past.push_back(past);
    if (held != extents.end()) clear_label(object.slot, votes, map.voxels);
    entry = state_.lost.erase(entry);
  }
}

void ObjectPresence::find_arrivals(PanopticMap& map) const {
  map.history.arrivals.clear();
  for (PastObject& past : map.history.past) past.moved_to = PanopticId::kUnknown;
  if (state_.came_up.empty()) return;
  std::map<LabelSlot, std::pair<std::uint64_t, std::uint64_t>> surface;  // voxels, and those of them in cells that were free
  for (Slot slot = 0; slot < map.voxels.block_count(); ++slot) {
    visit_surface(map.voxels.block(slot), map.voxels.index_of(slot), map.voxels.voxel_size_m(),
                  [&](LabelSlot label, const VoxelIndex& at) {
                    if (!map.labels.is_object(label)) return;
                    auto& [all, came] = surface[label];
                    ++all;
                    came += state_.came_up.contains({at[0] >> 2, at[1] >> 2, at[2] >> 2}) ? 1 : 0;
                  });
  }
  const LabelExtents extents = label_extents(map.voxels);
  for (const auto& [label, counts] : surface) {
    const Object* object = map.objects.find(label);
    if (object == nullptr || 2 * counts.second <= counts.first) continue;
    Arrival arrival;
    PastObject* before = nullptr;
    const ExtentBox box = box_of(extents.at(label), double{map.voxels.voxel_size_m()});
    for (PastObject& past : map.history.past) {
      if (past.class_id != map.objects.class_of(label) || past.moved_to != PanopticId::kUnknown) continue;
      const double alike = likeness(past.box, box);
      if (alike <= arrival.confidence) continue;
      arrival.confidence = alike;
      before = &past;
    }
    if (before != nullptr) {
      before->moved_to = object->id;
      arrival.moved_from = before->id;
    }
    map.history.arrivals[object->id] = arrival;
  }
}

}  // namespace panoptic
