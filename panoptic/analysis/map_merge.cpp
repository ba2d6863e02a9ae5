// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/analysis/map_merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

// Frame numbers of real recordings are far below; beyond, shifts could overflow.
constexpr std::int64_t kMostFrame = std::int64_t{1} << 48;

using SlotTable = std::vector<std::uint16_t>;  // by LabelSlot

// Works in double precision, in which the products of floats are exact: a voxel merged with itself keeps its distance, bit for
// bit.
void merge_distance(const BlockPlanes& from, std::size_t v, BlockPlanes& into) {
  const double old_weight = into.weight[v];
  const double weight = from.weight[v];
  const double mean = (old_weight * into.distance[v] + weight * from.distance[v]) / (old_weight + weight);
  into.distance[v] = static_cast<float>(mean);
}

// 0 means "no colour yet".
void merge_channel(std::uint16_t from, std::uint16_t& into, double from_weight, double into_weight) {
  if (from == 0) return;
  if (into == 0) {
    into = from;
    return;
  }
  const double mean = (into_weight * into + from_weight * from) / (into_weight + from_weight);
  into = static_cast<std::uint16_t>(std::lround(mean));
}

// Beyond the limit all votes fade alike, as in fusion.
void merge_votes(const BlockPlanes& from, std::uint16_t label, std::size_t v, float max_weight, BlockPlanes& into) {
  float& weight = into.label_weight[v];
  const float more = from.label_weight[v];
  if (label == into.label[v]) {
    weight += more;
  } else if (more > weight) {
    into.label[v] = label;
    weight = more - weight;
  } else {
    weight -= more;
  }
  into.vote_sum[v] += from.vote_sum[v];
  if (into.vote_sum[v] <= max_weight) return;
  weight = std::min(max_weight, weight * (max_weight / into.vote_sum[v]));
  into.vote_sum[v] = max_weight;
}

// The lower one; 0 = none.
float common_max_weight(float a, float b) { return a > 0 && b > 0 ? std::min(a, b) : std::max(a, b); }

// The lowest and the highest frame number that a map speaks of, and the widest bin of its vote histories.
struct FrameNumbers {
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  std::int64_t highest = std::numeric_limits<std::int64_t>::min();
  int log2_widest_bin = 0;

  void add(std::int64_t frame) {
    lowest = std::min(lowest, frame);
    highest = std::max(highest, frame);
  }
};

FrameNumbers frame_numbers(const MapWithFrames& map, const std::string& name) {
  FrameNumbers numbers;
  for (const FrameRecord& frame : map.frames) numbers.add(frame.frame);
  for (const Object& object : map.saved.map.objects.state().objects) {
    if (object.id == PanopticId::kUnknown) continue;
    numbers.add(object.first_frame);
    numbers.add(object.last_frame);
    numbers.log2_widest_bin = std::max(numbers.log2_widest_bin, object.votes.log2_frames_per_bin());
    for (const ObjectView& view : object.best_views.views()) numbers.add(view.frame);
  }
  constexpr int kWidestLog2 = 47;
  const bool any = numbers.lowest <= numbers.highest;
  if (any && (numbers.lowest < -kMostFrame || numbers.highest > kMostFrame || numbers.log2_widest_bin > kWidestLog2)) {
    throw Error(
        fmt::format("{} has frame numbers beyond 2^48, which cannot be merged; number the recording's frames from 0", name));
  }
  return numbers;
}

// The shift that brings b's frame numbers above a's; a whole number of bins of any vote history of b.
std::int64_t shift_between(const FrameNumbers& a, const FrameNumbers& b) {
  if (a.lowest > a.highest || b.lowest > b.highest || b.lowest > a.highest) return 0;
  const std::int64_t bin = std::int64_t{1} << b.log2_widest_bin;
  return (a.highest - b.lowest + bin) / bin * bin;
}

