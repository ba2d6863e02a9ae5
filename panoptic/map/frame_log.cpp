// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/frame_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "panoptic/base/bytes.h"
#include "panoptic/base/value_runs.h"
#include "panoptic/error.h"
#include "panoptic/map/frame_images.h"

namespace panoptic {
namespace {

constexpr std::size_t kEntryBytes = sizeof(FrameLog::Entry) + 64;  // with its place in the index
constexpr std::size_t kPackedAtOnce = 4;                           // frames whose copies are being packed

std::size_t bytes_of(const FrameLog::Entry& entry) { return kEntryBytes + (entry.labels ? entry.labels->size() : 0); }

// Seven bits a byte, lowest first; the last byte has no high bit.
void append_short(FrameLog::Bytes& bytes, std::uint32_t number) {
  for (; number >= 0x80; number >>= 7) bytes.push_back(static_cast<std::uint8_t>(number | 0x80));
  bytes.push_back(static_cast<std::uint8_t>(number));
}

std::uint32_t take_short(ByteReader& reader) {
  std::uint32_t number = 0;
  for (int shift = 0; shift < 32; shift += 7) {
    const auto byte = reader.take<std::uint8_t>();
    number |= static_cast<std::uint32_t>(byte & 0x7F) << shift;
    if (byte < 0x80) break;
  }
  return number;
}

void append_segment(FrameLog::Bytes& bytes, const Segment& segment, PanopticId id) {
  append_number(bytes, number(id));
  append_number(bytes, number(segment.class_id));
  append_number(bytes, segment.score);
  append_number(bytes, static_cast<std::uint8_t>(segment.is_whole_class));
  append_short(bytes, static_cast<std::uint32_t>(segment.class_probabilities.size()));
  for (const ClassProbability& p : segment.class_probabilities) {
    append_number(bytes, number(p.class_id));
    append_number(bytes, p.probability);
  }
}

std::optional<Segment> take_segment(ByteReader& reader) {
  constexpr std::size_t kBytes = sizeof(std::uint16_t) + sizeof(float);  // of a probability
  Segment segment;
  segment.class_id = static_cast<ClassId>(reader.take<std::uint16_t>());
  segment.score = reader.take<float>();
  segment.is_whole_class = reader.take<std::uint8_t>() != 0;
  const std::uint32_t count = take_short(reader);
  if (count > reader.left() / kBytes) return std::nullopt;
  for (std::uint32_t n = 0; n < count; ++n) {
    const auto class_id = static_cast<ClassId>(reader.take<std::uint16_t>());
    segment.class_probabilities.push_back({class_id, reader.take<float>()});
  }
  return segment;
}

// A row of the image: runs of equal values, each up to where it ends.
struct Run {
  std::uint16_t value = 0;
  std::int32_t end = 0;
};
using Row = std::vector<Run>;

void find_row(const Image<std::uint16_t>& image, int v, Row& row) {
  row.clear();
  const std::uint16_t* pixels = image.row(v);
  for (int begin = 0; begin < image.width();) {
    const int end = end_of_run(pixels, begin, image.width());
    row.push_back({pixels[begin], end});
    begin = end;
  }
}

bool same_values(const Row& a, const Row& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Run& x, const Run& y) { return x.value == y.value; });
}

// Outlines go on from row to row: where the values are those of the row above, only the steps of their ends are written, after a
// 0; else how many runs there are, and all of them.
void append_row(FrameLog::Bytes& bytes, const Row& row, const Row& above) {
  if (same_values(row, above)) {
    append_short(bytes, 0);
    for (std::size_t r = 0; r + 1 < row.size(); ++r)
      append_short(bytes, as_small(static_cast<std::uint32_t>(row[r].end - above[r].end)));
    return;
  }
  append_short(bytes, static_cast<std::uint32_t>(row.size()));
  std::int32_t begin = 0;
  for (const Run& run : row) {
    append_short(bytes, run.value);
    append_short(bytes, static_cast<std::uint32_t>(run.end - begin));
    begin = run.end;
  }
}

// Reads a row over the one above; false if that is no row of this width.
bool take_row(ByteReader& reader, std::int32_t width, Row& row) {
  const std::uint32_t count = take_short(reader);
  if (count == 0) {
    if (row.empty()) return false;
    for (std::size_t r = 0; r + 1 < row.size(); ++r) {
      const std::int64_t end = std::int64_t{row[r].end} + static_cast<std::int32_t>(from_small(take_short(reader)));
      if (end <= 0 || end > width) return false;
      row[r].end = static_cast<std::int32_t>(end);
    }
  } else {
    if (count > static_cast<std::uint32_t>(width)) return false;
    row.resize(count);
    std::int32_t begin = 0;
    for (Run& run : row) {
      const std::uint32_t value = take_short(reader);
      if (value > std::numeric_limits<std::uint16_t>::max()) return false;
      run.value = static_cast<std::uint16_t>(value);
      const std::uint32_t length = take_short(reader);
      if (length > static_cast<std::uint32_t>(width - begin)) return false;
      run.end = begin + static_cast<std::int32_t>(length);
      begin = run.end;
    }
  }
  std::int32_t begin = 0;
  for (const Run& run : row) {
    if (run.end <= begin || run.end > width) return false;
    begin = run.end;
  }
  return begin == width && !reader.is_short();
}

