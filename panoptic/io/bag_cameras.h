// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The cameras of a bag, from its CameraInfo messages and transforms.
#pragma once

#include <string>
#include <vector>

#include "panoptic/io/bag_roles.h"
#include "panoptic/io/bag_transforms.h"
#include "panoptic/io/calibration.h"

namespace panoptic {

// Lines for the user go to `assumed`. `is_given`: a calibration file may say what the bag lacks. Throws Error where it does not:
// without CameraInfo, for one that changes, for images that are cut or binned, for cameras that no fixed transform connects.
Calibration calibration_of(const Bag& bag, const std::vector<RoledTopic>& roles, const BagRoles& chosen,
                           const TransformTree& tree, bool is_given, std::vector<std::string>& assumed);

}  // namespace panoptic
