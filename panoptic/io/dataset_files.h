// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Recordings that keep one file per image. All folder formats reduce to one passive struct, which one class reads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/io/calibration.h"
#include "panoptic/io/dataset_text.h"
#include "panoptic/io/video.h"
#include "panoptic/source.h"

namespace panoptic {

// One position of the sequence. Paths are relative to the recording; empty = there is no such file.
struct FileFrame {
  std::int64_t number = 0;
  double time_s = 0;
  std::string color;
  std::string depth;
  std::string pose_file;                   // a 4x4 matrix in a file of its own,
  std::optional<Eigen::Matrix4d> pose;     // or one that is known already
  std::string problem;                     // why the frame cannot be used, if that is known already
  std::string confidence;                  // an image of the depth readings' levels, of which 0 is the lowest
  std::optional<Camera> camera;            // of this frame alone, as Calibration::depth is of all; colour is registered to depth
  std::optional<std::size_t> video_image;  // `color` is the recording's video, and the image is this one of it
};

// Another order that a list of poses may have: that of the images' names as text.
struct OtherOrder {
  std::string list;                                        // the file, relative to the recording; empty: there is no choice
  std::vector<std::optional<Eigen::Matrix4d>> poses = {};  // of each frame
};

struct FileRecording {
  std::string format;
  std::filesystem::path root;
  std::vector<FileFrame> frames;
  Calibration calibration;
  std::vector<std::string> assumed = {};  // RecordingNotes
  int depth_bits_turned = 0;              // whole readings are stored with their bits turned to the left by so many
  OtherOrder other_order = {};            // until settle_pose_order
  bool has_confidence = false;            // a frame without such an image cannot be used
  std::shared_ptr<const Video> video = {};
};

// One position for every number that has a colour or a depth image, in numeric order. Frames are taken to be 1/30 s apart.
std::vector<FileFrame> joined(const NumberedFiles& color, const NumberedFiles& depth, const NumberedFiles& poses);

class FileDataset : public Dataset {
 public:
  // Reads a few images of each kind, for the size that most of them have. Throws Error if none is readable or the calibration
  // does not fit them.
  explicit FileDataset(FileRecording recording);

  std::string description() const override;
  std::size_t size() const override { return recording_.frames.size(); }
  ReadResult read(std::size_t position) const override;
  std::optional<Pose> pose(std::size_t position) const override;
  RecordingNotes notes() const override { return notes_; }

 private:
  FileRecording recording_;  // its calibration is fitted to the image sizes
  RecordingNotes notes_;     // as the files were when it was opened
};

}  // namespace panoptic
