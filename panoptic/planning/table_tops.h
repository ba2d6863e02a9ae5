// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Tops of tables, desks, counters: of every class that the label set says carries things.
#pragma once

#include <vector>

#include "panoptic/home_plan.h"
#include "panoptic/planning/labelled_surface.h"

namespace panoptic {

std::vector<TableTop> find_table_tops(const LabelledSurface& surface, const LabelSet& labels, const SeenEmpty& seen_empty);

// Rectangles along the sides of the smallest box around the polygon that hold none of the taken cells, greedily the largest
// first, with sides of at least `least_m`.
std::vector<Polygon> free_rectangles(const Polygon& polygon, const std::vector<Vec2d>& taken, double cell_m, double least_m);

}  // namespace panoptic
