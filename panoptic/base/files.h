// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The seam to the file system. Reading checks sizes before memory is taken; writing is all or nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace panoptic {

// The whole file. Throws Error if it is absent, unreadable, not a regular file, or larger than max_bytes.
std::string read_file(const std::filesystem::path& path, std::uintmax_t max_bytes = std::uintmax_t{1} << 30);

// Writes beside the target under a temporary name, syncs and renames, so that the final name never shows a partial
// file and an older file survives a failure. Throws Error (disk full, no permission ...) and removes the temporary file.
void write_file(const std::filesystem::path& path, std::string_view bytes);
void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

// Creates the folder and its parents and proves that files can be written there. Throws Error otherwise.
void require_writable_folder(const std::filesystem::path& folder);

}  // namespace panoptic
