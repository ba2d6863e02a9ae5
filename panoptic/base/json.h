// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The seam to nlohmann-json: files in and out with the project's errors and limits.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

namespace panoptic {

using Json = nlohmann::ordered_json;

// Members are kept in their order and found one by one, so an object of a million would take hours to read. No file of ours has
// more than one for each of 999 classes.
inline constexpr std::size_t kMostJsonMembers = 4096;
// A value of two bytes takes 16 in memory, and as much again when it is given back, where running out of memory cannot be
// reported.
inline constexpr std::size_t kMostJsonValues = 10'000'000;

// Parses the text; nothing if it is not JSON, or it has more values, or an object in it more members, than that.
std::optional<Json> json_in(std::string_view text);

// Reads a file. Throws Error with the file's name and the place if the text is not JSON, it has more values, or an object in it
// more members, than that, or the file is larger than max_bytes.
Json read_json_file(const std::filesystem::path& path, std::uintmax_t max_bytes = 64U << 20);

// Writes a file whole or not at all, as write_file does.
void write_json_file(const std::filesystem::path& path, const Json& json);

}  // namespace panoptic
