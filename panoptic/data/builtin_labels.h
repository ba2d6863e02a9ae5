// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The label sets of configs/labels, compiled in so that the program needs no files of its own at run time.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace panoptic {

std::optional<std::string_view> builtin_label_set(std::string_view name);
std::string builtin_label_set_names();  // "indoor, scannet20"

}  // namespace panoptic
