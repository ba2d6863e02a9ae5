// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/session/frame_log.h"

namespace panoptic {

void FrameLog::count_skipped(const SkippedFrame& frame) {
  ++skipped_;
  ++by_reason_[frame.reason.substr(0, frame.reason.find(':'))];
  if (first_.size() < kMaxListed) first_.push_back(frame);
}

}  // namespace panoptic
