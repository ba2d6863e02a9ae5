// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/analysis/object_matching.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/map/label_extents.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

using SlotPair = std::pair<LabelSlot, LabelSlot>;
using Counts = std::map<SlotPair, std::uint64_t>;

// How many voxels that both maps observed, near the surface of either, bear each pair of labels.
Counts common_labels(const VoxelBlock& a, const VoxelBlock& b, float band_m) {
  Counts counts;
  SlotPair last;
  std::uint64_t* count = nullptr;  // of `last`: neighbours mostly bear the same labels
  const auto compare = [&](const Voxel& in_a, const Voxel& in_b) {
    const bool observed = in_a.weight > 0 && in_b.weight > 0;
    if (!observed || std::min(std::abs(in_a.distance), std::abs(in_b.distance)) > band_m) return;
    const SlotPair pair(static_cast<LabelSlot>(in_a.label), static_cast<LabelSlot>(in_b.label));
    if (count == nullptr || pair != last) count = &counts[pair];
    last = pair;
    ++*count;
  };
  for (int n = 0; n < kBlockBricks; ++n) {
    for (std::uint64_t both = a.brick(n).stored() & b.brick(n).stored(); both != 0; both &= both - 1) {
      const int offset = offset_in_block(n, std::countr_zero(both));
      compare(a.at(offset), b.at(offset));
    }
  }
  return counts;
}

Counts common_labels(const VoxelMap& a, const VoxelMap& b) {
  const float band_m = kSurfaceBand_voxels * a.voxel_size_m();
  std::vector<Counts> per_block(a.block_count());
  parallel_for(per_block.size(), [&](std::size_t i) {
    const auto slot = static_cast<Slot>(i);
    const VoxelBlock* other = b.find(a.index_of(slot));
    if (other != nullptr) per_block[i] = common_labels(a.block(slot), *other, band_m);
  });
  Counts all;
  for (const Counts& of_block : per_block) {
    for (const auto& [pair, count] : of_block) all[pair] += count;
  }
  return all;
}

// Two objects that share voxels.
struct Overlap {
  PanopticId a = PanopticId::kUnknown;
  PanopticId b = PanopticId::kUnknown;
  bool same_class = false;
  bool enough = false;
  double both = 0;  // voxels that are a's and b's
  double of_a = 0;  // that are a's, b's, among those that both maps observed
  double of_b = 0;

  double iou() const { return both / (of_a + of_b - both); }
  double worth() const { return iou() * (same_class ? 1.0 : kOtherClassWorth); }
};

std::uint64_t voxels_of(const LabelExtents& extents, LabelSlot slot) {
  const auto found = extents.find(slot);
  return found == extents.end() ? 0 : found->second.voxels;
}

std::vector<Overlap> overlaps_of(const SavedMap& a, const SavedMap& b) {
  const Counts counts = common_labels(a.map.voxels, b.map.voxels);
  std::map<LabelSlot, std::uint64_t> of_a;
  std::map<LabelSlot, std::uint64_t> of_b;
  for (const auto& [pair, count] : counts) {
    of_a[pair.first] += count;
    of_b[pair.second] += count;
  }
  const LabelExtents extents_a = label_extents(a.map.voxels);
  const LabelExtents extents_b = label_extents(b.map.voxels);
  std::vector<Overlap> overlaps;
  for (const auto& [pair, count] : counts) {
    const auto& [slot_a, slot_b] = pair;
    const Object* object_a = a.map.objects.find(slot_a);
    const Object* object_b = b.map.objects.find(slot_b);
    if (object_a == nullptr || object_b == nullptr) continue;
    const std::uint64_t smaller = std::min(voxels_of(extents_a, slot_a), voxels_of(extents_b, slot_b));
    overlaps.push_back({object_a->id, object_b->id, a.map.objects.class_of(slot_a) == b.map.objects.class_of(slot_b),
                        count >= kLeastCommonVoxels || 2 * count >= smaller, static_cast<double>(count),
                        static_cast<double>(of_a[slot_a]), static_cast<double>(of_b[slot_b])});
  }
  return overlaps;
}

