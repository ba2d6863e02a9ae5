// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The labelled mesh as a binary glTF 2.0 scene, one node per object: docs/outputs.md has the layout. The one seam to tinygltf.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "panoptic/data/labels.h"
#include "panoptic/data/mesh.h"

namespace panoptic {

// One node per panoptic id that has triangles: `chair_31` for things (class name with underscores, panoptic id), `wall` for
// stuff, `unknown` for the rest. Its material has the colour that color_of gives; the photo's colours are in the attribute
// _COLOR. Its extras name the class and the id. A triangle belongs to the id of its speaker (data/object_shapes.h); triangles
// without area in their indices and those with a position that is not finite are left out.
// Vertices keep their world coordinates. With `up`, a root node `map` turns that direction to +Y, which viewers show upwards.
// Throws Error if the scene is larger than the 4 GB of the format.
std::string glb_bytes(const Mesh& mesh, const LabelSet& labels, const std::optional<Vec3d>& up = {});

// The same as a file, written whole or not at all. Throws Error also if it cannot be written.
void write_glb(const std::filesystem::path& path, const Mesh& mesh, const LabelSet& labels, const std::optional<Vec3d>& up = {});

}  // namespace panoptic
