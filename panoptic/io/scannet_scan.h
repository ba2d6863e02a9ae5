// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The annotated mesh of a ScanNet scan: <id>_vh_clean_2.ply (the mesh), <id>_vh_clean_2.0.010000.segs.json (which segment a
// vertex belongs to) and <id>.aggregation.json (which segments make up a thing, and what it is called).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/data/scan_truth.h"

namespace panoptic {

// Writes the three files into the folder, which is created; each whole or not at all. Every pair of class and instance becomes
// one segment and one group. The group's label is the instance's raw label where that names the vertices' class, else the name
// of the class. Stuff without an instance gets one above all others; unannotated vertices lose theirs. Throws Error if a vector
// has not one entry per position, an instance is of two classes, a class is not one of NYU40's, or a file cannot be written.
void write_scan_truth(const std::filesystem::path& folder, const ScanTruth& truth);

// The scan in the folder; its id is taken from the mesh's name. Class = NYU40 number of the group's raw label, instance = the
// group's objectId + 1; a segment that two groups claim belongs to the later one. Raw labels are looked up in `category_map`
// (ScanNet's TSV), else in a scannetv2-labels.combined.tsv in the folder or up to two folders above, else they must be NYU40
// names; a label that is not found counts as not annotated. `warnings`, if given, hears of such labels (once for all) and of
// segments claimed twice. Throws Error naming the file for missing, malformed or contradicting files.
ScanTruth read_scan_truth(const std::filesystem::path& folder, const std::filesystem::path& category_map = {},
                          std::vector<std::string>* warnings = nullptr);

}  // namespace panoptic
