// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Pictures of the map, so that one can look at a result without another tool.
#pragma once

#include <filesystem>
#include <string_view>

#include "panoptic/base/image.h"
#include "panoptic/data/labels.h"
#include "panoptic/data/mesh.h"
#include "panoptic/io/viewpoints.h"

namespace panoptic {

enum class ColorMode {
  kColor,     // as the colour camera saw it
  kClasses,   // the colour of the class, and a legend
  kPanoptic,  // a colour per object (color_of), and the names of the objects
};

std::string_view name_of(ColorMode mode);  // "color", "classes", "panoptic"

// The mesh with a lamp at the camera and light from above. Surfaces are seen from their front only: walls between the camera
// and the room are not there. The same picture on any number of threads. An empty mesh gives the background.
Image<Rgb> render(const Mesh& mesh, const View& view, ColorMode mode, const LabelSet& labels);

// The files of write_views, and the folder if nothing else is in it. Nothing there is no error; throws Error if they stay.
void remove_views(const std::filesystem::path& folder);

// `<view>_<mode>.png` in the folder, which it makes: default_views times every mode. Throws Error if they cannot be written.
void write_views(const std::filesystem::path& folder, const Mesh& mesh, const Vec3d& up, const LabelSet& labels);

}  // namespace panoptic
