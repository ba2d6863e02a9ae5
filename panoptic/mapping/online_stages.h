// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The stages of the online pipeline: each function is the work of one thread, from the first frame to the last.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/online_control.h"
#include "panoptic/mapping/online_counters.h"
#include "panoptic/mapping/online_queues.h"
#include "panoptic/mapping/publisher.h"
#include "panoptic/mapping/run_recorder.h"
#include "panoptic/mapping/run_tracker.h"
#include "panoptic/online.h"
#include "panoptic/options.h"
#include "panoptic/pose_update.h"
#include "panoptic/predictor.h"
#include "panoptic/segmentation.h"

namespace panoptic {

// A frame that was handed over. The last two are for fusion alone.
struct ArrivedFrame {
  Frame frame;
  RunControl::Clock::time_point read_at;
  mutable std::shared_ptr<const Frame> located =
      nullptr;                        // with the pose that was tracked; nullptr: not yet, or the camera is lost
  mutable std::int64_t position = 0;  // in the recording, once it is known
};
using SharedFrame = std::shared_ptr<const ArrivedFrame>;

// A piece of work for fusion: the geometry of a frame, its labels if there is a segmentation, or, if there is no frame, poses
// that the map is to follow.
struct FusionJob {
  SharedFrame arrived = nullptr;
  std::shared_ptr<const Segmentation> segmentation = nullptr;
  std::vector<PoseUpdate> poses = {};
};

// All that the stages share.
struct SharedRun {
  const OnlinePipeline::Parts parts;
  const OnlineOptions options;
  const std::optional<PredictorHalves> halves;  // of the predictor

  // Guards mapper and recorder, and these two. Only fusion and the regularizer write to the mapper, so fusion may read it
  // without.
  FairMutex mapper_mutex;
  SnapshotPublisher publisher;                                   // but for publish
  std::vector<RunControl::Clock::time_point> fused_unseen = {};  // read times of the frames that no snapshot shows yet

  std::mutex regularizing = {};             // held by the regularizer at work, and by fusion while the map is fused anew
  std::atomic<bool> is_correcting = false;  // the map is being fused anew

  BoundedQueue<FusionJob> jobs;
  Mailbox<SharedFrame> newest = {};
  BoundedQueue<SharedFrame> semantic_todo{1};
  BoundedQueue<Image<ClassId>> semantic_done{1};
  Tray<FrameRecord> dropped = {};  // frames that the recorder does not know of yet

  RunControl control = {};
  OnlineCounters counters = {};
};

// Each returns when there is no more work for it, or when the run has failed.
void fuse_jobs(SharedRun& run);
void predict_newest(SharedRun& run);
void run_semantic_network(SharedRun& run);
void regularize_now_and_then(SharedRun& run);
void publish_now_and_then(SharedRun& run);

// One snapshot. REQUIRES that publish_now_and_then is not at work.
void publish(SharedRun& run, bool finished);
// Hands the recorder what it does not know of yet. REQUIRES the mapper's mutex.
void record_dropped(SharedRun& run);
// Ends the run after a failure: wakes every stage that waits and leaves it nothing to wait for.
void fail(SharedRun& run, std::exception_ptr failure);

}  // namespace panoptic
