// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface of a map that was loaded; a Mapper keeps its own up to date (Mapper::mesh).
#pragma once

#include "panoptic/map.h"
#include "panoptic/mesh.h"
#include "panoptic/options.h"

namespace panoptic {

// Marching cubes over all blocks, as one mesh with shared vertices.
Mesh surface_of(const PanopticMap& map, const MesherOptions& options = {});

}  // namespace panoptic
