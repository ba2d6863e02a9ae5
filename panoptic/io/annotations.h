// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Text in the pictures of the map.
#pragma once

#include "panoptic/io/rasterizer.h"
#include "panoptic/labels.h"
#include "panoptic/mesh.h"

namespace panoptic {

// color_of, but unknown is a light grey that leaves the shape of the surface readable.
Rgb picture_color(PanopticId id, const LabelSet& labels);

// Writes below a picture whose labels are class numbers which classes are in it, the largest first.
void draw_class_legend(Picture& picture, const LabelSet& labels);

// Writes into a picture whose labels are panoptic ids: `chair 31` on every object that is large enough, and the stuff below.
void draw_object_names(Picture& picture, const Mesh& mesh, const LabelSet& labels);

}  // namespace panoptic
