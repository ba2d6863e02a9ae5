// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The presets of configs/presets, compiled in so that the program needs no files of its own at run time.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace panoptic {

std::optional<std::string_view> builtin_preset(std::string_view name);
std::string builtin_preset_names();  // "paper"

}  // namespace panoptic
