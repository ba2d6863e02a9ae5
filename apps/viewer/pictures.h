// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The newest frame as files that browsers show, encoded once per frame and only when somebody asks.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "panoptic/mapping/snapshot.h"

namespace panoptic {

// Thread-safe. Every function returns the file's bytes, or null where the snapshot has no such picture.
class FramePictures {
 public:
  std::shared_ptr<const std::string> frame_jpeg(const SnapshotFrame& frame);
  std::shared_ptr<const std::string> labelled_jpeg(const SnapshotFrame& frame);
  // The panoptic ids in the colours of color_of, transparent where unknown or where nothing is known.
  std::shared_ptr<const std::string> overlay_png(const SnapshotFrame& frame, const LabelSet& labels);

  void clear();

 private:
  // One picture of one image. The image is remembered without being kept alive.
  struct Encoded {
    std::weak_ptr<const void> image;
    std::shared_ptr<const std::string> bytes;
  };
  template <typename Pixels, typename Encode>
  std::shared_ptr<const std::string> once(Encoded& slot, const std::shared_ptr<const Pixels>& image, Encode encode);

  std::mutex mutex_;
  Encoded frame_;
  Encoded labelled_;
  Encoded overlay_;
};

}  // namespace panoptic
