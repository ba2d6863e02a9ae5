// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The seam to nlohmann-json: files in and out with the project's errors and limits.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace panoptic {

using Json = nlohmann::ordered_json;

// Throws Error with the file's name and the place if the text is not JSON or the file is larger than max_bytes.
Json read_json_file(const std::filesystem::path& path, std::uintmax_t max_bytes = 64U << 20);

// Written as write_file writes: whole or not at all.
void write_json_file(const std::filesystem::path& path, const Json& json);

}  // namespace panoptic
