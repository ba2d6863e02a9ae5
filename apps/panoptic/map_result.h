// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map file in place of the folder of a run, for eval to score and view to show.
#pragma once

#include <string>
#include <vector>

#include "panoptic/evaluation.h"

namespace panoptic {

// True for a file, as opposed to a folder. An absent one counts as a folder.
bool is_map_file(const std::string& path);

// Throws Error if the file is no sound map. `warnings` hear of a map that is not complete and of classes that NYU40 does not
// have.
LabelledMap map_to_score(const std::string& path, std::vector<std::string>& warnings);

}  // namespace panoptic
