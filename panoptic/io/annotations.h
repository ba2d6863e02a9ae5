// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// What is written into the pictures of the map.
#pragma once

#include "panoptic/data/labels.h"
#include "panoptic/data/mesh.h"
#include "panoptic/io/rasterizer.h"

namespace panoptic {

// color_of, but unknown is a light grey that leaves the shape of the surface readable.
Rgb picture_color(PanopticId id, const LabelSet& labels);

// Below a picture whose labels are class numbers: the classes in it, the largest first.
void draw_class_legend(Picture& picture, const LabelSet& labels);

// Into a picture whose labels are panoptic ids: `chair 31` on every object that is large enough, and the stuff below.
void draw_object_names(Picture& picture, const Mesh& mesh, const LabelSet& labels);

}  // namespace panoptic
