// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/publisher_loop.h"

#include <utility>

namespace panoptic {

void LoopPublisher::added(std::shared_ptr<const Frame> frame, std::shared_ptr<const Segmentation> segmentation) {
  const double now_s = since_start_.seconds();
  geometry_rate_.count(now_s);
  publisher_.fused(frame);
  if (segmentation->segment_at.empty()) return;
  label_rate_.count(now_s);
  publisher_.labelled({std::move(frame), std::move(segmentation), mapper_.segment_ids()});
}

void LoopPublisher::at(std::uint64_t done) {
  done_ = done;
  if (since_start_.seconds() - published_s_ < kEvery_s) return;
  publish(false, "");
  published_s_ = since_start_.seconds();
}

void LoopPublisher::finish(const std::string& stopped_by) { publish(true, stopped_by); }

void LoopPublisher::publish(bool finished, const std::string& stopped_by) {
  RunState run;
  run.frames_done = done_;
  run.frames_total = total_;
  run.elapsed_s = since_start_.seconds();
  run.geometry_hz = geometry_rate_.recent_hz(run.elapsed_s);
  run.label_hz = label_rate_.recent_hz(run.elapsed_s);
  run.finished = finished;
  run.stopped_by = stopped_by;
  publisher_.publish(publisher_.capture(mapper_, std::move(run)));
}

}  // namespace panoptic
