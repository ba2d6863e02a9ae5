// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One picture that shows why the map takes an object for what it is.
#pragma once

#include <filesystem>

#include "panoptic/evidence.h"
#include "panoptic/image.h"

namespace panoptic {

// 1280 x 960 pixels. Above, the object's best frames, cut out around its box; below, the object in the map, everything else in
// grey, from the front and from above; the evidence in words between. Opens the recording named in the run's report.json again
// and reads mesh.ply. Throws Error if either is not there or the recording is another one by now. A note takes the place of a
// frame that cannot be read.
Image<Rgb> draw_evidence(const std::filesystem::path& run, const Evidence& evidence);

}  // namespace panoptic
