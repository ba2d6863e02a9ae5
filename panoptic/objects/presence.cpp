// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/presence.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

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

std::vector<VoxelIndex> voxels_of(const LostSurface& lost) {
  std::vector<VoxelIndex> all;
  for (const auto& [cell, voxels] : lost.voxels) {
    for (std::uint64_t left = voxels; left != 0; left &= left - 1) all.push_back(voxel_of(cell, std::countr_zero(left)));
  }
  return all;
}

// The surface voxels with these labels, which ascend, in one pass over the map.
std::map<LabelSlot, std::vector<VoxelIndex>> voxels_of(const std::vector<LabelSlot>& labels, const VoxelMap& map) {
  std::map<LabelSlot, std::vector<VoxelIndex>> voxels;
  for (Slot slot = 0; slot < map.block_count() && !labels.empty(); ++slot) {
    visit_surface(map.block(slot), map.index_of(slot), map.voxel_size_m(), [&](LabelSlot label, const VoxelIndex& at) {
      if (std::binary_search(labels.begin(), labels.end(), label)) voxels[label].push_back(at);
    });
  }
  return voxels;
}

// The box around the voxels without the outermost fiftieth at either end of each axis: masks reach over borders now and then.
ExtentBox trimmed_box(std::vector<VoxelIndex> voxels, double voxel_m) {
  constexpr std::size_t kTrimmed = 50;
  ExtentBox box;
  const std::size_t cut = voxels.size() / kTrimmed;
  Vec3d sum = Vec3d::Zero();
  for (const VoxelIndex& at : voxels) sum += Vec3d(at[0], at[1], at[2]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::sort(voxels.begin(), voxels.end(), [&](const VoxelIndex& a, const VoxelIndex& b) { return a[axis] < b[axis]; });
    const auto a = static_cast<Eigen::Index>(axis);
    box.min_m[a] = voxel_m * voxels[cut][axis];
    box.max_m[a] = voxel_m * (voxels[voxels.size() - 1 - cut][axis] + 1);
    box.center_m[a] = voxel_m * (sum[a] / static_cast<double>(voxels.size()) + 0.5);
  }
  return box;
}

// Two views from different places looked through the voxel, and none has seen a surface there since.
bool is_doubted(const FreeSpaceMap& space, const CellIndex& cell, int voxel) {
  const Doubt* doubt = space.doubt(cell);
  return doubt != nullptr && ((doubt->count[1] | doubt->count[2]) >> voxel & 1) != 0;
}

struct SurfaceCount {
  std::uint64_t all = 0;
  std::uint64_t empty = 0;  // where views see nothing: in a cell that is free, or doubted
};

std::map<LabelSlot, SurfaceCount> count_surface(const PanopticMap& map) {
  std::map<LabelSlot, SurfaceCount> counts;
  for (Slot slot = 0; slot < map.voxels.block_count(); ++slot) {
    const BlockIndex index = map.voxels.index_of(slot);
    const SpaceChunk::Cells* cells = map.free_space.cells_of(index);
    visit_surface(map.voxels.block(slot), index, map.voxels.voxel_size_m(), [&](LabelSlot label, const VoxelIndex& at) {
      if (!map.labels.is_object(label)) return;
      const CellIndex cell{at[0] >> 2, at[1] >> 2, at[2] >> 2};
      const int voxel = (at[0] & 3) | (at[1] & 3) << 2 | (at[2] & 3) << 4;
      const bool is_free = cells != nullptr && space_of((*cells)[static_cast<std::size_t>(number_of(cell))]) == Space::kFree;
      SurfaceCount& count = counts[label];
      ++count.all;
      count.empty += is_free || is_doubted(map.free_space, cell, voxel) ? 1 : 0;
    });
  }
  return counts;
}

// Forgets every voxel with this label, and what frames voted for it elsewhere: else the regularizer brought it back.
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
  std::vector<bool> others(std::size_t{number(LabelSlot::kNoVote)} + 1, true);
  others[number(label)] = false;
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

// The smaller of two sizes as a share of the larger one.
double share(double a, double b) { return std::min(a, b) / std::max({a, b, 1e-6}); }

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
    const double edge = share(ea[n], eb[n]);
    if (edge < kLeastAlike) return 0;
    alike *= edge;
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

void ObjectPresence::find_gone(const Rules& rules, FrameVotes& votes, PanopticMap& map) {
  if (!has_news(rules.is_last)) return;
  state_.lost = still_lost(map);
  const std::map<LabelSlot, SurfaceCount> surface = count_surface(map);
  map.voxels.begin_epoch();  // what is cleared changes after what others have seen or saved
  for (auto entry = state_.lost.begin(); entry != state_.lost.end();) {
    auto& [id, lost] = *entry;
    const Object& object = *map.objects.find(id);
    const auto counted = surface.find(object.slot);
    const SurfaceCount held = counted == surface.end() ? SurfaceCount{} : counted->second;
    const std::uint64_t gone = lost.count();
    if (gone + held.empty < held.all - held.empty || gone == 0 || object.last_frame > lost.frame) {
      lost.looked_at = gone;
      ++entry;
      continue;
    }
    std::vector<VoxelIndex> voxels = voxels_of(std::vector{object.slot}, map.voxels)[object.slot];
    const std::vector<VoxelIndex> lost_voxels = voxels_of(lost);
    voxels.insert(voxels.end(), lost_voxels.begin(), lost_voxels.end());
    PastObject past = past_of(object, map.objects);
    past.gone_frame = lost.frame;
    past.voxels = voxels.size();
    past.box = trimmed_box(std::move(voxels), double{map.voxels.voxel_size_m()});
    if (past.observations >= rules.min_observations && past.class_id != ClassId::kUnknown) map.history.past.push_back(past);
    clear_label(object.slot, votes, map.voxels);
    entry = state_.lost.erase(entry);
  }
}

// Objects of which more than half of the surface lies where there was free space for certain, ascending.
std::vector<LabelSlot> ObjectPresence::appeared(const PanopticMap& map) const {
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
  std::vector<LabelSlot> appeared;
  for (const auto& [label, counts] : surface) {
    if (map.objects.find(label) != nullptr && 2 * counts.second > counts.first) appeared.push_back(label);
  }
  return appeared;
}

void ObjectPresence::find_arrivals(PanopticMap& map) const {
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
  for (const auto& [label, voxels] : voxels_of(appeared(map), map.voxels)) {
    const Object& object = *map.objects.find(label);
    map.history.arrivals[object.id] = {};
    const ExtentBox box = trimmed_box(voxels, double{map.voxels.voxel_size_m()});
    for (PastObject& past : map.history.past) {
      // A thing that was seen at its old place after this one came is another one.
      const bool may_be = past.class_id == map.objects.class_of(label) && past.last_frame < object.first_frame &&
                          past.moved_to == PanopticId::kUnknown;
      if (!may_be) continue;
      const double alike = likeness(past.box, box) * share(static_cast<double>(past.voxels), static_cast<double>(voxels.size()));
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
