// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The fate of objects: those that are gone, and those that came or were moved while the map was made.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/objects.h"

namespace panoptic {

// An object that was looked through. No voxel holds it any more, and the registry has forgotten it.
struct PastObject {
  PanopticId id = PanopticId::kUnknown;
  ClassId class_id = ClassId::kUnknown;
  double probability = 0;  // of that class, Eq. 12
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;  // in which a network saw it
  std::uint64_t observations = 0;
  std::int64_t gone_frame = 0;                                 // after which it was known to be gone
  ExtentBox box{Vec3d::Zero(), Vec3d::Zero(), Vec3d::Zero()};  // its last place
  std::uint64_t voxels = 0;                                    // of its surface
  PanopticId moved_to = PanopticId::kUnknown;                  // the object that it is now; kUnknown: it is gone
};

// A place to which something came that is in the map now.
struct Arrival {
  PanopticId moved_from = PanopticId::kUnknown;  // the object that it was before; kUnknown: it is new
  double confidence = 0;                         // that it is the same, 0 to 1: how alike the two are in size; 0 for new ones
};

struct ObjectHistory {
  std::vector<PastObject> past;            // in the order in which they were found to be gone
  std::map<PanopticId, Arrival> arrivals;  // objects of the map that were not there from the beginning
};

}  // namespace panoptic
