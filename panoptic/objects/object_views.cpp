// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/object_views.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "panoptic/base/value_runs.h"
#include "panoptic/error.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr PixelBox kNothingYet = {std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), 0, 0};

constexpr std::size_t kBands = 8;  // of rows

PixelBox around(const PixelBox& a, const PixelBox& b) {
  return {std::min(a.u0, b.u0), std::min(a.v0, b.v0), std::max(a.u1, b.u1), std::max(a.v1, b.v1)};
}

// Boxes by the value of segment_at, 0 included. A row is a few runs of equal values.
std::vector<PixelBox> boxes_of(const Image<std::uint16_t>& segment_at, std::size_t segments) {
  std::array<std::vector<PixelBox>, kBands> boxes;
  const auto height = static_cast<std::size_t>(segment_at.height());
  parallel_for(kBands, [&](std::size_t band) {
    boxes[band].assign(segments + 1, kNothingYet);
    for (std::size_t v = height * band / kBands; v < height * (band + 1) / kBands; ++v) {
      const std::uint16_t* row = segment_at.row(static_cast<int>(v));
      for (int begin = 0, end = 0; begin < segment_at.width(); begin = end) {
        end = end_of_run(row, begin, segment_at.width());
        PixelBox& box = boxes[band][row[begin]];
        box = around(box, {begin, static_cast<int>(v), end, static_cast<int>(v) + 1});
      }
    }
  });
  for (std::size_t band = 1; band < kBands; ++band) {
    for (std::size_t s = 0; s <= segments; ++s) boxes[0][s] = around(boxes[0][s], boxes[band][s]);
  }
  return std::move(boxes[0]);
}

}  // namespace

void record_views(const Segmentation& segmentation, const TrackedSegments& tracked, ObjectRegistry& objects) {
  const auto& segments = segmentation.segments;
  PANOPTIC_ASSERT(tracked.id.size() == segments.size() && tracked.visible_px.size() == segments.size());
  std::vector<PixelBox> boxes;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const Object* object = objects.find(tracked.id[s]);
    if (object == nullptr || tracked.visible_px[s] == 0) continue;
    ObjectView view{tracked.frame, segments[s].class_id, segments[s].score, tracked.visible_px[s], {}};
    if (!object->best_views.wants(view)) continue;
    if (boxes.empty()) boxes = boxes_of(segmentation.segment_at, segments.size());
    view.box = boxes[s + 1];
    objects.show(tracked.id[s], view);
  }
}

}  // namespace panoptic
