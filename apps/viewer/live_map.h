// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A snapshot in the form that planning reads: the surface as samples, and a map of its labels and objects without voxels. Whoever
// plans from it needs neither the mapper nor its lock.
#pragma once

#include "panoptic/map.h"
#include "panoptic/mapping/snapshot.h"
#include "panoptic/planning/surface_samples.h"

namespace panoptic {

struct LiveMap {
  PanopticMap map;         // without voxels and free space
  SurfaceByBlock surface;  // by chunk; labels are slots of `map`
};

// The samples are those that surface_samples makes of the voxels, but where the rims of the surface have no triangles.
LiveMap live_map(const Snapshot& snapshot, const SnapshotScene& scene);

}  // namespace panoptic
