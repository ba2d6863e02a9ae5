// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/session/online.h"

#include <pthread.h>

#include <algorithm>
#include <new>
#include <utility>

namespace panoptic {
namespace {

constexpr const char* kDropped = "dropped: fusion was behind";

std::string text_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::bad_alloc&) {
    return "out of memory";
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "an unknown failure";
  }
}

}  // namespace

Fields fields(OnlineOptions& o) {
  return {
      {"mesh_every_s", &o.mesh_every_s, "seconds between two snapshots of the surface for those who look on",
       in_range(0.05, 3600)},
      {"regularize_every_s", &o.regularize_every_s, "seconds between two regularizations; it also runs at the end",
       in_range(0.1, 1e6)},
      {"waiting_frames", &o.waiting_frames, "a frame that comes while so many wait for fusion is dropped", in_range(1, 1000)}};
}

OnlinePipeline::OnlinePipeline(const Parts& parts, const OnlineOptions& options)
    : options_(options),
      total_(parts.total),
      before_work_(parts.before_work),
      predictor_(parts.predictor),
      halves_(parts.predictor != nullptr ? parts.predictor->halves() : std::nullopt),
      session_(parts.session),
      checkpoints_(parts.checkpoints),
      publisher_(parts.latest),
      jobs_(static_cast<std::size_t>(options.waiting_frames)) {
  try {
    start_threads();
  } catch (...) {
    fail(std::current_exception());
    end_threads();
    throw;
  }
}

OnlinePipeline::~OnlinePipeline() {
  stop("abandoned");
  finish();
}

void OnlinePipeline::start_threads() {
  fusion_ = start("fusion", &OnlinePipeline::fuse_jobs);
  if (predictor_ != nullptr) networks_ = start("networks", &OnlinePipeline::predict_newest);
  if (halves_) semantic_ = start("semantic", &OnlinePipeline::run_semantic);
  regularizer_ = start("regularizer", &OnlinePipeline::regularize_now_and_then);
  surface_ = start("mesher", &OnlinePipeline::publish_now_and_then);
}

std::thread OnlinePipeline::start(const char* name, void (OnlinePipeline::*stage)()) {
  std::thread thread([this, stage] {
    try {
      (this->*stage)();
    } catch (...) {
      fail(std::current_exception());
    }
  });
  pthread_setname_np(thread.native_handle(), name);  // for top and debuggers
  return thread;
}

bool OnlinePipeline::push(Frame frame) {
  if (stopped()) return false;
  const auto arrived = std::make_shared<const Arrived>(Arrived{std::move(frame), Clock::now()});
  return count_arrival(arrived, jobs_.try_push({arrived, nullptr}));
}

bool OnlinePipeline::push_when_free(Frame frame) {
  if (stopped()) return false;
  const auto arrived = std::make_shared<const Arrived>(Arrived{std::move(frame), Clock::now()});
  const bool pushed = jobs_.push({arrived, nullptr});
  return count_arrival(arrived, pushed ? BoundedQueue<Job>::Pushed::kYes : BoundedQueue<Job>::Pushed::kClosed);
}

// The networks learn of a frame only now that its geometry is on its way, so its labels can never come first.
bool OnlinePipeline::count_arrival(const Arrival& arrived, BoundedQueue<Job>::Pushed pushed) {
  using Pushed = BoundedQueue<Job>::Pushed;
  const bool passed_over = pushed == Pushed::kYes && predictor_ != nullptr && newest_.put(arrived);
  const std::lock_guard lock(state_mutex_);
  ++report_.read;
  if (pushed == Pushed::kFull) ++report_.dropped;
  if (pushed == Pushed::kFull && checkpoints_ != nullptr) dropped_.push_back(record_of(arrived->frame, false, kDropped));
  if (passed_over) ++report_.passed_over;
  return pushed == Pushed::kYes;
}

void OnlinePipeline::skip(const SkippedFrame& frame) {
  {
    const std::lock_guard lock(session_mutex_);
    session_.skip(frame);
    if (checkpoints_ != nullptr) checkpoints_->note({.frame = frame.index, .unused_because = frame.reason});
  }
  const std::lock_guard lock(state_mutex_);
  ++report_.read;
  ++report_.skipped;
}

void OnlinePipeline::stop(const std::string& why) {
  const std::lock_guard lock(state_mutex_);
  if (stopped_) return;
  stopped_ = true;
  report_.stopped_by = why;
}

