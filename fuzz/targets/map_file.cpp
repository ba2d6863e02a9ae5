// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map_file.h"

#include "fuzz/input.h"
#include "panoptic/map/frame_images.h"
#include "panoptic/mapfile/log_rows.h"

namespace panoptic::fuzz {

// A whole file, as SQLite finds it.
void map_file(Input input) {
  static const Scratch kScratch("map_file");
  const std::filesystem::path path = kScratch.put("a.panoptic", input);
  succeeds([&] { load_map(path); });
  succeeds([&] { load_frames(path); });
  succeeds([&] {
    constexpr std::size_t kMostBytes = 600;  // more may be 64 MB of depth
    for (const FrameLog::Entry& entry : load_log(path)) {
      if (!entry.images) continue;
      const auto packed = entry.images->packed();
      if (packed->size() <= kMostBytes) unpack_images(*packed);
    }
  });
}

}  // namespace panoptic::fuzz
