// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The memory of object maintenance from one time to the next: to save it, and to go on from there.
#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include "panoptic/labels.h"

namespace panoptic {

// For each pair of objects, first < second, the number of frames in which both had a mask of their own.
using Covisibility = std::map<std::pair<PanopticId, PanopticId>, std::uint32_t>;

struct MaintenanceState {
  Covisibility covisible;
  std::uint64_t epoch = 0;  // of the map, up to which its changes were looked at
};

}  // namespace panoptic
