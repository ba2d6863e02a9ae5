// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The labelled mesh as a PLY file that MeshLab and Open3D open: docs/outputs.md has the layout.
#pragma once

#include <filesystem>

#include "panoptic/data/mesh.h"

namespace panoptic {

// Binary little endian; vertices float x y z nx ny nz, uchar red green blue, ushort class_id panoptic_id; faces
// `list uchar int vertex_indices`. Metres, world axes. Written whole or not at all.
// Throws Error if the file cannot be written or the mesh has more than 2^31 - 1 vertices (faces hold signed 32-bit indices).
void write_ply(const std::filesystem::path& path, const Mesh& mesh);

// Reads what write_ply writes, and nothing else. Throws Error naming the file and the place if it has another layout, is cut
// off or longer than its header says, holds a position or normal that is not finite, or a face names a vertex that does not
// exist.
Mesh read_ply(const std::filesystem::path& path);

}  // namespace panoptic
