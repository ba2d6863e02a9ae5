// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map of two blocks with two objects, saved with everything that a map file can hold.
#pragma once

#include <filesystem>

#include "panoptic/frame.h"
#include "panoptic/map_file.h"

namespace panoptic::fuzz {

LabelSet small_labels();

// A piece of level ground in two blocks, with its objects.
PanopticMap small_map();

// A frame of a few pixels that can be used.
Frame small_frame();

void save_small_map(const std::filesystem::path& path);

}  // namespace panoptic::fuzz
