// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Wavefront OBJ and MTL texts: the one seam to tinyobjloader.
#pragma once

#include <string>
#include <vector>

#include "panoptic/sim/scene.h"

namespace panoptic {

struct ObjMaterial {
  Rgb color{200, 200, 200};
  float opacity = 1;
  std::string texture;  // as map_Kd names it; empty = none

  bool operator==(const ObjMaterial&) const = default;
};

struct ObjModel {
  SceneModel model;                    // in the axes and units of the file; polygons are split into triangles
  std::vector<ObjMaterial> materials;  // what SceneModel::material_of refers to; equal ones are one
};

// The file that the first mtllib line names; empty if there is none.
std::string material_library(const std::string& obj_text);

// `name` is for the error text. Throws Error if the text is no OBJ, refers to vertices that it lacks, holds numbers that are not
// finite, or is too large (more than 400 000 triangles).
ObjModel parse_obj(const std::string& obj_text, const std::string& mtl_text, const std::string& name);

}  // namespace panoptic
