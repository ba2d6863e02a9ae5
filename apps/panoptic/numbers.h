// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Numbers of the command line.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "panoptic/geometry.h"

namespace panoptic {

// "1,2.5,-3": so many finite numbers with this sign between them. Throws UsageError.
std::vector<double> numbers_from(const std::string& text, std::size_t count, const char* flag, char between = ',');

// "x,y,z". Throws UsageError.
Vec3d point_from(const std::string& text, const char* flag);

}  // namespace panoptic
