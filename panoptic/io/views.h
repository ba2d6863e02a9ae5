// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Pictures of the map, so that one can look at a result without another tool.
#pragma once

#include <filesystem>
#include <string_view>

#include "panoptic/image.h"
#include "panoptic/io/viewpoints.h"
#include "panoptic/labels.h"
#include "panoptic/mesh.h"
#include "panoptic/outputs.h"

namespace panoptic {

enum class ColorMode {
  kColor,     // as the colour camera saw it
  kClasses,   // the colour of the class, and a legend
  kPanoptic,  // a colour per object (color_of), and the names of the objects
};

std::string_view name_of(ColorMode mode);  // "color", "classes", "panoptic"

// Draws the mesh with a lamp at the camera and light from above. Surfaces are seen from their front only: walls between the
// camera and the room are not there. The same picture on any number of threads. An empty mesh gives the background.
Image<Rgb> render(const Mesh& mesh, const View& view, ColorMode mode, const LabelSet& labels);

// Removes the files of write_views, and the folder if nothing else is in it. It is no error if there are none. Throws Error if
// they cannot be removed.
void remove_views(const std::filesystem::path& folder);

}  // namespace panoptic
