// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The annotated mesh of a scan, as ScanNet has it: the vertices are the index space of every evaluation in 3D.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
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

// The scan in the folder; its id is taken from the mesh's name. Class = NYU40 number of the group's raw label, instance = the
// group's objectId + 1; a segment that two groups claim belongs to the later one. Raw labels are looked up in `category_map`
// (ScanNet's TSV), else in a scannetv2-labels.combined.tsv in the folder or up to two folders above, else they must be NYU40
// names; a label that is not found counts as not annotated. `warnings`, if given, hears of such labels (once for all) and of
// segments claimed twice. Throws Error naming the file for missing, malformed or contradicting files.
ScanTruth read_scan_truth(const std::filesystem::path& folder, const std::filesystem::path& category_map = {},
                          std::vector<std::string>* warnings = nullptr);

}  // namespace panoptic
