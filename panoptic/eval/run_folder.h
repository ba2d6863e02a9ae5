// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/eval/vertex_labels.h"

namespace panoptic {

// The map in a run's folder, to be scored. Throws Error as io/run_files.h does; `warnings`, if given, hears of an incomplete run
// and of classes that NYU40 does not have.
LabelledMap read_run_folder(const std::filesystem::path& folder, std::vector<std::string>* warnings = nullptr);

}  // namespace panoptic
