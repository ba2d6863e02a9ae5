// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The images of a video, by their place in it: the one seam to FFmpeg's libraries, which are an optional part of the build
// (PANOPTIC_VIDEO).
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "panoptic/image.h"

namespace panoptic {

// Whether this build reads videos. Without, a Video cannot be made.
bool reads_videos();

// An .mp4 or .mov file. Images are as they are stored: what the file says about turning them for people is not followed.
class Video {
 public:
  // Walks over the file once, decoding nothing. Throws Error naming it if it holds no images, its images are too large, it is
  // none of these files, or this build reads no videos, with the command that extracts the images.
  explicit Video(const std::filesystem::path& path);
  ~Video();
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  std::size_t size() const;  // images, in the order in which they are shown
  bool is_cut_off() const;   // the file ends before its last image
  int width() const;         // as the file states it
  int height() const;

  // Image `position`, the same however it is asked for. Fast in order; going back means decoding from the key image before. May
  // be called from several threads, which then take turns. Throws Error if the image, or one that it is derived from, is
  // damaged.
  Image<Rgb> read(std::size_t position) const;

 private:
  struct Decoder;
  std::unique_ptr<Decoder> decoder_;
};

}  // namespace panoptic
