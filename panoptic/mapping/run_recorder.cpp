// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/run_recorder.h"

#include <utility>

#include "panoptic/profile.h"

namespace panoptic {

RunRecorder::RunRecorder(Checkpoints* checkpoints) : checkpoints_(checkpoints) {
  if (checkpoints_ == nullptr) return;
  for (const FrameRecord& record : checkpoints_->resumed_frames()) count(record);
}

void RunRecorder::count(const FrameRecord& record) {
  if (!record.unused_because.empty()) return;
  if (!first_used_) first_used_ = record.frame;
  last_used_ = record.frame;
}

std::int64_t RunRecorder::frame(const Frame& frame, bool labelled, const Outcome& outcome) {
  FrameRecord record = record_of(frame, labelled, outcome);
  count(record);
  return checkpoints_ != nullptr ? checkpoints_->note(std::move(record)) : 0;
}

void RunRecorder::not_given(FrameRecord record) {
  if (checkpoints_ != nullptr) checkpoints_->note(std::move(record));
}

void RunRecorder::labelled(const Frame& frame, const Pose& world_from_camera, std::int64_t position) {
  if (checkpoints_ == nullptr) return;
  FrameRecord record = record_of(frame, true, {});
  record.world_from_camera = world_from_camera;
  record.position = position;
  checkpoints_->correct(std::move(record));
}

void RunRecorder::save_if_due(Mapper& mapper) {
  if (checkpoints_ == nullptr) return;
  const Stopwatch saving;
  checkpoints_->after_frame(mapper);
  mapper.profile().add("save", saving.seconds());
}

}  // namespace panoptic
