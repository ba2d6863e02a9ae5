// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the objects that are the same in two maps of one place. Only voxels that both maps observed count, near the surface of
// either: an object of which the two maps saw different parts is the same where both looked.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/labels.h"
#include "panoptic/map/label_extents.h"
#include "panoptic/map_file.h"

namespace panoptic {

// The overlap from which two objects are one, as in tracking (Eq. 4).
inline constexpr double kSameObjectIou = 0.25;
// The worth of an overlap across classes, compared with one within a class: objects of different classes need twice as much to
// be one.
inline constexpr double kOtherClassWorth = 0.5;
// A small object that lies with this share in a larger one of its class in the other map is a part of it, ...
inline constexpr double kPartInside = 0.7;
// ... if it is no more than this share of it: else two chairs that the other map took for one would become one.
inline constexpr double kPartSize = 0.3;
// Fewer common voxels say nothing, unless they are half of the smaller object.
inline constexpr std::uint64_t kLeastCommonVoxels = 24;

enum class MatchKind : std::uint8_t {
  kSame,     // a and b are one object
  kPartOfA,  // b is a part of a
  kPartOfB   // a is a part of b
};

struct ObjectMatch {
  PanopticId a = PanopticId::kUnknown;
  PanopticId b = PanopticId::kUnknown;
  MatchKind kind = MatchKind::kSame;
  double iou = 0;

  bool operator==(const ObjectMatch&) const = default;
};

// Pairs first, the best overlap first, every object in at most one; then the parts among those that are in no pair. A part has no
// parts. Ties go to lower ids. Ascending by kind, a, b. REQUIRES maps that require_comparable accepts.
std::vector<ObjectMatch> match_objects(const SavedMap& a, const SavedMap& b);

// Throws Error unless voxel sizes, truncations and label sets (colours aside) are the same; `a` and `b` name the maps.
void require_comparable(const MapHeader& header_a, const MapHeader& header_b, const std::string& a, const std::string& b);

}  // namespace panoptic
