// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "panoptic/base/config.h"
#include "panoptic/options.h"

namespace panoptic {

Fields fields(MapOptions& options);
Fields grid_fields(MapOptions& options);  // those that decide what the map is: not where it lies

}  // namespace panoptic
