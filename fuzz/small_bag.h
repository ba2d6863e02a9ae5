// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A bag of two frames in each container: what a fuzzer starts from.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace panoptic::fuzz {

std::vector<std::pair<std::string, std::string>> small_bags();  // file names and bytes

}  // namespace panoptic::fuzz
