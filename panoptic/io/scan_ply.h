// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The mesh of a scan as ScanNet stores it (<id>_vh_clean_2.ply): positions, colours, triangles.
#pragma once

#include <filesystem>

#include "panoptic/scan_truth.h"

namespace panoptic {

// Writes the mesh, binary little endian; vertices float x y z, uchar red green blue alpha; faces list uchar int vertex_indices.
void write_scan_ply(const std::filesystem::path& path, const ScanTruth& scan);

// Fills positions, colors (black if the file has none) and triangles. Takes any binary little-endian PLY with a vertex element
// that has x, y, z, whatever its other properties are, and triangles in a list of whole numbers. Throws Error naming the file
// and the place if it has another layout, is cut off or longer than its header says, holds a position that is not finite, or a
// face that is no triangle of its vertices.
void read_scan_ply(const std::filesystem::path& path, ScanTruth& scan);

}  // namespace panoptic
