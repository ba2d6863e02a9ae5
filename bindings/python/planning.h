// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "bindings/python/map.h"
#include "panoptic/planning.h"

namespace panoptic::python {

// The frame that was given, else the map's own, with what is known of upwards. Takes the time of reading the surface then,
// without Python's lock. REQUIRES a Use of the map. Throws Error.
UpFrame frame_or_own(const MapView& view, const std::optional<UpFrame>& frame);

}  // namespace panoptic::python
