// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bindings/python/bind.h"
#include "panoptic/predictor.h"

namespace panoptic::python {

// Any predictor, for Python.
struct SharedPredictor : Predictor {
  Exclusive use{"predictor"};
};

// One of the library's.
class LibraryPredictor : public SharedPredictor {
 public:
  // Networks have threads; predictions on disk have none, and are read in a child of fork too.
  LibraryPredictor(std::unique_ptr<Predictor> predictor, bool has_threads)
      : labels_(predictor->labels()), predictor_(std::move(predictor), has_threads) {}

  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override { return predictor_->predict(frame); }
  std::optional<PredictorHalves> halves() override { return predictor_->halves(); }
  std::vector<std::string> take_warnings() override { return predictor_->take_warnings(); }
  PredictorReport report() const override { return predictor_->report(); }

 private:
  LabelSet labels_;
  WithThreads<Predictor> predictor_;
};

// A predictor that is written in Python. What its predict raises ends the work that called it with an Error, and is kept.
class PythonPredictor : public SharedPredictor {
 public:
  explicit PythonPredictor(LabelSet labels) : labels_(std::move(labels)) {}

  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override;  // takes Python's lock

  // The exception that predict raised in another thread; None if it raised none.
  const py::object& raised() const { return raised_; }

  // This thread is in a call of `predict` that a pipeline made.
  bool is_predicting_here() const { return predicting_in_ == std::this_thread::get_id(); }

 private:
  // The answer of Python's predict. REQUIRES Python's lock.
  Segmentation answer(const Frame& frame) const;

  LabelSet labels_;
  py::object raised_ = py::none();
  std::thread::id predicting_in_;  // guarded by Python's lock
};

}  // namespace panoptic::python
