// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/image_rows.h"

#include <fmt/format.h>

#include <memory>

#include "panoptic/mapfile/map_rows.h"

namespace panoptic {
namespace {

constexpr const char* kUseAnother = "the file is damaged: use another copy";

std::int64_t sum_of(std::int64_t number, std::int64_t frame, std::span<const std::uint8_t> images) {
  return row_checksum({number, frame}, images);
}

// A connection for each: one that stays open would keep the writer from making one file of it again.
LoggedImages::Read images_in(const std::filesystem::path& path, std::size_t number, std::int64_t frame) {
  return [path, number = static_cast<std::int64_t>(number), frame] {
    const Database database(path, DatabaseAccess::kRead);
    Statement row(database, "SELECT images, checksum FROM frame_images WHERE number = ?");
    if (!row.bind(number).step()) database.refuse(fmt::format("it has no images of frame {}; {}", frame, kUseAnother));
    const auto images = row.bytes(0);
    if (sum_of(number, frame, images) != row.integer(1)) {
      database.refuse(fmt::format("the images of frame {} of its log: their checksum is wrong; {}", frame, kUseAnother));
    }
    return Bytes(images.begin(), images.end());
  };
}

}  // namespace

void put_images(const Database& database, const std::vector<LogRow>& rows) {
  Statement put(database, "INSERT OR REPLACE INTO frame_images(number, checksum, images) VALUES(?, ?, ?)");
  for (const LogRow& row : rows) {
    if (!row.is_new || !row.entry.images) continue;
    const auto number = static_cast<std::int64_t>(row.number);
    const std::shared_ptr<const Bytes> images = row.entry.images->packed();
    put.bind(number).bind(sum_of(number, row.entry.frame, *images)).bind(std::span<const std::uint8_t>(*images)).run();
  }
}

void let_go_of_images(const std::vector<LogRow>& rows, const std::filesystem::path& path) {
  for (const LogRow& row : rows) {
    if (row.is_new && row.entry.images) row.entry.images->let_go(images_in(path, row.number, row.entry.frame));
  }
}

void find_images(Database& database, std::vector<FrameLog::Entry>& entries) {
  Statement row(database, "SELECT number FROM frame_images");
  while (row.step()) {
    const std::int64_t number = row.integer(0);
    if (number < 0) database.refuse(fmt::format("it has images of entry {} of its log; {}", number, kUseAnother));
    const auto n = static_cast<std::size_t>(number);
    if (n >= entries.size()) continue;
    entries[n].images = std::make_shared<LoggedImages>(images_in(database.path(), n, entries[n].frame));
  }
}

}  // namespace panoptic
