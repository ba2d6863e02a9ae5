// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Several recordings mapped as one: homes beside each other, or visits of one home. A list file names them and says where each
// lies in the common world: docs/datasets.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/source.h"

namespace panoptic {

// An entry of a list file. Paths are absolute, or, of a recording, "sim:SEED...".
struct ListedRecording {
  std::string name;  // as the file has it, for messages
  std::string recording;
  std::string calibration;  // empty: none
  std::optional<double> pair_tolerance_s;
  std::string predictions;  // empty: none
  bool tracked = false;     // its own poses are not read: the camera was tracked when it was mapped
  Pose world_from_recording = Pose::Identity();
};

// True for a file that ends in .toml, whatever is in it.
bool is_recording_list(const std::filesystem::path& path);

// Throws Error naming file, line and remedy; the recordings are not opened.
std::vector<ListedRecording> read_recording_list(const std::filesystem::path& path);

// The text of a list file of these, which read_recording_list takes back wherever the file lies.
std::string to_toml(const std::vector<ListedRecording>& recordings);

// Throws Error if the recording's camera was tracked: outside the map that it is in, its frames have no poses.
void require_posed(const ListedRecording& recording);

using OpenListed = std::function<std::unique_ptr<Dataset>(const ListedRecording&)>;

// The recordings one after the other. Frames keep the numbers of their recording, those of each but the first behind the last
// number of the one before it; time stamps go on likewise, 2 s after it.
class RecordingList : public Dataset {
 public:
  struct Part {
    ListedRecording listed;
    std::unique_ptr<Dataset> dataset;
    std::size_t first_position = 0;
    std::int64_t first_number = 0;  // its frame n has the number first_number + n here
    std::int64_t last_number = 0;
    double time_shift_s = 0;
  };

  // Reads a frame at each end of every recording. Throws Error: what the file says, what opening throws, no frames.
  RecordingList(const std::filesystem::path& path, const OpenListed& open);

  std::string description() const override;
  std::size_t size() const override { return size_; }
  ReadResult read(std::size_t position) const override;
  std::optional<Pose> pose(std::size_t position) const override;
  RecordingNotes notes() const override;

  const std::vector<Part>& parts() const { return parts_; }

 private:
  void append(ListedRecording listed, const OpenListed& open);
  const Part& part_of(std::size_t position) const;

  std::vector<Part> parts_;
  std::size_t size_ = 0;
  double last_time_s_ = 0;
};

// The dataset if it is a list, else nullptr.
const RecordingList* as_recording_list(const Dataset& dataset);

// Opens a list. Throws Error as RecordingList does, and for a calibration or tolerance, which a list gives for each recording.
std::unique_ptr<Dataset> open_recording_list(const std::filesystem::path& path, const std::filesystem::path& calibration,
                                             std::optional<double> pair_tolerance_s, const OpenListed& open);

}  // namespace panoptic
