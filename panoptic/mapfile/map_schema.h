// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The tables of a map file (docs/map_format.md): making them, and telling a map from any other file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/base/sqlite.h"
#include "panoptic/map_file.h"

namespace panoptic {

inline constexpr std::int64_t kMapApplicationId = 0x50464D50;  // "PFMP" at byte 68 of the file

// Both prepare an empty database: set_page_size before the transaction, the second within it.
void set_page_size(Database& database);
void create_map_tables(Database& database);

// The format of the file. Throws Error unless it is a sound map of a known one, with exactly the tables of that format.
std::int64_t require_map(Database& database);

// The data that files of an older format lack, each with what is taken instead; empty for kMapFormat.
std::vector<std::string> lacks_of(std::int64_t format);

}  // namespace panoptic
