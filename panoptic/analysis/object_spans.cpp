// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>
#include <map>

#include "panoptic/query.h"

namespace panoptic {
namespace {

// Times of used frames; a frame that is not listed has that of the one before it.
class FrameTimes {
 public:
  explicit FrameTimes(const std::vector<FrameRecord>& frames) {
    for (const FrameRecord& frame : frames) {
      if (frame.unused_because.empty()) time_s_.emplace(frame.frame, frame.time_s);
    }
  }
  double of(std::int64_t frame) const {
    const auto after = time_s_.upper_bound(frame);
    if (after != time_s_.begin()) return std::prev(after)->second;
    return time_s_.empty() ? 0 : time_s_.begin()->second;
  }

 private:
  std::map<std::int64_t, double> time_s_;
};

template <typename Wanted>
std::vector<ObjectSpan> those(const std::vector<ObjectSpan>& spans, const Wanted& wanted) {
  std::vector<ObjectSpan> some;
  std::copy_if(spans.begin(), spans.end(), std::back_inserter(some), wanted);
  return some;
}

}  // namespace

std::vector<ObjectSpan> object_spans(const PanopticMap& map, const std::vector<FrameRecord>& frames) {
  const FrameTimes times(frames);
  std::vector<ObjectSpan> spans;
  const MapQuery query(map);
  for (const FoundObject& o : query.objects()) {
    const auto arrival = map.history.arrivals.find(o.id);
    ObjectSpan span{.id = o.id, .class_id = o.class_id, .box = o.box, .first_s = times.of(o.first_frame), .gone_s = {}};
    span.appeared = arrival != map.history.arrivals.end();
    if (span.appeared) span.moved_from = arrival->second.moved_from;
    spans.push_back(span);
  }
  for (const PastObject& past : map.history.past) {
    ObjectSpan span{
        .id = past.id, .class_id = past.class_id, .box = past.box, .first_s = times.of(past.first_frame), .gone_s = {}};
    span.gone_s = times.of(past.gone_frame);
    span.moved_to = past.moved_to;
    spans.push_back(span);
  }
  std::sort(spans.begin(), spans.end(), [](const ObjectSpan& a, const ObjectSpan& b) { return a.id < b.id; });
  return spans;
}

std::vector<ObjectSpan> present_at(const std::vector<ObjectSpan>& spans, double time_s) {
  return those(spans, [&](const ObjectSpan& s) { return s.first_s <= time_s && (!s.gone_s || *s.gone_s > time_s); });
}

std::vector<ObjectSpan> changed_since(const std::vector<ObjectSpan>& spans, double time_s) {
  return those(spans,
               [&](const ObjectSpan& s) { return (s.gone_s && *s.gone_s > time_s) || (s.appeared && s.first_s > time_s); });
}

}  // namespace panoptic
