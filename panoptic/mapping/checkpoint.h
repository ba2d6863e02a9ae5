// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Keeps a map file up to date while a mapper maps a recording, and goes on from such a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/map_file.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapper.h"
#include "panoptic/options.h"
#include "panoptic/profile.h"
#include "panoptic/run_outputs.h"

namespace panoptic {

struct MapperState;

// Everything that decides what the map of a run becomes. A run is resumed only if all of it is as it was.
struct RunIdentity {
  std::string recording;    // as RunSummary
  std::string calibration;  // as RunSummary
  std::string frames;       // the range that was asked for; empty = all
  Options options;
  bool online = false;  // what was labelled depended on the machine: it can be kept, but not resumed
  std::optional<double> pair_tolerance_s = {};
  std::string recordings = {};    // of a list: to_text below
  std::string pose_updates = {};  // absolute path of the file of corrections; empty: none
  bool tracked = false;           // poses are the run's own: it can be kept, but not resumed
};

// All that decides which frames come of the recordings of a list, one a line.
std::string to_text(const std::vector<RunRecording>& recordings);

// The text that a map file keeps of options, `key = value` a line: without those that say where a map lies in memory.
std::string options_text(Options options);

// The record of a frame that was handed to a mapper, without its position.
FrameRecord record_of(const Frame& frame, bool labelled, const Outcome& outcome);

// A complete map file of the first recordings of the list that is mapped (visits.h). It stays as it is.
struct EarlierMap {
  std::filesystem::path path;
  std::size_t positions = 0;  // that these recordings have
};

struct CheckpointSettings {
  std::filesystem::path path;
  bool resume = false;                     // goes on from the file if there is one; else there must be none
  std::optional<EarlierMap> earlier = {};  // what a new file begins with; nothing: an empty map
  double every_s = 5;
  std::size_t copies_bytes = 16'000'000;                                     // of copies of frames that wait
  std::function<void(const std::string&)> warn = [](const std::string&) {};  // from the thread that calls after_frame
};

// Writing happens on a thread of its own. What cannot be written is kept and tried again; the file then holds the last checkpoint
// that could. Use from the thread that the mapper belongs to.
class Checkpoints {
 public:
  // Makes the file, or brings the mapper to where the file (or the earlier one) is. Throws Error: there is a file already, it is
  // of another run, it is damaged, another process writes it.
  Checkpoints(CheckpointSettings settings, const RunIdentity& identity, Mapper& mapper);
  ~Checkpoints();
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;

  // Frames of the run so far, those before it was resumed included.
  std::uint64_t positions() const { return positions_; }
  bool was_complete() const { return was_complete_; }
  const std::vector<FrameRecord>& resumed_frames() const { return resumed_frames_; }

  // Records the next position of the recording; `record.position` is filled in, and returned.
  std::int64_t note(FrameRecord record);
  // A record that was noted before, as it is now.
  void correct(FrameRecord record) { frames_.push_back(std::move(record)); }
  // Between frames: begins a checkpoint if it is time and the last one is through, or to write copies of frames, if many wait.
  // Warns once if that failed. Waits for it if four times as many wait; throws Error if these cannot be written.
  void after_frame(const Mapper& mapper);
  // The last one, whole: all that the mapper holds is in the file, and the file is one again. `complete`: the recording is
  // through and mapper.finish() was called; else it is a checkpoint to resume from. Throws Error; the file then holds an earlier
  // checkpoint.
  void finish(const Mapper& mapper, bool complete);

 private:
  struct Pending;

  void resume(const RunIdentity& identity, Mapper& mapper);
  void begin_with(const EarlierMap& earlier, const RunIdentity& identity, Mapper& mapper);
  MapperState load_state(const std::filesystem::path& path, const SavedMap& saved);
  std::unique_ptr<Pending> copy(const Mapper& mapper, bool complete);
  std::unique_ptr<Pending> copy_images(const FrameLog& log) const;
  void collect();
  bool too_many_wait(const Mapper& mapper, std::size_t times) const;
  bool is_writing() const { return writing_.valid(); }

  CheckpointSettings settings_;
  std::unique_ptr<MapFileWriter> writer_;
  std::map<std::string, std::string> identity_;
  std::uint64_t positions_ = 0;
  bool was_complete_ = false;
  std::vector<FrameRecord> resumed_frames_;
  std::vector<FrameRecord> frames_;  // not in the file yet
  std::uint64_t saved_epoch_ = 0;    // what changed since is not in the file
  std::uint64_t saved_log_ = 0;      // FrameLog::clock: what changed in the log since is not in the file
  std::uint64_t saved_anew_ = 0;     // MapperParts::times_anew of the map in the file
  std::uint64_t saved_images_ = 0;   // FrameLog::clock: images of entries that came since are not in the file
  std::size_t saved_copies_ = 0;     // FrameLog::packed_bytes of the log in the file
  std::unique_ptr<Pending> pending_;
  std::future<void> writing_;
  Stopwatch since_last_;
  bool warned_ = false;
};

}  // namespace panoptic