// Who is spoken for.
struct Taken {
  std::set<PanopticId> a;
  std::set<PanopticId> b;
};

void match_pairs(std::vector<Overlap>& overlaps, Taken& taken, std::vector<ObjectMatch>& matches) {
  std::sort(overlaps.begin(), overlaps.end(), [](const Overlap& x, const Overlap& y) {
    return std::tuple(-x.worth(), x.a, x.b) < std::tuple(-y.worth(), y.a, y.b);
  });
  for (const Overlap& o : overlaps) {
    if (!o.enough || o.worth() < kSameObjectIou || taken.a.contains(o.a) || taken.b.contains(o.b)) continue;
    matches.push_back({o.a, o.b, MatchKind::kSame, o.iou()});
    taken.a.insert(o.a);
    taken.b.insert(o.b);
  }
}

bool is_part(double both, double of_part, double of_whole) {
  return both >= kPartInside * of_part && of_part <= kPartSize * of_whole;
}

void match_parts(const std::vector<Overlap>& overlaps, Taken& taken, std::vector<ObjectMatch>& matches) {
  Taken wholes;
  for (const Overlap& o : overlaps) {
    if (!o.enough || !o.same_class) continue;
    if (is_part(o.both, o.of_b, o.of_a) && !taken.b.contains(o.b) && !wholes.b.contains(o.b)) {
      matches.push_back({o.a, o.b, MatchKind::kPartOfA, o.iou()});
      taken.b.insert(o.b);
      wholes.a.insert(o.a);
    } else if (is_part(o.both, o.of_a, o.of_b) && !taken.a.contains(o.a) && !wholes.a.contains(o.a)) {
      matches.push_back({o.a, o.b, MatchKind::kPartOfB, o.iou()});
      taken.a.insert(o.a);
      wholes.b.insert(o.b);
    }
  }
}

bool same_classes(const LabelSet& a, const LabelSet& b) {
  const auto same = [](const LabelClass& x, const LabelClass& y) {
    return x.id == y.id && x.name == y.name && x.is_thing == y.is_thing;
  };
  return std::equal(a.classes().begin(), a.classes().end(), b.classes().begin(), b.classes().end(), same);
}

}  // namespace

std::vector<ObjectMatch> match_objects(const SavedMap& a, const SavedMap& b) {
  std::vector<Overlap> overlaps = overlaps_of(a, b);
  std::vector<ObjectMatch> matches;
  Taken taken;
  match_pairs(overlaps, taken, matches);
  match_parts(overlaps, taken, matches);
  std::sort(matches.begin(), matches.end(), [](const ObjectMatch& x, const ObjectMatch& y) {
    return std::tuple(x.kind, x.a, x.b) < std::tuple(y.kind, y.a, y.b);
  });
  return matches;
}

void require_comparable(const MapHeader& header_a, const MapHeader& header_b, const std::string& a, const std::string& b) {
  const MapOptions& x = header_a.options;
  const MapOptions& y = header_b.options;
  if (x.voxel_size_m != y.voxel_size_m) {
    throw Error(fmt::format("{} has voxels of {} m, {} of {} m: map both with the same map.voxel_size_m", a, x.voxel_size_m, b,
                            y.voxel_size_m));
  }
  if (x.truncation_voxels != y.truncation_voxels) {
    throw Error(fmt::format("{} has a truncation of {} voxels, {} of {}: map both with the same map.truncation_voxels", a,
                            x.truncation_voxels, b, y.truncation_voxels));
  }
  if (!same_classes(header_a.labels, header_b.labels)) {
    throw Error(fmt::format("{} has the label set '{}', {} has '{}', and their classes differ: map both with the same --labels",
                            a, header_a.labels.name(), b, header_b.labels.name()));
  }
}

}  // namespace panoptic
