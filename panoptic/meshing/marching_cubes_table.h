// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The triangulation of a cell for each of the 256 patterns of inside and outside corners (Lorensen and Cline 1987).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace panoptic {

// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2 & 1). Edge e = 4 * axis + k runs along `axis` (0 x, 1 y, 2 z) from the
// corner `kCellEdges[e].corner`.
struct CellEdge {
  std::uint8_t corner;
  std::uint8_t axis;
};
extern const std::array<CellEdge, 12> kCellEdges;

using CellTriangle = std::array<std::uint8_t, 3>;  // edges, counter-clockwise seen from outside (where the distance is positive)

// Per pattern: bit c set = corner c is inside (negative distance). Derived, not typed in: on every face of the cell the inside
// corners are cut off one connected run at a time, a rule that both cells at a face see alike, so that surfaces have no cracks.
const std::array<std::vector<CellTriangle>, 256>& cell_triangles();

}  // namespace panoptic
