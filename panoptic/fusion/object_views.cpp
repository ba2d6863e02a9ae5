// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/object_views.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "panoptic/base/error.h"

namespace panoptic {
namespace {

constexpr PixelBox kNothingYet = {std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), 0, 0};

// By value of segment_at, 0 included. A row is a few runs of equal values.
std::vector<PixelBox> boxes_of(const Image<std::uint16_t>& segment_at, std::size_t segments) {
  std::vector<PixelBox> boxes(segments + 1, kNothingYet);
  const int width = segment_at.width();
  for (int v = 0; v < segment_at.height(); ++v) {
    const std::uint16_t* row = segment_at.row(v);
    for (int begin = 0, end = 0; begin < width; begin = end) {
      while (end < width && row[end] == row[begin]) ++end;
      PixelBox& box = boxes[row[begin]];
      box = {std::min(box.u0, begin), std::min(box.v0, v), std::max(box.u1, end), v + 1};
    }
  }
  return boxes;
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
