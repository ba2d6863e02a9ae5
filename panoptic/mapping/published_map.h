// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "panoptic/mapping/snapshot.h"
#include "panoptic/online.h"

namespace panoptic {

// The chunks of a snapshot as one mesh.
PublishedMap published_map(const Snapshot& snapshot, const LabelSet& labels);

}  // namespace panoptic
