// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// ScanNet's .sens stream, version 4.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "panoptic/source.h"

namespace panoptic {

class SensDataset : public Dataset {
 public:
  // Walks over the frame headers without reading images and checks every size against the file's. Throws Error for a file
  // that is cut off, lies about its sizes, or uses a compression that cannot be read.
  // `without_poses`: those of the file are not looked at, as open_without_poses has it.
  explicit SensDataset(const std::filesystem::path& path, const std::filesystem::path& calibration = {},
                       bool without_poses = false);
  ~SensDataset() override;
  SensDataset(const SensDataset&) = delete;
  SensDataset& operator=(const SensDataset&) = delete;

  std::string description() const override;
  std::size_t size() const override;
  ReadResult read(std::size_t position) const override;
  std::optional<Pose> pose(std::size_t position) const override;
  RecordingNotes notes() const override;

 private:
  ReadResult read_frame(std::size_t position) const;  // throws FileError

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
