// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// What changed between two maps of one place in the same frame of reference: objects that vanished, appeared or moved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/map/map_merge.h"
#include "panoptic/session/map_query.h"

namespace panoptic {

enum class ChangeKind : std::uint8_t {
  kVanished,    // in A, and B saw that its place is empty
  kAppeared,    // in B, and A saw that its place was empty
  kMoved,       // vanished in one place and there in another, same class, similar size and shape
  kOtherLabel,  // the surface is there in both maps, but is another class or no object of its own in one of them
  kNotSeenInB,  // in A; B did not look there
  kNotSeenInA   // in B; A had not looked there
};
std::string_view name_of(ChangeKind kind);  // "vanished", "appeared", "moved", "other_label", "not_seen_in_b", "not_seen_in_a"

struct ObjectChange {
  ChangeKind kind = ChangeKind::kVanished;
  std::optional<FoundObject> before;  // in A
  std::optional<FoundObject> after;   // in B
  double empty_share = 0;             // of the object's surface, where the other map saw empty space; of kMoved: the old place
  double moved_m = 0;                 // kMoved: from centre to centre
};

struct MapDiff {
  std::vector<ObjectChange> changes;  // ascending by kind, then by the ids before and after
  std::size_t unchanged = 0;          // objects of A that are at their place in B, parts included
  std::size_t too_small = 0;          // objects without counterpart that are too small to say anything about
};

// Objects with fewer voxels near the surface are not compared.
inline constexpr std::uint64_t kLeastComparedVoxels = 30;
// Of an object's surface the other map must have seen this share, as surface or as empty, to say what became of it; what the
// greater part of that is decides.
inline constexpr double kLeastSeenShare = 0.5;
// Similar: the standard deviations of the surface along its principal axes differ by no more than this factor, give or take half
// a voxel; it is the same however the object was turned.
inline constexpr double kSimilarSpread = 1.6;

// Throws Error, naming the maps as `name_a` and `name_b`, unless they are comparable (map/object_matching.h).
MapDiff diff_maps(const MapWithFrames& a, const MapWithFrames& b, const std::string& name_a, const std::string& name_b);

}  // namespace panoptic
