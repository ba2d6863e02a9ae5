// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The images of logged frames in a map file: a row per frame of the log, written once. docs/map_format.md has the layout.
#pragma once

#include <filesystem>
#include <vector>

#include "panoptic/base/sqlite.h"
#include "panoptic/mapfile/log_rows.h"

namespace panoptic {

// Writes the images of new entries, one after the other: those that lie in another file take no memory together.
void put_images(const Database& database, const std::vector<LogRow>& rows);

// The entries' images can be read from that file, where they were written as such rows, and are not kept in memory any more.
void let_go_of_images(const std::vector<LogRow>& rows, const std::filesystem::path& path);

// Lets the entries of a whole log know of the images that the file has. Images of later entries are what a run that was killed
// had written ahead: they are passed over.
void find_images(Database& database, std::vector<FrameLog::Entry>& entries);

}  // namespace panoptic
