// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The labelled mesh as files that other programs open: docs/outputs.md has the layouts.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/mesh.h"

namespace panoptic {

// Writes a mesh, binary little endian; vertices float x y z nx ny nz, uint8 red green blue, uint16 class_id, int32 panoptic_id
// (its bits); faces `list uchar int vertex_indices`. Metres, world axes. Written whole or not at all. Throws Error if the file
// cannot be written or the mesh has more than 2^31 - 1 vertices (faces hold signed 32-bit indices).
void write_ply(const std::filesystem::path& path, const Mesh& mesh);

// Reads what write_ply writes and what it wrote in earlier versions, with a ushort panoptic_id; nothing else. Throws Error
// naming the file and the place if it has another layout, is cut off or longer than its header says, holds a position or normal
// that is not finite, or a face names a vertex that does not exist.
Mesh read_ply(const std::filesystem::path& path);

// One node per panoptic id that has triangles: `chair_31` for things (class name with underscores, panoptic id), `wall` for
// stuff, `unknown` for the rest. Its material has the colour that color_of gives; the photo's colours are in the attribute
// _COLOR. Its extras name the class and the id. A triangle belongs to the id of most of its corners; triangles
// without area in their indices and those with a position that is not finite are left out.
// Vertices keep their world coordinates. With `up`, a root node `map` turns that direction to +Y, which viewers show upwards.
// Throws Error if the scene is larger than the 4 GB of the format.
std::string glb_bytes(const Mesh& mesh, const LabelSet& labels, const std::optional<Vec3d>& up = {});

// The same as a file, written whole or not at all. Throws Error also if it cannot be written.
void write_glb(const std::filesystem::path& path, const Mesh& mesh, const LabelSet& labels, const std::optional<Vec3d>& up = {});

// Writes `<view>_<mode>.png` into the folder, which it makes: front, side and top, each as colours, classes and
// objects. `up`: upwards in the world. Throws Error if they cannot be written.
void write_views(const std::filesystem::path& folder, const Mesh& mesh, const Vec3d& up, const LabelSet& labels);

}  // namespace panoptic
