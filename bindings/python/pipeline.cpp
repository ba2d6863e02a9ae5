// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/pipeline.h"

#include <exception>
#include <system_error>
#include <thread>
#include <utility>

namespace panoptic::python {

std::set<PythonPipeline*>& PythonPipeline::going() {
  static std::set<PythonPipeline*> pipelines;
  return pipelines;
}

PythonPipeline::PythonPipeline(std::shared_ptr<PythonMapper> mapper, py::object predictor)
    : mapper_(std::move(mapper)), predictor_(std::move(predictor)) {
  if (!predictor_.is_none() && !py::isinstance<SharedPredictor>(predictor_)) throw Error("predictor must be a Predictor or None");
  if (!predictor_.is_none()) seeing_ = predictor_.cast<SharedPredictor*>();
  if (seeing_ != nullptr && !same_classes(seeing_->labels(), labels())) {
    throw Error(
        fmt::format("the predictor's label set '{}' is not the mapper's '{}': make the mapper with labels=predictor.labels",
                    seeing_->labels().name(), labels().name()));
  }
  if (mapper_->finished) throw Error("the mapper is finished: no more can be added, so make a new one");
  take_parts();
  try {
    pipeline_ = WithThreads(released([&] {
      return std::make_unique<OnlinePipeline>(OnlinePipeline::Parts{mapper_->mapper, seeing_}, mapper_->options.online);
    }));
  } catch (...) {
    give_back_parts();
    throw;
  }
  in_progress_ = std::make_unique<WorkInProgress>();
  going().insert(this);
}

void PythonPipeline::take_parts() {
  constexpr const char* kUser = "an online pipeline (until its finish)";
  mapper_->use->take(kUser);
  if (seeing_ == nullptr) return;
  try {
    seeing_->use.take(kUser);
  } catch (...) {
    mapper_->use->give_back();
    throw;
  }
}

void PythonPipeline::give_back_parts() {
  mapper_->use->give_back();
  if (seeing_ != nullptr) seeing_->use.give_back();
}

bool PythonPipeline::is_own_thread() const {
  const auto* python = dynamic_cast<const PythonPredictor*>(seeing_);
  return python != nullptr && python->is_predicting_here();
}

void PythonPipeline::drop(std::unique_ptr<PythonPipeline> pipeline) {
  if (pipeline->ended_ || pipeline->pipeline_.is_lost()) return;
  pipeline->pipeline_->stop("abandoned");
  if (is_ending()) {
    pipeline->is_left_ = true;
    static_cast<void>(pipeline.release());  // end_all has it
  } else if (pipeline->is_own_thread()) {
    end_elsewhere(std::move(pipeline));
  } else {
    pipeline->end();
  }
}

// The program does not end before, because the thread counts as work in progress. Whoever gets Python's lock first ends the
// pipeline: after end_all there may be none any more.
void PythonPipeline::end_elsewhere(std::unique_ptr<PythonPipeline> pipeline) {
  pipeline->is_left_ = true;
  PythonPipeline* const left = pipeline.release();
  try {
    std::thread([left, in_progress = std::make_unique<WorkInProgress>()] {
      const py::gil_scoped_acquire lock;
      if (going().contains(left)) drop(std::unique_ptr<PythonPipeline>(left));
    }).detach();
  } catch (const std::system_error&) {  // there are no more threads: end_all has it
  }
}

// Threads of the pipeline may wait for Python's lock, so it is given away.
void PythonPipeline::end() {
  OnlinePipeline& pipeline = *pipeline_;
  ended_ = true;
  going().erase(this);
  report_ = released([&] { return pipeline.finish(); });
  mapper_->finished = true;
  give_back_parts();
  in_progress_.reset();
}

void PythonPipeline::end_all() {
  while (!going().empty()) {
    PythonPipeline& pipeline = **going().begin();
    const std::unique_ptr<PythonPipeline> owner(pipeline.is_left_ ? &pipeline : nullptr);
    const py::object kept_meanwhile = owner ? py::none() : py::cast(&pipeline);  // whoever has it may let go of it
    pipeline.pipeline_->stop("the program ended");
    pipeline.end();
  }
}

void PythonPipeline::require_going() const {
  if (ended_) throw Error("the pipeline is finished: nothing can be pushed any more");
}

bool PythonPipeline::push(const py::object& frame, const FrameArrays& arrays, bool wait) {
  require_going();
  const GivenFrame given(frame, mapper_->numbered(arrays));
  mapper_->next_index = (*given).index + 1;
  // Pixels that Python lent are copied there: whoever pushed may use his memory again.
  return released([&] { return wait ? pipeline_->push_when_free(*given) : pipeline_->push(*given); });
}

void PythonPipeline::skip(std::int64_t index, const std::string& reason) {
  require_going();
  released([&] { pipeline_->skip({index, reason}); });
}

std::string message_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "an unknown failure";
  }
}

py::dict PythonPipeline::finish() {
  const Use use(ending_, "another finish");
  if (!ended_ && is_own_thread()) throw Error("a predictor cannot finish the pipeline that waits for it: call stop");
  if (!ended_) {
    end();
    if (seeing_ != nullptr) warn(seeing_->take_warnings());
  }
  if (report_.failure) {
    const auto* python = dynamic_cast<PythonPredictor*>(seeing_);
    py::object error = py::module_::import("panoptic").attr("Error")(message_of(report_.failure));
    if (python != nullptr && !python->raised().is_none()) error.attr("__cause__") = python->raised();
    PyErr_SetObject(py::type::handle_of(error).ptr(), error.ptr());
    throw py::error_already_set();
  }
  py::dict answer;
  answer["read"] = report_.read;
  answer["used"] = report_.used;
  answer["skipped"] = report_.skipped;
  answer["dropped"] = report_.dropped;
  answer["lost"] = report_.lost;
  answer["labelled"] = report_.labelled;
  answer["passed_over"] = report_.passed_over;
  answer["geometry_hz"] = report_.geometry_hz;
  answer["label_hz"] = report_.label_hz;
  answer["latency"] = stage_times(report_.latency);
  answer["stopped_by"] = report_.stopped_by;
  return answer;
}

}  // namespace panoptic::python
