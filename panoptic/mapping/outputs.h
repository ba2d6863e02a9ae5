// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The JSON among the files that a run leaves on disk (run_outputs.h).
#pragma once

#include "panoptic/base/json.h"
#include "panoptic/mapper.h"
#include "panoptic/run_outputs.h"

namespace panoptic {

// The two reports as JSON; `mesh` is the mapper's.
Json objects_json(const Mapper& mapper, const Mesh& mesh);
Json report_json(const Mapper& mapper, const Options& options, const RunSummary& run, const Mesh& mesh);

}  // namespace panoptic
