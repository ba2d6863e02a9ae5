// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers of a .glb file: a mesh told apart by object. They are written one by one, because together they are another copy of
// the mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/base/piece_writer.h"
#include "panoptic/labels.h"
#include "panoptic/mesh.h"

namespace panoptic {

// One object's triangles, and the vertices that it will have of its own.
struct GlbPart {
  PanopticId id = PanopticId::kUnknown;
  std::vector<std::uint32_t> vertices;   // of the mesh, ascending
  std::vector<std::uint32_t> triangles;  // of the mesh
};

// By id, ascending. A triangle belongs to the id of most of its corners; those without area in their indices or with a position
// that is not finite are left out.
std::vector<GlbPart> split_by_id(const Mesh& mesh);

// The name of an id's node: `chair_31`, `wall`, `unknown`. Two classes whose names differ by a space alone may give one name.
std::string glb_node_name(PanopticId id, ClassId class_id, const LabelSet& labels);

// Indices of 16 bits suffice for fewer vertices; 65535 would restart a primitive. Never 8 bits: WebGPU and Direct3D have no such
// indices, and viewers convert them.
bool has_short_indices(const GlbPart& part);

// Bytes up to the next multiple of 4.
constexpr std::size_t padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

// Puts, part after part, all positions (3 floats), then unit normals (3 floats; where the mesh has none, those of the triangles
// around), then colours (4 bytes), then indices, each part's at a multiple of 4 bytes.
void put_buffer(const Mesh& mesh, const std::vector<GlbPart>& parts, PieceWriter& out);

}  // namespace panoptic
