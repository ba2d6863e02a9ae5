// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The log of frames in a map file: a row per used frame. docs/map_format.md has the layout.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "panoptic/base/sqlite.h"
#include "panoptic/map/frame_log.h"

namespace panoptic {

// Maps of older formats lack what a map made anew has.
inline constexpr std::int64_t kOldestRebuiltFormat = 5;

// An entry of the log, and which one it is.
struct LogRow {
  std::size_t number = 0;
  FrameLog::Entry entry;
  bool is_new = true;  // its images were never written
};

// The entries that changed after FrameLog::clock had that value; new are those that came after `images`.
std::vector<LogRow> log_since(const FrameLog& log, std::uint64_t clock, std::uint64_t images);
inline std::vector<LogRow> log_since(const FrameLog& log, std::uint64_t clock) { return log_since(log, clock, clock); }

void put_log(const Database& database, const std::vector<LogRow>& rows);

// The whole log of a map file, empty if its format has none. Throws Error: no sound map, or rows that are damaged or absent.
std::vector<FrameLog::Entry> load_log(const std::filesystem::path& path);

// How many frames the log of a map file tells of, of how many of these it has the images, and about how many bytes of the file
// that takes.
struct LogSize {
  std::size_t frames = 0;
  std::size_t copies = 0;
  std::uint64_t bytes = 0;
};
LogSize size_of_log(const std::filesystem::path& path);

}  // namespace panoptic