// Whose ids it names in `parts` are another map's, so they are left out.
Object shifted(const Object& object, std::int64_t shift) {
  Object moved = object;
  moved.parts = {};
  moved.first_frame += shift;
  moved.last_frame += shift;
  std::vector<VoteHistory::Bin> bins = object.votes.bins();
  const int log2 = object.votes.log2_frames_per_bin();
  for (VoteHistory::Bin& bin : bins) bin.number += shift / static_cast<std::int64_t>(object.votes.frames_per_bin());
  moved.votes = VoteHistory(std::move(bins), log2);
  moved.best_views = BestViews();
  for (ObjectView view : object.best_views.views()) {
    view.frame += shift;
    moved.best_views.add(view);
  }
  return moved;
}

// The objects of both maps on their way into one registry.
class MergedObjects {
 public:
  MergedObjects(ObjectRegistry a, std::string names)
      : registry_(std::move(a)), names_(std::move(names)), slots_of_a_(identity()), slots_of_b_(identity()) {}

  void take_up(const ObjectRegistry& b, const std::vector<ObjectMatch>& matches, std::int64_t shift);
  const ObjectRegistry& registry() const { return registry_; }
  const SlotTable& slots_of_a() const { return slots_of_a_; }
  const SlotTable& slots_of_b() const { return slots_of_b_; }

 private:
  static SlotTable identity() {
    SlotTable table(kLabelSlots);
    std::iota(table.begin(), table.end(), std::uint16_t{0});
    return table;
  }
  LabelSlot new_slot();
  void give_slots(const ObjectRegistry& b, const std::map<PanopticId, PanopticId>& whole_of);
  void join_part(const Object& part, LabelSlot into);

  ObjectRegistry registry_;
  std::string names_;
  SlotTable slots_of_a_;
  SlotTable slots_of_b_;
};

LabelSlot MergedObjects::new_slot() {
  const std::optional<LabelSlot> slot = registry_.create();
  if (!slot) throw Error(names_ + " have more objects together than there are ids; merge smaller maps");
  return *slot;
}

// Gives the objects of b the slots of those of a that they are parts of, or new ones.
void MergedObjects::give_slots(const ObjectRegistry& b, const std::map<PanopticId, PanopticId>& whole_of) {
  for (std::size_t i = 0; i < b.state().objects.size(); ++i) {
    const Object& theirs = b.state().objects[i];
    std::uint16_t& merged = slots_of_b_[b.first_thing() + i];
    merged = 0;
    if (theirs.id == PanopticId::kUnknown) continue;
    const auto whole = whole_of.find(theirs.id);
    merged = number(whole == whole_of.end() ? new_slot() : registry_.find(whole->second)->slot);
  }
}

void MergedObjects::join_part(const Object& part, LabelSlot into) {
  Object whole = *registry_.find(into);
  add_observations(part, whole);
  whole.ruled_out.insert(part.ruled_out.begin(), part.ruled_out.end());
  slots_of_a_[number(part.slot)] = number(into);
  registry_.merge(part.slot, into, whole.last_frame);
  registry_.rule_out(into, whole.ruled_out);
}

void MergedObjects::take_up(const ObjectRegistry& b, const std::vector<ObjectMatch>& matches, std::int64_t shift) {
  std::map<PanopticId, PanopticId> whole_of;  // of the objects of b that have a counterpart
  for (const ObjectMatch& match : matches) {
    if (match.kind != MatchKind::kPartOfB) whole_of[match.b] = match.a;
  }
  give_slots(b, whole_of);
  RegistryState state = registry_.state();
  for (const Object& theirs : b.state().objects) {
    if (theirs.id == PanopticId::kUnknown) continue;
    Object object = shifted(theirs, shift);
    Object& mine = state.objects[slots_of_b_[number(theirs.slot)] - registry_.first_thing()];
    if (whole_of.contains(theirs.id)) {
      add_observations(object, mine);
      mine.ruled_out.insert(object.ruled_out.begin(), object.ruled_out.end());
    } else {
      object.id = mine.id;
      object.slot = mine.slot;
      mine = std::move(object);
    }
  }
  registry_ = ObjectRegistry(registry_.first_thing(), std::move(state));
  for (const ObjectMatch& match : matches) {
    if (match.kind != MatchKind::kPartOfB) continue;
    join_part(*registry_.find(match.a), static_cast<LabelSlot>(slots_of_b_[number(b.find(match.b)->slot)]));
  }
}