bool OnlinePipeline::stopped() const {
  const std::lock_guard lock(state_mutex_);
  return stopped_;
}

// Whatever waits is woken and finds its queue closed, so every thread comes to its end.
void OnlinePipeline::fail(std::exception_ptr failure) {
  {
    const std::lock_guard lock(state_mutex_);
    if (report_.stopped_by.empty()) report_.stopped_by = text_of(failure);
    if (!report_.failure) report_.failure = std::move(failure);
    stopped_ = true;
    ending_ = true;
    state_changed_.notify_all();
  }
  jobs_.abandon();
  newest_.abandon();
  semantic_todo_.abandon();
  semantic_done_.close();
}

void OnlinePipeline::fuse_jobs() {
  while (const std::optional<Job> job = jobs_.pop()) {
    before_work_("fusion");
    job->segmentation ? fuse_labels(*job) : fuse_geometry(*job);
  }
}

void OnlinePipeline::fuse_geometry(const Job& job) {
  bool used = false;
  {
    const std::lock_guard lock(session_mutex_);
    const std::optional<std::string> refused = session_.add_geometry(job.arrived->frame);
    used = !refused;
    if (checkpoints_ != nullptr) save(*job.arrived, refused);
    if (used) {
      publisher_.fused({job.arrived, &job.arrived->frame});
      fused_unseen_.push_back(job.arrived->read_at);
    }
  }
  const std::lock_guard lock(state_mutex_);
  if (!used) {
    ++report_.skipped;
    return;
  }
  ++report_.used;
  geometry_rate_.count(now_s());
  report_.latency.add("fused", seconds_since(job.arrived->read_at));
}

// The frame goes into the map file; blocks are copied if it is time, so the session must be held.
void OnlinePipeline::save(const Arrived& arrived, const std::optional<std::string>& refused) {
  const Stopwatch saving;
  note_dropped();
  arrived.position = checkpoints_->note(record_of(arrived.frame, false, refused));
  checkpoints_->after_frame(session_);
  session_.profile().add("save", saving.seconds());
}

void OnlinePipeline::note_dropped() {
  std::vector<FrameRecord> dropped;
  {
    const std::lock_guard lock(state_mutex_);
    dropped.swap(dropped_);
  }
  for (FrameRecord& record : dropped) checkpoints_->note(std::move(record));
}

void OnlinePipeline::fuse_labels(const Job& job) {
  {
    const std::lock_guard lock(session_mutex_);
    if (session_.add_labels(job.arrived->frame, *job.segmentation)) return;
    if (checkpoints_ != nullptr) {
      FrameRecord record = record_of(job.arrived->frame, true, std::nullopt);
      record.position = job.arrived->position;
      checkpoints_->correct(std::move(record));
    }
    publisher_.labelled({{job.arrived, &job.arrived->frame}, job.segmentation, session_.segment_ids()});
  }
  const std::lock_guard lock(state_mutex_);
  ++report_.labelled;
  label_rate_.count(now_s());
  report_.latency.add("labelled", seconds_since(job.arrived->read_at));
}

void OnlinePipeline::predict_newest() {
  while (const std::optional<Arrival> arrived = newest_.take()) {
    before_work_("networks");
    if (why_unusable((*arrived)->frame)) continue;
    const Stopwatch predicting;
    auto segmentation = std::make_shared<const Segmentation>(predict(*arrived));
    note("predict", predicting);
    // One place is kept for labels, so that frames cannot crowd them out.
    if (!segmentation->segment_at.empty() && !jobs_.push({*arrived, std::move(segmentation)}, 1)) break;
  }
  semantic_todo_.close();
}

Segmentation OnlinePipeline::predict(const Arrival& arrived) {
  if (!halves_) return predictor_->predict(arrived->frame);
  semantic_todo_.push(arrived);
  before_work_("instance");
  const Stopwatch running;
  const std::vector<Instance> instances = halves_->instances(arrived->frame.color);
  note("instance", running);
  const std::optional<Image<ClassId>> semantic = semantic_done_.pop();
  return semantic ? halves_->join(*semantic, instances) : Segmentation();  // nothing: the run has failed
}

void OnlinePipeline::run_semantic() {
  while (const std::optional<Arrival> arrived = semantic_todo_.pop()) {
    before_work_("semantic");
    const Stopwatch running;
    Image<ClassId> classes = halves_->semantic((*arrived)->frame.color);
    note("semantic", running);
    semantic_done_.push(std::move(classes));
  }
}

