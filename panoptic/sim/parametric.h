// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Simple furniture made of boxes, sheets and bodies of revolution, with procedural textures: for what the furniture package
// lacks.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "panoptic/sim/model_asset.h"

namespace panoptic {

struct ParametricShape {
  std::string shape;             // one of parametric_shapes()
  Vec3f size_m = Vec3f::Ones();  // width, depth, height, handles and taps included
  Rgb color{200, 200, 200};      // of the main material
  int variant = 0;               // another number, another pattern, painting or division
};

std::vector<std::string> parametric_shapes();

// Throws Error listing the shapes if there is none of that name.
void require_parametric_shape(std::string_view shape);

// Makes the model in the frame that SceneModel states. The same shape gives the same bytes. Throws Error as above.
ModelAsset make_parametric(const ParametricShape& shape);

}  // namespace panoptic
