// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/log_rows.h"

#include <fmt/format.h>

#include <bit>
#include <utility>

#include "panoptic/base/bytes.h"
#include "panoptic/base/compression.h"
#include "panoptic/mapfile/image_rows.h"
#include "panoptic/mapfile/map_rows.h"
#include "panoptic/mapfile/map_schema.h"

namespace panoptic {
namespace {

constexpr const char* kUseAnother = "the file is damaged: use another copy";
constexpr int kPoseNumbers = 12;
constexpr std::int64_t kMostLabelBytes = 1 << 26;

// Rotation and translation row by row, bit for bit: a quaternion would not give the same pose back.
Bytes pose_bytes(const Pose& pose) {
  Bytes bytes;
  for (int n = 0; n < kPoseNumbers; ++n) append_number(bytes, std::bit_cast<std::uint64_t>(pose.matrix()(n / 4, n % 4)));
  return bytes;
}

Pose take_pose(ByteReader& reader) {
  Pose pose = Pose::Identity();
  for (int n = 0; n < kPoseNumbers; ++n) pose.matrix()(n / 4, n % 4) = std::bit_cast<double>(reader.take<std::uint64_t>());
  return pose;
}

// Pose and labels of a row, as they are checked together.
std::int64_t sum_of(const LogRow& row, std::int64_t size, std::span<const std::uint8_t> pose,
                    std::span<const std::uint8_t> labels) {
  Bytes both(pose.begin(), pose.end());
  both.insert(both.end(), labels.begin(), labels.end());
  return row_checksum(
      {static_cast<std::int64_t>(row.number), row.entry.frame, std::bit_cast<std::int64_t>(row.entry.time_s), size}, both);
}

}  // namespace

std::vector<LogRow> log_since(const FrameLog& log, std::uint64_t clock, std::uint64_t images) {
  std::vector<LogRow> rows;
  for (std::size_t n = 0; n < log.size(); ++n) {
    const FrameLog::Entry& entry = log.entries()[n];
    if (entry.changed_at > clock) rows.push_back({n, entry, entry.added_at > images});
  }
  return rows;
}

void put_log(const Database& database, const std::vector<LogRow>& rows) {
  Statement put(
      database,
      "INSERT OR REPLACE INTO frame_log(number, frame, time_s, pose, size, labels, checksum) VALUES(?, ?, ?, ?, ?, ?, ?)");
  Compressor compressor;
  for (const LogRow& row : rows) {
    const Bytes pose = pose_bytes(row.entry.world_from_camera);
    const auto size = row.entry.labels ? static_cast<std::int64_t>(row.entry.labels->size()) : 0;
    const Bytes labels = size > 0 ? compressor.compress(*row.entry.labels) : Bytes();
    put.bind(static_cast<std::int64_t>(row.number)).bind(row.entry.frame).bind(row.entry.time_s);
    put.bind(std::span<const std::uint8_t>(pose)).bind(size).bind(std::span<const std::uint8_t>(labels));
    put.bind(sum_of(row, size, pose, labels)).run();
  }
}

std::vector<FrameLog::Entry> load_log(const std::filesystem::path& path) {
  Database database(path, DatabaseAccess::kRead);
  std::vector<FrameLog::Entry> entries;
  const std::int64_t format = require_map(database);
  if (format < 4) return entries;
  Statement row(database, "SELECT number, frame, time_s, pose, size, labels, checksum FROM frame_log ORDER BY number");
  Decompressor decompressor;
  while (row.step()) {
    const auto number = static_cast<std::int64_t>(entries.size());
    LogRow read{static_cast<std::size_t>(row.integer(0, number, number)), {.frame = row.integer(1), .time_s = row.real(2)}};
    const std::int64_t size = row.integer(4, 0, kMostLabelBytes);
    const auto pose = row.bytes(3);
    const auto compressed = row.bytes(5);
    if (pose.size() != kPoseNumbers * sizeof(double) || sum_of(read, size, pose, compressed) != row.integer(6)) {
      database.refuse(fmt::format("frame {} of its log: its checksum is wrong; {}", read.entry.frame, kUseAnother));
    }
    ByteReader reader(pose);
    read.entry.world_from_camera = take_pose(reader);
    // zstd packs at most 2^15 equal bytes into one, roughly.
    if (static_cast<std::uint64_t>(size) > (std::uint64_t{compressed.size()} << 16)) {
      database.refuse(fmt::format("frame {} of its log claims {} bytes; {}", read.entry.frame, size, kUseAnother));
    }
    Bytes labels(static_cast<std::size_t>(size));
    if (size > 0 && decompressor.decompress(compressed, labels) != labels.size()) {
      database.refuse(fmt::format("frame {} of its log cannot be decompressed; {}", read.entry.frame, kUseAnother));
    }
    if (size > 0) read.entry.labels = std::make_shared<const FrameLog::Bytes>(std::move(labels));
    entries.push_back(std::move(read.entry));
  }
  if (format > 5) find_images(database, entries);
  return entries;
}

LogSize size_of_log(const std::filesystem::path& path) {
  constexpr std::uint64_t kRowBytes = 150;  // with the pose
  Database database(path, DatabaseAccess::kRead);
  const std::int64_t format = require_map(database);
  if (format < 4) return {};
  const auto frames = static_cast<std::uint64_t>(database.integer("SELECT count(*) FROM frame_log"));
  const auto labels = static_cast<std::uint64_t>(database.integer("SELECT ifnull(sum(length(labels)), 0) FROM frame_log"));
  LogSize size{static_cast<std::size_t>(frames), 0, labels + frames * kRowBytes};
  if (format < 6) return size;
  size.copies = static_cast<std::size_t>(database.integer("SELECT count(*) FROM frame_images JOIN frame_log USING (number)"));
  size.bytes += static_cast<std::uint64_t>(database.integer("SELECT ifnull(sum(length(images)), 0) FROM frame_images"));
  return size;
}

}  // namespace panoptic