void OnlinePipeline::regularize_now_and_then() {
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options_.regularize_every_s));
  for (auto due = start_ + period; wait_until(due); due = std::max(due + period, Clock::now())) {
    before_work_("regularizer");
    const Stopwatch regularizing;
    regularize();
    note("regularize beside", regularizing);
  }
}

// Submap by submap: mapping pauses only while one is copied or written.
void OnlinePipeline::regularize() {
  std::vector<std::vector<Slot>> submaps;
  {
    const std::lock_guard lock(session_mutex_);
    submaps = session_.choose_submaps();
  }
  for (const std::vector<Slot>& blocks : submaps) {
    if (!wait_until(Clock::now())) return;
    SubmapGraph submap;
    {
      const std::lock_guard lock(session_mutex_);
      submap = session_.gather(blocks);
    }
    SubmapChanges changes = session_.solve(submap);
    const std::lock_guard lock(session_mutex_);
    session_.write_back(std::move(changes));
  }
}

void OnlinePipeline::publish_now_and_then() {
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options_.mesh_every_s));
  for (auto due = start_ + period; wait_until(due); due = std::max(due + period, Clock::now())) {
    before_work_("mesher");
    publish(false);
  }
}

void OnlinePipeline::publish(bool finished) {
  const Stopwatch publishing;
  RunState run = run_state(finished);
  std::vector<Clock::time_point> seen;
  SessionCapture capture;
  {
    const std::lock_guard lock(session_mutex_);
    capture = publisher_.capture(session_, std::move(run));
    seen.swap(fused_unseen_);
  }
  publisher_.publish(std::move(capture));
  note("publish", publishing);
  const std::lock_guard lock(state_mutex_);
  for (const Clock::time_point read_at : seen) report_.latency.add("visible", seconds_since(read_at));
}

RunState OnlinePipeline::run_state(bool finished) {
  const std::lock_guard lock(state_mutex_);
  RunState run;
  run.frames_done = report_.read;
  run.frames_total = total_;
  run.dropped = {{"fusion", report_.dropped}, {"networks", report_.passed_over}};
  run.elapsed_s = now_s();
  run.geometry_hz = geometry_rate_.recent_hz(run.elapsed_s);
  run.label_hz = label_rate_.recent_hz(run.elapsed_s);
  run.finished = finished;
  run.stopped_by = report_.stopped_by;
  for (const auto& [name, times] : stages_.stages()) run.stages[name] = stage_time(times);
  for (const auto& [name, times] : report_.latency.stages()) run.stages["until " + name] = stage_time(times);
  return run;
}

// False: the run is ending.
bool OnlinePipeline::wait_until(Clock::time_point time) {
  std::unique_lock lock(state_mutex_);
  return !state_changed_.wait_until(lock, time, [this] { return ending_; });
}

void OnlinePipeline::note(const char* stage, const Stopwatch& stopwatch) {
  const std::lock_guard lock(state_mutex_);
  stages_.add(stage, stopwatch.seconds());
}

double OnlinePipeline::seconds_since(Clock::time_point time) {
  return std::chrono::duration<double>(Clock::now() - time).count();
}

// In the order in which work flows, so that each stage gets what the one before it still gives.
void OnlinePipeline::end_threads() {
  const auto join = [](std::thread& thread) {
    if (thread.joinable()) thread.join();
  };
  newest_.close();
  join(networks_);
  semantic_todo_.close();
  join(semantic_);
  jobs_.close();
  join(fusion_);
  {
    const std::lock_guard lock(state_mutex_);
    stopped_ = true;
    ending_ = true;
    state_changed_.notify_all();
  }
  join(regularizer_);
  join(surface_);
}

OnlineReport OnlinePipeline::finish() {
  if (finished_) return report_;
  end_threads();
  if (checkpoints_ != nullptr) note_dropped();
  try {
    if (!report_.failure) session_.finish();
    publish(true);
  } catch (...) {
    fail(std::current_exception());
  }
  session_.profile().add(stages_);
  const std::lock_guard lock(state_mutex_);  // a push may come late
  report_.lost = report_.read - report_.used - report_.skipped - report_.dropped;
  report_.geometry_hz = geometry_rate_.hz();
  report_.label_hz = label_rate_.hz();
  finished_ = true;
  return report_;
}

}  // namespace panoptic
