// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The log from which a map can be made anew when poses change: of every used frame its pose and its segments, each with the
// object that it was given. Depth and colour stay in the recording, or are copied. A frame takes some kilobytes, mostly for the
// outlines of its segments, and its copy half a megabyte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/map/logged_images.h"
#include "panoptic/objects.h"
#include "panoptic/segmentation.h"

namespace panoptic {

// The segments of a logged frame, and for each what it was given: the number of a class, the id of an object, kUnknown, or
// kNoPlace where there was no place for a new object.
struct LoggedLabels {
  static constexpr auto kNoPlace = static_cast<PanopticId>(~std::uint32_t{0});

  Segmentation segmentation;
  std::vector<PanopticId> ids;
};

// Whether Segmentation::segment_at is filled in.
enum class LoggedPixels : std::uint8_t { kDecoded, kLeftOut };

// Whether a log copies depth and colour, and where they lie. Those that go into a map file now and then (LoggedImages::let_go) do
// not count for the limit.
enum class LoggedCopies : std::uint8_t { kNone, kInMemory, kInFile };

class FrameLog {
 public:
  using Bytes = std::vector<std::uint8_t>;
  struct Entry {
    std::int64_t frame = 0;
    double time_s = 0;
    Pose world_from_camera = Pose::Identity();
    std::shared_ptr<const Bytes> labels;             // encoded; nullptr: the frame came without a prediction
    std::shared_ptr<LoggedImages> images = nullptr;  // nullptr: they are in the recording alone
    std::uint64_t added_at = 0;                      // as FrameLog::clock
    std::uint64_t changed_at = 0;                    // the same
  };

  explicit FrameLog(std::size_t limit_bytes = 0, LoggedCopies copies = LoggedCopies::kNone)
      : limit_bytes_(limit_bytes), copies_(copies) {}
  // Restores the entries of a log that was saved. They may be more than the limit.
  FrameLog(std::vector<Entry> entries, std::size_t limit_bytes, LoggedCopies copies = LoggedCopies::kNone);

  // The next used frame. Beyond the limit nothing is added any more: then the log holds fewer frames than the map. Copies are
  // packed on threads of their own, of a few frames at once: it waits for the oldest of these.
  void add(const Frame& frame);
  // Copies go into a file from now on. REQUIRES that there are none in memory.
  void copy_to_file();
  // The labels of a frame, `ids` as LoggedLabels; nothing happens if it is not in the log.
  void set_labels(std::int64_t frame, const Segmentation& segmentation, std::span<const PanopticId> ids);
  // REQUIRES n < size().
  void set_pose(std::size_t n, const Pose& world_from_camera);

  std::size_t size() const { return entries_.size(); }
  std::size_t bytes() const { return bytes_; }
  std::size_t limit_bytes() const { return limit_bytes_; }
  LoggedCopies copies() const { return copies_; }
  std::size_t packed_bytes() const { return packed_bytes_; }      // of all copies that were made, but the last few
  const std::vector<Entry>& entries() const { return entries_; }  // in the order in which the frames were used
  std::optional<std::size_t> find(std::int64_t frame) const;
  // Two entries are of frames with the same number; find knows one of them.
  bool has_doubles() const { return place_of_.size() < entries_.size(); }
  // The labels of an entry; nothing if it has none. Throws Error if they are damaged.
  std::optional<LoggedLabels> labels(std::size_t n, LoggedPixels pixels = LoggedPixels::kDecoded) const;

  // Counts changes: what changed after an earlier moment has a larger Entry::changed_at.
  std::uint64_t clock() const { return clock_; }

 private:
  void count_packed();

  std::size_t limit_bytes_;
  LoggedCopies copies_;
  std::vector<Entry> entries_;
  std::unordered_map<std::int64_t, std::size_t> place_of_;  // by frame
  std::size_t bytes_ = 0;
  std::size_t packed_bytes_ = 0;
  std::size_t counted_ = 0;  // entries whose copies are counted in
  std::uint64_t clock_ = 1;
};

// The bytes of a frame's labels, and back; nothing if the bytes are damaged.
FrameLog::Bytes encode_labels(const Segmentation& segmentation, std::span<const PanopticId> ids);
std::optional<LoggedLabels> decode_labels(std::span<const std::uint8_t> bytes, LoggedPixels pixels = LoggedPixels::kDecoded);

}  // namespace panoptic
