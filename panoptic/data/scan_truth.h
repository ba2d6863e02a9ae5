// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The annotated mesh of a scan, as ScanNet has it: the vertices are the index space of every evaluation in 3D.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"
#include "panoptic/labels.h"

namespace panoptic {

struct ScanTruth {
  std::string scene;             // "scene0001_00"
  std::vector<Vec3f> positions;  // metres, +z up
  std::vector<Rgb> colors;       // one per position
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<ClassId> class_id;        // NYU40 number per vertex; kUnknown = not annotated
  std::vector<std::uint16_t> instance;  // per vertex, from 1 and unique in the scan; 0 = none. Stuff surfaces may have one too
  std::map<std::uint16_t, std::string> names;  // raw label of an instance, as the aggregation file has it
};

}  // namespace panoptic
