// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads the files of a run (docs/outputs.md), as far as an evaluation needs them.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/eval/vertex_labels.h"

namespace panoptic {

// object_confidence of every object in an objects.json (or in the JSON of objects_json in mapping/outputs.h). Throws Error,
// beginning with `source`, if it is not as documented.
std::map<PanopticId, double> object_confidences(const Json& objects, const std::string& source);

// mesh.ply, objects.json and report.json of a run's folder. Throws Error naming the file; `warnings`, if given, hears of an
// incomplete run and of classes that NYU40 does not have.
LabelledMap read_run_folder(const std::filesystem::path& folder, std::vector<std::string>* warnings = nullptr);

}  // namespace panoptic
