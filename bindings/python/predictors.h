// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>

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
  explicit LibraryPredictor(std::unique_ptr<Predictor> predictor) : predictor_(std::move(predictor)) {}

  const LabelSet& labels() const override { return predictor_->labels(); }
  Segmentation predict(const Frame& frame) override { return predictor_->predict(frame); }
  std::optional<PredictorHalves> halves() override { return predictor_->halves(); }

 private:
  std::unique_ptr<Predictor> predictor_;
};

// A predictor that is written in Python. What its predict raises ends the work that called it with an Error, and is kept.
class PythonPredictor : public SharedPredictor {
 public:
  explicit PythonPredictor(LabelSet labels) : labels_(std::move(labels)) {}

  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override;  // takes Python's lock

  // The exception that predict raised in another thread; None if it raised none.
  const py::object& raised() const { return raised_; }

 private:
  LabelSet labels_;
  py::object raised_ = py::none();
};

}  // namespace panoptic::python