bool take_rows(ByteReader& reader, std::size_t segments, Image<std::uint16_t>& image) {
  Row row;
  for (int v = 0; v < image.height(); ++v) {
    if (!take_row(reader, image.width(), row)) return false;
    std::int32_t begin = 0;
    for (const Run& run : row) {
      if (run.value > segments) return false;
      std::fill(image.row(v) + begin, image.row(v) + run.end, run.value);
      begin = run.end;
    }
  }
  return reader.left() == 0;
}

}  // namespace

FrameLog::Bytes encode_labels(const Segmentation& segmentation, std::span<const PanopticId> ids) {
  PANOPTIC_ASSERT(ids.size() == segmentation.segments.size());
  FrameLog::Bytes bytes;
  const Image<std::uint16_t>& image = segmentation.segment_at;
  append_number(bytes, static_cast<std::uint32_t>(image.width()));
  append_number(bytes, static_cast<std::uint32_t>(image.height()));
  append_short(bytes, static_cast<std::uint32_t>(ids.size()));
  for (std::size_t s = 0; s < ids.size(); ++s) append_segment(bytes, segmentation.segments[s], ids[s]);
  Row row;
  Row above;
  for (int v = 0; v < image.height(); ++v) {
    find_row(image, v, row);
    append_row(bytes, row, above);
    std::swap(row, above);
  }
  return bytes;
}

std::optional<LoggedLabels> decode_labels(std::span<const std::uint8_t> bytes, LoggedPixels pixels) {
  ByteReader reader(bytes);
  const auto width = reader.take<std::uint32_t>();
  const auto height = reader.take<std::uint32_t>();
  const std::uint32_t segments = take_short(reader);
  if (!may_be_image(width, height) || segments > reader.left()) return std::nullopt;
  if (height > reader.left()) return std::nullopt;  // a row takes a byte at least
  LoggedLabels labels;
  for (std::uint32_t s = 0; s < segments; ++s) {
    labels.ids.push_back(static_cast<PanopticId>(reader.take<std::uint32_t>()));
    std::optional<Segment> segment = take_segment(reader);
    if (!segment) return std::nullopt;
    labels.segmentation.segments.push_back(std::move(*segment));
  }
  if (reader.is_short()) return std::nullopt;
  if (pixels == LoggedPixels::kLeftOut) return labels;
  labels.segmentation.segment_at = Image<std::uint16_t>(static_cast<int>(width), static_cast<int>(height));
  if (!take_rows(reader, segments, labels.segmentation.segment_at)) return std::nullopt;
  return labels;
}

FrameLog::FrameLog(std::vector<Entry> entries, std::size_t limit_bytes, LoggedCopies copies)
    : limit_bytes_(limit_bytes), copies_(copies), entries_(std::move(entries)), counted_(entries_.size()) {
  for (std::size_t n = 0; n < entries_.size(); ++n) {
    place_of_.emplace(entries_[n].frame, n);
    entries_[n].added_at = entries_[n].changed_at = clock_;
    bytes_ += bytes_of(entries_[n]);
  }
}

void FrameLog::add(const Frame& frame) {
  if (bytes_ >= limit_bytes_) return;
  Entry entry{frame.index, frame.time_s, frame.world_from_camera};
  if (copies_ != LoggedCopies::kNone)
    entry.images = std::make_shared<LoggedImages>(frame);  // it may fail: nothing is logged then
  entry.added_at = entry.changed_at = ++clock_;
  bytes_ += bytes_of(entry);
  place_of_[frame.index] = entries_.size();
  entries_.push_back(std::move(entry));
  if (copies_ != LoggedCopies::kNone) count_packed();
}

// Always the same number of frames later, so that the limit is reached at the same frame however fast the threads are.
void FrameLog::count_packed() {
  for (; counted_ + kPackedAtOnce < entries_.size(); ++counted_) {
    const std::size_t size = entries_[counted_].images->size();
    packed_bytes_ += size;
    if (copies_ == LoggedCopies::kInMemory) bytes_ += size;
  }
}

void FrameLog::copy_to_file() {
  if (copies_ == LoggedCopies::kInMemory) copies_ = LoggedCopies::kInFile;
}

void FrameLog::set_labels(std::int64_t frame, const Segmentation& segmentation, std::span<const PanopticId> ids) {
  const auto place = find(frame);
  if (!place) return;
  Entry& entry = entries_[*place];
  bytes_ -= bytes_of(entry);
  entry.labels = std::make_shared<const Bytes>(encode_labels(segmentation, ids));
  entry.changed_at = ++clock_;
  bytes_ += bytes_of(entry);
}

void FrameLog::set_pose(std::size_t n, const Pose& world_from_camera) {
  entries_[n].world_from_camera = world_from_camera;
  entries_[n].changed_at = ++clock_;
}

std::optional<std::size_t> FrameLog::find(std::int64_t frame) const {
  const auto place = place_of_.find(frame);
  return place == place_of_.end() ? std::nullopt : std::optional(place->second);
}

std::optional<LoggedLabels> FrameLog::labels(std::size_t n, LoggedPixels pixels) const {
  const Entry& entry = entries_[n];
  if (!entry.labels) return std::nullopt;
  std::optional<LoggedLabels> labels = decode_labels(*entry.labels, pixels);
  if (!labels) throw Error(fmt::format("the labels of frame {} in the map's log are damaged; use another copy", entry.frame));
  return labels;
}

}  // namespace panoptic