// Clears bricks of the first map whose cells the later one has seen to be empty from so many views as carving takes.
void carve_seen_through(const PanopticMap& later, VoxelMap& map) {
  const int views = CarvingOptions{}.views;
  parallel_for(map.block_count(), [&](std::size_t i) {
    const BlockIndex index = map.index_of(static_cast<Slot>(i));
    const VoxelBlock* theirs = later.voxels.find(index);
    VoxelBlock& block = map.block(static_cast<Slot>(i));
    for (int n = 0; n < kBlockBricks; ++n) {
      const std::uint64_t stored = block.brick(n).stored();
      const bool observed = theirs != nullptr && theirs->brick(n).stored() != 0;
      if (stored == 0 || observed || later.free_space.record(cell_of(index, n)).evidence < views) continue;
      block.forget(n, stored);
    }
  });
}

void merge_voxels(const VoxelMap& b, const MergedObjects& objects, float max_weight, VoxelMap& map) {
  map.begin_epoch();
  std::vector<Slot> into(b.block_count());
  for (Slot slot = 0; slot < b.block_count(); ++slot) into[slot] = map.allocate(b.index_of(slot));
  parallel_for(map.block_count(), [&](std::size_t i) { map.block(static_cast<Slot>(i)).rename_labels(objects.slots_of_a()); });
  parallel_for(into.size(), [&](std::size_t i) {
    const auto from = std::make_unique_for_overwrite<BlockPlanes>();
    const auto merged = std::make_unique_for_overwrite<BlockPlanes>();
    b.block(static_cast<Slot>(i)).unpack(*from);
    map.block(into[i]).unpack(*merged);
    merge_block(*from, objects.slots_of_b(), max_weight, *merged);
    map.block(into[i]).pack(*merged);
  });
  for (Slot slot = 0; slot < map.block_count(); ++slot) map.mark_changed(slot);
}

}  // namespace

void merge_block(const BlockPlanes& from, const std::vector<std::uint16_t>& merged_slot, float max_weight, BlockPlanes& into) {
  for (std::size_t v = 0; v < kBlockVoxels; ++v) {
    const double weight = from.weight[v];
    if (weight > 0) {
      const double old_weight = into.weight[v];
      merge_distance(from, v, into);
      merge_channel(from.red[v], into.red[v], weight, old_weight);
      merge_channel(from.green[v], into.green[v], weight, old_weight);
      merge_channel(from.blue[v], into.blue[v], weight, old_weight);
      into.weight[v] = static_cast<float>(old_weight + weight);
    }
    into.weight[v] = std::min(max_weight, into.weight[v]);
    merge_votes(from, merged_slot[from.label[v]], v, max_weight, into);
  }
}

MapMerge merge_maps(MapWithFrames a, const MapWithFrames& b, const std::string& name_a, const std::string& name_b) {
  require_comparable(a.saved.header(), b.saved.header(), name_a, name_b);
  MapMerge merge{.merged = std::move(a)};
  SavedMap& into = merge.merged.saved;
  merge.frame_shift = shift_between(frame_numbers(merge.merged, name_a), frame_numbers(b, name_b));
  merge.matches = match_objects(into, b.saved);
  MergedObjects objects(into.map.objects, name_a + " and " + name_b);
  objects.take_up(b.saved.map.objects, merge.matches, merge.frame_shift);
  into.options.max_weight = common_max_weight(into.options.max_weight, b.saved.options.max_weight);
  carve_seen_through(b.saved.map, into.map.voxels);
  merge_voxels(b.saved.map.voxels, objects, std::min(into.map.voxels.max_weight(), b.saved.map.voxels.max_weight()),
               into.map.voxels);
  into.map.free_space.merge(b.saved.map.free_space);
  into.map.objects = objects.registry();
  into.map.prune();
  std::erase_if(into.map.history.arrivals, [&](const auto& arrival) { return into.map.objects.find(arrival.first) == nullptr; });
  into.notes = {};
  std::int64_t position = merge.merged.frames.empty() ? 0 : merge.merged.frames.back().position + 1;
  for (FrameRecord record : b.frames) {
    record.position = position++;
    record.frame += merge.frame_shift;
    merge.merged.frames.push_back(std::move(record));
  }
  return merge;
}

}  // namespace panoptic
