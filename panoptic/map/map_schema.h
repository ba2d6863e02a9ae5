// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The tables of a map file (docs/map_format.md): making them, and telling a map from any other file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/map/sqlite.h"

namespace panoptic {

inline constexpr std::int64_t kMapApplicationId = 0x50464D50;  // "PFMP" at byte 68 of the file
inline constexpr std::int64_t kMapFormat = 2;                  // user_version; rises when older programs could not read the file

// Both into an empty database, the first one before the transaction that the second one is in.
void set_page_size(Database& database);
void create_map_tables(Database& database);

// The format of the file. Throws Error unless it is a sound map of a known one, with exactly the tables of that format.
std::int64_t require_map(Database& database);

// What files of an older format do not tell, and what is taken instead; empty for kMapFormat. One entry a thing.
std::vector<std::string> lacks_of(std::int64_t format);

}  // namespace panoptic
