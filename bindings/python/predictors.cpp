// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/predictors.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "bindings/python/labels.h"
#include "bindings/python/segments.h"
#include "panoptic/source.h"

namespace panoptic::python {
namespace {

// One of ours, for Python: predict runs without its lock.
Segmentation predict(SharedPredictor& predictor, const Frame& frame) {
  if (dynamic_cast<PythonPredictor*>(&predictor) != nullptr) {
    throw Error("the predictor has no function predict(self, frame)");
  }
  const Use use(predictor.use);
  Segmentation seen = released([&] { return predictor.predict(frame); });
  warn(predictor.take_warnings());
  return seen;
}

py::dict report(SharedPredictor& predictor) {
  const Use use(predictor.use);
  const PredictorReport report = predictor.report();
  return py::dict(py::arg("notes") = report.notes, py::arg("trouble") = report.trouble);
}

std::shared_ptr<SharedPredictor> shared(std::unique_ptr<Predictor> predictor, bool has_threads) {
  return predictor != nullptr ? std::make_shared<LibraryPredictor>(std::move(predictor), has_threads) : nullptr;
}

std::shared_ptr<SharedPredictor> from_options(const Options& options, const Dataset* dataset) {
  const bool names_networks = !options.networks.semantic.empty() || !options.networks.instance.empty();
  const bool of_networks = options.predictions.empty() && names_networks;
  made_networks = made_networks || of_networks;
  const auto make = [&] { return dataset != nullptr ? make_predictor(options, *dataset) : make_predictor(options); };
  return shared(released(make), of_networks);
}

std::shared_ptr<SharedPredictor> from_files(const std::filesystem::path& path, const py::object& labels,
                                            bool keep_whole_classes) {
  std::optional<LabelSet> set;
  if (!labels.is_none()) set = labels_from(labels, "");
  return shared(released([&] { return make_file_predictor(path, set, keep_whole_classes); }), false);
}

}  // namespace

Segmentation PythonPredictor::predict(const Frame& frame) {
  const py::gil_scoped_acquire lock;
  predicting_in_ = std::this_thread::get_id();
  try {
    Segmentation seen = answer(frame);
    predicting_in_ = {};
    return seen;
  } catch (py::error_already_set& e) {
    predicting_in_ = {};
    if (e.trace()) PyException_SetTraceback(e.value().ptr(), e.trace().ptr());
    raised_ = e.value();
    throw Error(fmt::format("the predictor raised {}: {}", std::string(py::str(e.type().attr("__name__"))),
                            std::string(py::str(e.value()))));
  } catch (...) {
    predicting_in_ = {};
    throw;
  }
}

Segmentation PythonPredictor::answer(const Frame& frame) const {
  const py::function function = py::get_override(static_cast<const SharedPredictor*>(this), "predict");
  if (!function) throw Error("the predictor has no function predict(self, frame)");
  // Whoever predicts may keep it.
  const std::shared_ptr<const Segmentation> seen = segmentation_from(function(std::make_shared<Frame>(kept(frame))), labels_);
  require_sound(*seen, labels_);
  const Outcome outcome = check(*seen, frame.color.width(), frame.color.height());
  if (!outcome.used) throw Error("the predictor's " + outcome.reason);
  return *seen;
}

void bind_predictors(py::module_& m) {
  py::class_<SharedPredictor, PythonPredictor, std::shared_ptr<SharedPredictor>>(m, "Predictor", R"(From a frame to what is in it.

Write your own: derive from it, call super().__init__(labels), and define predict(self, frame), which returns a Segmentation of the
size of frame.color, or None for a frame without a prediction. One call at a time is made.)")
      .def(py::init([](const py::object& labels) { return new PythonPredictor(labels_from(labels, "indoor")); }),
           py::arg("labels") = "indoor")
      .def_property_readonly(
          "labels", [](const SharedPredictor& p) { return p.labels(); }, "The classes that segments refer to.")
      .def("predict", &predict, py::arg("frame"))
      .def("report", &report, "How predicting went: notes, a line each, and trouble, why it was of no use (empty if it was).");

  m.def(
      "make_predictor", &from_options, py::arg("options"), py::arg("dataset") = py::none(),
      R"(The predictor that the options name: a folder of predictions, else networks, else what a list of recordings names for each, if
`dataset` is one, else None.)");
  m.def(
      "file_predictor", &from_files, py::arg("path"), py::arg("labels") = py::none(), py::arg("keep_whole_classes") = true,
      R"(Reads predictions that were made before: a folder of `panoptic predict`, or COCO panoptic. Frames are found by their number.)");
}

}  // namespace panoptic::python
