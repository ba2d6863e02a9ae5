// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Mapping while frames arrive: every stage on a thread of its own (docs/online.md).
//
//   push ──▶ queue ──▶ fusion ──▶ Session ◀── regularizer   every regularize_every_s, beside the mapping
//     │                  ▲          │
//     ▼                  │          ▼
//   newest frame ──▶ networks     mesher and publisher      every mesh_every_s
//                    side by side
//
// Depth and colour of every frame are integrated as it comes; its labels, if the networks had time for it, when its prediction is
// there, with that frame's own pose. What is dropped: a frame that comes while `waiting_frames` wait for fusion is dropped whole;
// of the frames that come while the networks are at work, the newest alone is predicted, and the others stay without labels.
#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "panoptic/predict/predictor.h"
#include "panoptic/session/checkpoint.h"
#include "panoptic/session/online_options.h"
#include "panoptic/session/online_queues.h"
#include "panoptic/session/publisher.h"
#include "panoptic/session/rate_meter.h"
#include "panoptic/session/session.h"

namespace panoptic {

// How an online run went. Every frame that was read was used, skipped or dropped.
struct OnlineReport {
  std::uint64_t read = 0;     // frames and skipped positions that were handed over
  std::uint64_t used = 0;     // for geometry
  std::uint64_t skipped = 0;  // unusable
  std::uint64_t dropped = 0;  // since fusion was behind
  std::uint64_t lost = 0;     // handed over, but a failure or the end came first
  // Of the frames that were used:
  std::uint64_t labelled = 0;
  std::uint64_t passed_over = 0;  // since the networks were busy with another
  double geometry_hz = 0;         // from the first to the last
  double label_hz = 0;
  Profile latency;             // since the frame was read: "fused", "labelled", "visible" (in a published snapshot)
  std::string stopped_by;      // why, if it ended early; else empty
  std::exception_ptr failure;  // what a stage threw: the map holds what was fused by then; else null
};

// Threads: push, push_when_free, skip, stop, stopped and progress may be called from any thread; finish and the destructor from
// the one that made the pipeline. From construction until finish returns the pipeline alone uses the session and the predictor.
class OnlinePipeline {
 public:
  // `predictor`: nullptr for geometry and colour alone. Snapshots go to `latest`. `total`: frames that will be pushed, for those
  // who look on; 0 = not known.
  struct Parts {
    Session& session;
    Predictor* predictor = nullptr;
    LatestSnapshot& latest;
    std::uint64_t total = 0;
    // For tests: each stage calls it on its own thread, with its name, before every piece of work; it may sleep and throw.
    std::function<void(std::string_view stage)> before_work = [](std::string_view) {};
    // Of a run that a map file is kept of: told of every frame, and asked to save after each whose geometry was fused. The
    // pipeline alone uses it until finish returns; then the caller finishes it.
    Checkpoints* checkpoints = nullptr;
  };
  OnlinePipeline(const Parts& parts, const OnlineOptions& options);
  ~OnlinePipeline();  // as stop and finish
  OnlinePipeline(const OnlinePipeline&) = delete;
  OnlinePipeline& operator=(const OnlinePipeline&) = delete;

  // Takes a frame, as it comes from a camera. Never waits: false if it was dropped because fusion is behind, or if the run is
  // over.
  bool push(Frame frame);
  // The same for recordings that should be mapped whole: waits for room. False if the run is over.
  bool push_when_free(Frame frame);
  // Counts a frame that could not even be read.
  void skip(const SkippedFrame& frame);

  // Takes no more frames; what was taken is still mapped. The first reason counts.
  void stop(const std::string& why);
  // No more frames are taken: stop was called or a stage failed.
  bool stopped() const;

  // After the last frame: maps what was taken, ends all threads, does what Session::finish does (unless a stage failed), and
  // publishes the last snapshot. Throws nothing; a second call gives the same report.
  OnlineReport finish();

 private:
  using Clock = std::chrono::steady_clock;
  struct Arrived {
    Frame frame;
    Clock::time_point read_at;
    mutable std::int64_t position = 0;  // in the map file, once it is known; session_mutex_ guards it
  };
  using Arrival = std::shared_ptr<const Arrived>;
  // Geometry of a frame, or its labels if it has a segmentation.
  struct Job {
    Arrival arrived;
    std::shared_ptr<const Segmentation> segmentation;
  };

  std::thread start(const char* name, void (OnlinePipeline::*stage)());
  void start_threads();
  bool count_arrival(const Arrival& arrived, BoundedQueue<Job>::Pushed pushed);
  void fail(std::exception_ptr failure);
  bool wait_until(Clock::time_point time);

  void save(const Arrived& arrived, const std::optional<std::string>& refused);
  void note_dropped();

  void fuse_jobs();
  void fuse_geometry(const Job& job);
  void fuse_labels(const Job& job);
  void predict_newest();
  Segmentation predict(const Arrival& arrived);
  void run_semantic();
  void regularize_now_and_then();
  void regularize();
  void publish_now_and_then();
  void publish(bool finished);
  RunState run_state(bool finished);
  void note(const char* stage, const Stopwatch& stopwatch);
  static double seconds_since(Clock::time_point time);
  double now_s() const { return seconds_since(start_); }
  void end_threads();

  const OnlineOptions options_;
  const std::uint64_t total_;
  const std::function<void(std::string_view stage)> before_work_;
  const Clock::time_point start_ = Clock::now();
  Predictor* const predictor_;
  std::optional<PredictorHalves> halves_;

  FairMutex session_mutex_;  // guards these
  Session& session_;
  Checkpoints* const checkpoints_;
  SnapshotPublisher publisher_;                  // but for publish
  std::vector<Clock::time_point> fused_unseen_;  // read times of the frames that no snapshot shows yet

  BoundedQueue<Job> jobs_;
  Mailbox<Arrival> newest_;
  BoundedQueue<Arrival> semantic_todo_{1};
  BoundedQueue<Image<ClassId>> semantic_done_{1};

  mutable std::mutex state_mutex_;  // guards the rest
  std::condition_variable state_changed_;
  OnlineReport report_;
  std::vector<FrameRecord> dropped_;  // that the map file does not know of yet
  Profile stages_;
  RateMeter geometry_rate_;
  RateMeter label_rate_;
  bool stopped_ = false;
  bool ending_ = false;  // the stages that work now and then shall end
  bool finished_ = false;

  std::thread fusion_;
  std::thread networks_;
  std::thread semantic_;
  std::thread regularizer_;
  std::thread surface_;
};

}  // namespace panoptic
