// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/presence.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "panoptic/base/value_runs.h"
#include "panoptic/map/space_cells.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/objects/thing_shape.h"

namespace panoptic {
namespace {

constexpr double kBeside_m = 0.1;        // so near to a floor or a wall nothing is known to be free
constexpr std::uint64_t kLeastCame = 8;  // one part in so many: a thing that was always there has 3 % in free space, by errors
constexpr double kAtOnce_s = ObjectPresence::kStay_s + 1;  // what comes into free space is masked until it has stayed

bool is_surface(const Brick& brick, int voxel, float voxel_size_m) {
  if ((brick.stored() >> voxel & 1) == 0) return false;
  const int k = brick.place(voxel);
  return brick.plane(FloatPlane::kWeight)[k] > 0 &&
         std::abs(brick.plane(FloatPlane::kDistance)[k]) < kSurfaceBand_voxels * voxel_size_m;
}

VoxelIndex voxel_of(const CellIndex& brick, int voxel) {
  return {brick[0] * kBrickSide + (voxel & 3), brick[1] * kBrickSide + (voxel >> 2 & 3), brick[2] * kBrickSide + (voxel >> 4)};
}

std::vector<VoxelIndex> voxels_of(const LostSurface& lost) {
  std::vector<VoxelIndex> all;
  for (const auto& [cell, voxels] : lost.voxels) {
    for (std::uint64_t left = voxels; left != 0; left &= left - 1) all.push_back(voxel_of(cell, std::countr_zero(left)));
  }
  return all;
}

// A flag for each label.
using LabelFlags = std::vector<bool>;

bool holds_any(const VoxelBlock& block, const LabelFlags& wanted) {
  for (int n = 0; n < kBlockBricks; ++n) {
    const Brick& brick = block.brick(n);
    const std::uint16_t* labels = brick.plane(WordPlane::kLabel);
    for (int i = 0; i < brick.count(); i = end_of_run(labels, i, brick.count())) {
      if (wanted[labels[i]]) return true;
    }
  }
  return false;
}

// The surface voxels with the wanted labels, in one pass over the map.
std::map<LabelSlot, std::vector<VoxelIndex>> voxels_of(const LabelFlags& wanted, const VoxelMap& map) {
  std::map<LabelSlot, std::vector<VoxelIndex>> voxels;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    if (!holds_any(map.block(slot), wanted)) continue;
    visit_surface(map.block(slot), map.index_of(slot), map.voxel_size_m(), [&](LabelSlot label, const VoxelIndex& at) {
      if (wanted[number(label)]) voxels[label].push_back(at);
    });
  }
  return voxels;
}

// Two views from different places looked through the voxel, and none has seen a surface there since.
bool is_doubted(const FreeSpaceMap& space, const CellIndex& cell, int voxel) {
  const Doubt* doubt = space.doubt(cell);
  return doubt != nullptr && ((doubt->count[1] | doubt->count[2]) >> voxel & 1) != 0;
}

// Views see nothing there: it is doubted, or in a cell that is free.
bool is_seen_empty(const FreeSpaceMap& space, const VoxelIndex& at) {
  const CellIndex cell{at[0] >> 2, at[1] >> 2, at[2] >> 2};
  const SpaceChunk::Cells* cells = space.cells_of(block_of(cell));
  if (cells != nullptr && space_of((*cells)[static_cast<std::size_t>(number_of(cell))]) == Space::kFree) return true;
  return is_doubted(space, cell, (at[0] & 3) | (at[1] & 3) << 2 | (at[2] & 3) << 4);
}

struct SurfaceCount {
  std::uint64_t all = 0;
  std::uint64_t empty = 0;  // where views see nothing
};

std::map<LabelSlot, SurfaceCount> count_surface(const PanopticMap& map, const LabelFlags& wanted) {
  std::map<LabelSlot, SurfaceCount> counts;
  for (Slot slot = 0; slot < map.voxels.block_count(); ++slot) {
    const VoxelBlock& block = map.voxels.block(slot);
    if (!holds_any(block, wanted)) continue;
    visit_surface(block, map.voxels.index_of(slot), map.voxels.voxel_size_m(), [&](LabelSlot label, const VoxelIndex& at) {
      if (!wanted[number(label)]) return;
      SurfaceCount& count = counts[label];
      ++count.all;
      if (is_seen_empty(map.free_space, at)) ++count.empty;
    });
  }
  return counts;
}

// The surface of an object is all that it had, or else that which is at the place that is empty now: masks that reach too far
// leave the rest on what still stands there. False if neither is that of a thing.
bool find_place(std::vector<VoxelIndex> lost, const std::vector<VoxelIndex>& held, const PanopticMap& map, PastObject& past) {
  const double voxel_m = double{map.voxels.voxel_size_m()};
  std::vector<VoxelIndex> all = lost;
  all.insert(all.end(), held.begin(), held.end());
  if (is_thing(all, voxel_m, past)) return true;
  for (const VoxelIndex& at : held) {
    if (is_seen_empty(map.free_space, at)) lost.push_back(at);
  }
  const std::vector<VoxelIndex> empty = main_part(lost);
  if (empty.empty()) return false;
  const ExtentBox box = trimmed_box(empty, voxel_m);
  std::erase_if(all, [&](const VoxelIndex& at) { return !is_inside(box, at, voxel_m, kBeside_m); });
  return is_thing(all, voxel_m, past);
}

// Forgets every voxel with these labels, and what frames voted for them elsewhere: else the regularizer brought them back.
void clear_labels(const LabelFlags& cleared, FrameVotes& votes, VoxelMap& map) {
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    if (!holds_any(std::as_const(map).block(slot), cleared)) continue;
    for (int b = 0; b < kBlockBricks; ++b) {
      std::uint64_t own = 0;
      const Brick& brick = std::as_const(map).block(slot).brick(b);
      for (std::uint64_t left = brick.stored(); left != 0; left &= left - 1) {
        const int v = std::countr_zero(left);
        own |= std::uint64_t{cleared[brick.label(v)]} << v;
      }
      if (own == 0) continue;
      map.block(slot).forget(b, own);
      votes.forget(slot, b, own);
    }
    map.mark_changed(slot);
  }
  LabelFlags others = cleared;
  others.flip();
  votes.forget_unused(others);
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

std::vector<CellIndex> ObjectPresence::settled(std::span<const CellIndex> cells, const FramesBefore& before) {
  constexpr std::uint64_t kMissed = 2;  // frames that may miss it, however slow the camera is
  constexpr std::uint64_t kSeen = 5;    // frames that must see it at least, as many as free space takes
  const auto has_left = [&](const Stay& stay) { return stay.last < before.gap && before.now > stay.last + kMissed; };
  std::vector<CellIndex> settled;
  for (const CellIndex& cell : cells) {
    Stay& stay = state_.stays.try_emplace(cell, Stay{before.now, before.now}).first->second;
    if (has_left(stay)) stay.since = before.now;
    stay.last = before.now;
    if (stay.since < before.stay && before.now >= stay.since + kSeen) settled.push_back(cell);
  }
  std::erase_if(state_.stays, [&](const auto& entry) { return has_left(entry.second); });
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

// By label, whether most of what the object had is gone or lies where views see nothing.
std::vector<bool> ObjectPresence::gone_labels(const PanopticMap& map) {
  LabelFlags may_be_gone(kLabelSlots, false);
  for (const auto& [id, lost] : state_.lost) {
    const Object& object = *map.objects.find(id);
    may_be_gone[number(object.slot)] = lost.count() > 0 && object.last_frame <= lost.frame;
  }
  LabelFlags are_gone(kLabelSlots, false);
  const std::map<LabelSlot, SurfaceCount> surface = count_surface(map, may_be_gone);
  for (auto& [id, lost] : state_.lost) {
    const LabelSlot label = map.objects.find(id)->slot;
    const auto counted = surface.find(label);
    const SurfaceCount held = counted == surface.end() ? SurfaceCount{} : counted->second;
    lost.looked_at = lost.count();
    are_gone[number(label)] = may_be_gone[number(label)] && lost.looked_at + held.empty >= held.all - held.empty;
  }
  return are_gone;
}

void ObjectPresence::find_gone(const Rules& rules, FrameVotes& votes, PanopticMap& map) {
  if (!has_news(rules.is_last)) return;
  state_.lost = still_lost(map);
  const LabelFlags are_gone = gone_labels(map);
  map.voxels.begin_epoch();  // what is cleared changes after what others have seen or saved
  if (std::find(are_gone.begin(), are_gone.end(), true) == are_gone.end()) return;
  std::map<LabelSlot, std::vector<VoxelIndex>> left = voxels_of(are_gone, map.voxels);
  for (const auto& [id, lost] : state_.lost) {
    const Object& object = *map.objects.find(id);
    if (!are_gone[number(object.slot)]) continue;
    PastObject past = past_of(object, map.objects);
    past.gone_frame = lost.frame;
    const bool is_known = past.observations >= rules.min_observations && past.class_id != ClassId::kUnknown;
    if (is_known && find_place(voxels_of(lost), left[object.slot], map, past)) map.history.past.push_back(past);
  }
  std::erase_if(state_.lost, [&](const auto& entry) { return are_gone[number(map.objects.find(entry.first)->slot)]; });
  clear_labels(are_gone, votes, map.voxels);
}

// Objects that were not always there, ascending. Much of a thing that comes is in cells of which nothing was known: beside a
// wall, or where little was looked at. So a part of its surface in free space is enough, if that is as much as of a thing, and
// came up when the object was first seen: what is seen there by errors comes up at any time. Of what no network ever saw it is
// not known since when it is an object.
std::vector<bool> ObjectPresence::appeared(const TimeOf& time_of, const PanopticMap& map) const {
  struct Arrived {
    std::uint64_t all = 0;      // voxels
    std::uint64_t came = 0;     // of them in cells that were free
    std::uint64_t at_once = 0;  // of those that came up when the object was first seen, or before
  };
  std::map<LabelSlot, Arrived> surface;
  for (Slot slot = 0; slot < map.voxels.block_count(); ++slot) {
    visit_surface(map.voxels.block(slot), map.voxels.index_of(slot), map.voxels.voxel_size_m(),
                  [&](LabelSlot label, const VoxelIndex& at) {
                    const Object* object = map.objects.find(label);
                    if (object == nullptr || object->observations == 0) return;
                    Arrived& arrived = surface[label];
                    ++arrived.all;
                    const auto came = state_.came_up.find({at[0] >> 2, at[1] >> 2, at[2] >> 2});
                    if (came == state_.came_up.end()) return;
                    ++arrived.came;
                    if (time_of(came->second) - kAtOnce_s <= time_of(object->first_frame)) ++arrived.at_once;
                  });
  }
  LabelFlags appeared(kLabelSlots, false);
  for (const auto& [label, arrived] : surface) {
    const bool is_part = kLeastCame * arrived.at_once >= arrived.all &&
                         area_of(arrived.at_once, double{map.voxels.voxel_size_m()}) >= kLeastArea_m2;
    appeared[number(label)] = 2 * arrived.came > arrived.all || is_part;
  }
  return appeared;
}

void ObjectPresence::find_arrivals(const TimeOf& time_of, PanopticMap& map) const {
  struct Match {
    double alike = 0;
    LabelSlot label = LabelSlot::kUnknown;
    PastObject* past = nullptr;
  };
  // Moves of things that are gone again stay as they were told.
  for (PastObject& past : map.history.past) {
    if (map.objects.find(past.moved_to) != nullptr) past.moved_to = PanopticId::kUnknown;
  }
  map.history.arrivals.clear();
  if (state_.came_up.empty()) return;
  std::vector<Match> matches;
  for (const auto& [label, voxels] : voxels_of(appeared(time_of, map), map.voxels)) {
    const Object& object = *map.objects.find(label);
    map.history.arrivals[object.id] = {};
    const std::vector<VoxelIndex> part = main_part(voxels);
    const std::vector<VoxelIndex>& body = part.empty() ? voxels : part;
    const ExtentBox box = trimmed_box(body, double{map.voxels.voxel_size_m()});
    for (PastObject& past : map.history.past) {
      // A thing that was seen at its old place after this one came is another one.
      const bool may_be = past.class_id == map.objects.class_of(label) && past.last_frame < object.first_frame &&
                          past.moved_to == PanopticId::kUnknown;
      if (!may_be) continue;
      const double alike = likeness(past.box, box) * share_of(static_cast<double>(past.voxels), static_cast<double>(body.size()));
      if (alike > 0) matches.push_back({alike, label, &past});
    }
  }
  // The most alike first, each once.
  std::stable_sort(matches.begin(), matches.end(), [](const Match& a, const Match& b) { return a.alike > b.alike; });
  for (const Match& match : matches) {
    const PanopticId id = map.objects.find(match.label)->id;
    Arrival& arrival = map.history.arrivals[id];
    if (match.past->moved_to != PanopticId::kUnknown || arrival.moved_from != PanopticId::kUnknown) continue;
    match.past->moved_to = id;
    arrival.moved_from = match.past->id;
    arrival.confidence = match.alike;
  }
}

}  // namespace panoptic
