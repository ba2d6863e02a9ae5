// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <set>
#include <string>

#include "bindings/python/mapper.h"
#include "bindings/python/predictors.h"
#include "panoptic/map.h"
#include "panoptic/online.h"

namespace panoptic::python {

// A pipeline with what it works on. It has the mapper from its beginning to its end. It is to be ended before it is destroyed:
// whoever owns one has a Dropped for that.
class PythonPipeline {
 public:
  PythonPipeline(std::shared_ptr<PythonMapper> mapper, py::object predictor);
  PythonPipeline(const PythonPipeline&) = delete;
  PythonPipeline& operator=(const PythonPipeline&) = delete;

  bool push(const py::object& frame, const FrameArrays& arrays, bool wait);
  void skip(std::int64_t index, const std::string& reason);
  void stop(const std::string& why) { pipeline_->stop(why); }
  bool stopped() const { return ended_ || pipeline_->stopped(); }
  py::dict finish();
  PublishedMap published() const {
    return released([&] { return pipeline_->published(); });
  }
  const LabelSet& labels() const { return mapper_->mapper.map().labels; }

  // Ends and destroys a pipeline that nobody has any more. Wherever that happens: its own predictor may have had it last, whose
  // thread cannot wait for itself, or a thread that may begin no more work.
  static void drop(std::unique_ptr<PythonPipeline> pipeline);
  // Ends every pipeline that still works: before Python goes.
  static void end_all();
  // In a child of fork: they are none of its own.
  static void forget_all() { going().clear(); }

 private:
  void take_parts();
  void give_back_parts();
  void end();
  void require_going() const;
  bool is_own_thread() const;
  static void end_elsewhere(std::unique_ptr<PythonPipeline> pipeline);

  static std::set<PythonPipeline*>& going();

  std::shared_ptr<PythonMapper> mapper_;
  py::object predictor_;  // keeps it, and what is Python of it
  SharedPredictor* seeing_ = nullptr;
  WithThreads<OnlinePipeline> pipeline_;
  std::unique_ptr<WorkInProgress> in_progress_;
  Exclusive ending_{"end of the pipeline"};
  OnlineReport report_;
  bool ended_ = false;
  bool is_left_ = false;  // nobody has it any more, and end_all destroys it
};

// The deleter of Python's pointers to a pipeline.
struct Dropped {
  void operator()(PythonPipeline* pipeline) const { PythonPipeline::drop(std::unique_ptr<PythonPipeline>(pipeline)); }
};

}  // namespace panoptic::python
