// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map file in place of the folder of a run: as what eval scores and as what view shows.
#pragma once

#include <string>
#include <vector>

#include "apps/viewer/result_folder.h"
#include "panoptic/eval/vertex_labels.h"

namespace panoptic {

// A file, as opposed to a folder. What is not there counts as a folder.
bool is_map_file(const std::string& path);

// Both throw Error if the file is no sound map. `warnings` hear of a map that is not complete and of classes that NYU40 does not
// have.
LabelledMap labelled_map(const std::string& path, std::vector<std::string>& warnings);
OpenedResult open_map_result(const std::string& path);

}  // namespace panoptic
