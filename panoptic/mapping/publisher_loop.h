// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Lets others look on while frames are mapped one after the other.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "panoptic/mapping/publisher.h"
#include "panoptic/mapping/rate_meter.h"
#include "panoptic/profile.h"

namespace panoptic {

// For the loop around Mapper::add: publishes about once a second, from the loop's own thread, and changes nothing in the map.
// Use from one thread. Keeps the newest frame and the newest one with a prediction alive.
class LoopPublisher {
 public:
  static constexpr double kEvery_s = 1;

  // `total`: positions that the loop will go through; 0 = not known.
  LoopPublisher(Mapper& mapper, LatestSnapshot& latest, std::uint64_t total)
      : mapper_(mapper), publisher_(latest), total_(total) {}

  // mapper.add took this frame, whose images are kept (panoptic/frame.h).
  void added(std::shared_ptr<const Frame> frame, std::shared_ptr<const Segmentation> segmentation);
  // So many positions are done; publishes if the last time was long enough ago.
  void at(std::uint64_t done);
  // The last snapshot, after Mapper::finish. `stopped_by`: why, if the run ended early; else empty.
  void finish(const std::string& stopped_by);

 private:
  void publish(bool finished, const std::string& stopped_by);

  Mapper& mapper_;
  SnapshotPublisher publisher_;
  std::uint64_t total_;
  std::uint64_t done_ = 0;
  Stopwatch since_start_;
  double published_s_ = -kEvery_s;
  RateMeter geometry_rate_;
  RateMeter label_rate_;
};

}  // namespace panoptic
