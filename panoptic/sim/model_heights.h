// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A thing of the scene seen from straight above: how high its surface is, cell by cell, and its level parts.
#pragma once

#include <optional>
#include <vector>

#include "panoptic/base/flat_grid.h"
#include "panoptic/sim/scene.h"

namespace panoptic {

// In the object's own axes (front towards -y), scaled; heights above the floor of the scene. NaN where nothing is.
struct ModelHeights {
  FlatGrid grid;
  std::vector<float> top_m;
};

// Cells of 1 cm. REQUIRES an object that stands upright: its pose turns about z alone.
ModelHeights model_heights(const Scene& scene, const SceneObject& object);

struct HeightRange {
  double low_m = 0;
  double high_m = 0;
};

// The largest part within a range of heights that rises nowhere by more than 40 degrees, and the parts level with it (within 5
// cm, cushions of a sofa). Nothing if it is less than `least_m2`.
struct LevelPart {
  CellSet cells;
  double height_m = 0;  // the median
  double area_m2 = 0;
};
std::optional<LevelPart> level_part(const ModelHeights& heights, const HeightRange& range, double least_m2);

// The hull of the cells if they fill nine tenths of it, else their outline, in the object's axes.
Polygon shape_of(const FlatGrid& grid, const CellSet& cells);

}  // namespace panoptic
