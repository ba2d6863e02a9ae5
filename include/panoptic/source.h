// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Recordings of posed RGB-D frames: one of the two interfaces that users implement.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/error.h"
#include "panoptic/frame.h"

namespace panoptic {

// A frame that cannot be used and why; the run goes on without it.
struct SkippedFrame {
  std::int64_t index = 0;
  std::string reason;
};

// The result of Dataset::read: a frame, or why there is none.
struct ReadResult {
  std::optional<Frame> frame;
  SkippedFrame skipped;  // meaningful when there is no frame
};

// The statements of a recording about itself, beside its frames, for those who check it (panoptic doctor, and every run). A line
// each.
struct RecordingNotes {
  std::vector<std::string> assumed;   // what no file says and was taken for granted
  std::vector<std::string> left_out;  // files that no frame was made of
  double depth_scale = 0;             // raw reading / depth_scale = metres; 0: not known
};

class FrameIterator;

class Dataset {
 public:
  Dataset() = default;
  Dataset(const Dataset&) = delete;
  Dataset& operator=(const Dataset&) = delete;
  virtual ~Dataset() = default;

  // The format and its essentials in one line: "7-Scenes, 500 frames, depth 640x480, colour 640x480".
  virtual std::string description() const = 0;

  // Positions in the sequence, 0 <= position < size(). Known without reading frames.
  virtual std::size_t size() const = 0;

  // Decodes one frame; images that it borrows without an owner stay as long as the dataset. Never throws for a bad frame (invalid
  // pose, unreadable image): says why instead. May be called from several threads at once.
  virtual ReadResult read(std::size_t position) const = 0;

  // Frame::world_from_camera of a position without decoding its images; nothing if it cannot be used, or is not known so cheaply.
  // May be called from several threads at once.
  virtual std::optional<Pose> pose(std::size_t /*position*/) const { return std::nullopt; }

  virtual RecordingNotes notes() const { return {}; }

  // Every usable frame in order, decoded ahead on another thread: for (const Frame& frame : dataset).
  FrameIterator begin() const;
  std::default_sentinel_t end() const { return {}; }
};

// Recognises the format (docs/datasets.md: ScanNet, 7-Scenes, TUM RGB-D ... plain folders, a list of recordings) and opens it.
// A calibration TOML, if given, overrides intrinsics, lens, depth scale and the colour camera: see docs/datasets.md.
// `pair_tolerance_s`: how far the time stamps of a pair of images may differ where a format pairs them by time (TUM RGB-D).
// Throws Error if nothing is recognised or the recording is unusable as a whole, and for "sim:...", which open_dataset opens
// (simulation.h).
std::unique_ptr<Dataset> open_recording(const std::filesystem::path& path, const std::filesystem::path& calibration = {},
                                        std::optional<double> pair_tolerance_s = {});

// Thrown by open_recording: all is there but poses.
class NoPoses : public Error {
 public:
  using Error::Error;
};

// The same for a camera that is to be tracked (camera_tracker.h): all frames have one pose, which means nothing, whatever the
// file says. Throws Error also for a list of recordings, which are tracked one by one.
std::unique_ptr<Dataset> open_without_poses(const std::filesystem::path& path, const std::filesystem::path& calibration = {},
                                            std::optional<double> pair_tolerance_s = {});

// Positions begin, begin + step, ... below end. "A:B:STEP", each part optional; B excluded; counts positions, not numbers in
// file names.
struct FrameRange {
  std::size_t begin = 0;
  std::size_t end = SIZE_MAX;
  std::size_t step = 1;

  std::size_t count(std::size_t dataset_size) const;
};
FrameRange parse_frame_range(const std::string& text);  // throws Error

// Reads a range of a dataset in order, decoding ahead on its own thread with a bounded queue, so memory does not grow with
// the recording. Use from one thread. The dataset must outlive it.
class FrameStream {
 public:
  explicit FrameStream(const Dataset& dataset, FrameRange range = {}, std::size_t ahead = 4);
  ~FrameStream();
  FrameStream(const FrameStream&) = delete;
  FrameStream& operator=(const FrameStream&) = delete;

  // The next position's result, frame or reason; nothing at the end.
  std::optional<ReadResult> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Input iterator over the usable frames of a dataset.
class FrameIterator {
 public:
  using value_type = Frame;
  using difference_type = std::ptrdiff_t;

  explicit FrameIterator(const Dataset& dataset);
  const Frame& operator*() const { return *frame_; }
  const Frame* operator->() const { return &*frame_; }
  FrameIterator& operator++();
  void operator++(int) { ++*this; }
  bool operator==(std::default_sentinel_t) const { return !frame_.has_value(); }

 private:
  std::shared_ptr<FrameStream> stream_;
  std::optional<Frame> frame_;
};

}  // namespace panoptic
