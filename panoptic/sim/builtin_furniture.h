// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// configs/sim/furniture.toml, compiled in.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace panoptic {

std::optional<std::string_view> builtin_furniture(std::string_view name);
std::string builtin_furniture_names();  // "furniture"

}  // namespace panoptic
