// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The annotated mesh of a ScanNet scan: <id>_vh_clean_2.ply (the mesh), <id>_vh_clean_2.0.010000.segs.json (which segment a
// vertex belongs to) and <id>.aggregation.json (which segments make up a thing, and what it is called).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/scan_truth.h"

namespace panoptic {

// Writes the three files into the folder, which is created; each whole or not at all. Every pair of class and instance becomes
// one segment and one group. The group's label is the instance's raw label where that names the vertices' class, else the name
// of the class. Stuff without an instance gets one above all others; unannotated vertices lose theirs. Throws Error if a vector
// has not one entry per position, an instance is of two classes, a class is not one of NYU40's, or a file cannot be written.
void write_scan_truth(const std::filesystem::path& folder, const ScanTruth& truth);

}  // namespace panoptic
