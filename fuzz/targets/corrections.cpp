// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/input.h"
#include "fuzz/targets.h"
#include "panoptic/map/frame_images.h"
#include "panoptic/map/frame_log.h"
#include "panoptic/pose_update.h"

namespace panoptic::fuzz {
namespace {

// Labels that can be read can be written, and are read again.
void labels(Input bytes) {
  constexpr std::size_t kMostBytes = 900;  // a row of 16384 pixels takes a byte at least
  if (bytes.size() > kMostBytes) return;
  const auto labels = decode_labels(bytes);
  if (!labels) return;
  const auto again = decode_labels(encode_labels(labels->segmentation, labels->ids));
  require(again && again->segmentation.segment_at == labels->segmentation.segment_at && again->ids == labels->ids,
          "labels are the same after writing them");
}

// Images that can be read are the same after writing them, or as much as their sizes say.
void images(Input bytes) {
  constexpr std::size_t kMostBytes = 400;  // more may be 32 MB of depth
  if (bytes.size() > kMostBytes) return;
  const auto frame = unpack_images(bytes);
  if (!frame) return;
  const auto again = unpack_images(pack_images(*frame));
  require(again && again->color == frame->color && again->depth.same_size(frame->depth.width(), frame->depth.height()),
          "images are the same after writing them");
}

}  // namespace

// The first byte says what the rest is: labels of a logged frame, its images, corrections of a run, or a trajectory.
void corrections(Input input) {
  static const Scratch kScratch("corrections");
  if (input.empty()) return;
  if (input[0] % 4 == 0) return labels(input.subspan(1));
  if (input[0] % 4 == 3) return images(input.subspan(1));
  const std::filesystem::path path = kScratch.put("poses", input.subspan(1));
  succeeds([&] {
    if (input[0] % 4 == 1) {
      read_pose_updates(path);
    } else {
      read_corrected_poses(path, {{0, 0}, {1, 0.1}, {7, 0.2}});
    }
  });
}

}  // namespace panoptic::fuzz
