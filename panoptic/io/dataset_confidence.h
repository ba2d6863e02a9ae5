// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Confidence images, as ARKit gives them beside depth: a level for each reading, 0 low, 1 medium, 2 high. Apple publishes no
// figures for the levels: a medium reading counts half as much as a high one, and a low one is none.
#pragma once

#include <filesystem>
#include <string>

#include "panoptic/image.h"
#include "panoptic/outcome.h"

namespace panoptic {

// Takes away the readings of level 0, and gives the weights of the others. Refuses if there is no such file, or no image of one
// channel, or it has another size.
Outcome weigh_by_confidence(const std::filesystem::path& root, const std::string& file, Image<float>& depth,
                            Image<float>& weight);

}  // namespace panoptic
