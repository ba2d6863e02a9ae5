// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Scores of maps, or of any method's labels, against annotated scans.
#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/map.h"
#include "panoptic/evaluation.h"
#include "panoptic/surface.h"

namespace panoptic::python {
namespace {

namespace fs = std::filesystem;

// Counts over scenes, and who uses them.
struct Scorer {
  explicit Scorer(const std::string& variant) : evaluation(variant) {}

  Evaluation evaluation;
  Exclusive use{"evaluation"};
};

fs::path folder_from(const py::object& object, const char* kind, const char* folder) {
  try {
    return object.cast<fs::path>();
  } catch (const py::cast_error&) {
    throw Error(fmt::format("{} is neither a {} nor the folder of {}", std::string(py::repr(object)), kind, folder));
  }
}

LabelledMap labelled(const py::object& what, std::vector<std::string>& warnings) {
  if (!py::isinstance<MapView>(what)) {
    const fs::path folder = folder_from(what, "Map", "a run");
    return released([&] { return read_run_folder(folder, &warnings); });
  }
  const MapView& view = *what.cast<std::shared_ptr<MapView>>();
  const Use use(*view.use);
  return released([&] { return labelled_map(view.map, surface_of(view.map, view.options.mesher), &warnings); });
}

std::shared_ptr<const ScanTruth> truth_of(const fs::path& folder, const fs::path& category_map,
                                          std::vector<std::string>& warnings) {
  return released([&] { return std::make_shared<ScanTruth>(read_scan_truth(folder, category_map, &warnings)); });
}

std::shared_ptr<ScanTruth> read_truth(const fs::path& folder, const std::optional<fs::path>& category_map) {
  std::vector<std::string> warnings;
  const auto truth = std::const_pointer_cast<ScanTruth>(truth_of(folder, category_map.value_or(fs::path()), warnings));
  warn(warnings);
  return truth;
}

void add(Scorer& self, const py::object& map, const py::object& truth, const std::optional<fs::path>& category_map) {
  const Use use(self.use);
  std::vector<std::string> warnings;
  const LabelledMap seen = labelled(map, warnings);
  const auto scan = py::isinstance<ScanTruth>(truth) ? truth.cast<std::shared_ptr<ScanTruth>>()
                                                     : truth_of(folder_from(truth, "ScanTruth", "an annotated scan"),
                                                                category_map.value_or(fs::path()), warnings);
  released([&] { self.evaluation.add(seen, *scan); });
  warn(warnings);
}

// Whole numbers from 0 to what T holds, one per vertex. Throws Error.
template <typename T>
std::vector<T> vertex_numbers(const py::handle& object, const char* what) {
  const py::array array = array_of(object, what);
  const char kind = array.dtype().kind();
  if (array.ndim() != 1 || (kind != 'i' && kind != 'u'))
    throw Error(fmt::format("{} is {}: it must hold a whole number for each vertex", what, text_of(array)));
  const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> wide(array);
  std::vector<T> list;
  list.reserve(static_cast<std::size_t>(wide.size()));
  for (py::ssize_t i = 0; i < wide.size(); ++i) {
    const std::int64_t value = wide.data()[i];
    if (value < 0 || value > static_cast<std::int64_t>(std::numeric_limits<T>::max()))
      throw Error(
          fmt::format("{} holds {} at vertex {}: it must be from 0 to {}", what, value, i, std::numeric_limits<T>::max()));
    list.push_back(static_cast<T>(value));
  }
  return list;
}

void add_labels(Scorer& self, const py::object& class_id, const py::object& instance, const ScanTruth& truth,
                const std::map<std::uint32_t, double>& confidence) {
  const Use use(self.use);
  LabelledVertices prediction;
  for (const std::uint16_t id : vertex_numbers<std::uint16_t>(class_id, "class_id")) {
    prediction.labels.class_id.push_back(static_cast<ClassId>(id));
  }
  prediction.labels.instance = vertex_numbers<std::uint32_t>(instance, "instance");
  prediction.confidence = confidence;
  released([&] { self.evaluation.add(prediction, truth); });
}

py::object scores(const Scorer& self) {
  return py::module_::import("json").attr("loads")(to_json_text(self.evaluation.scores()));
}

py::object evaluate(const py::object& map, const py::object& truth, const std::string& variant,
                    const std::optional<fs::path>& category_map) {
  Scorer scorer(variant);
  add(scorer, map, truth, category_map);
  return scores(scorer);
}

void bind_truth(py::module_& m) {
  py::class_<ScanTruth, std::shared_ptr<ScanTruth>>(m, "ScanTruth", R"(The annotated mesh of a scan, in ScanNet's form.

The arrays are views that cannot be written to.)")
      .def_readonly("scene", &ScanTruth::scene)
      .def_property_readonly(
          "positions",
          [](const py::object& self) {
            const auto& positions = self.cast<const ScanTruth&>().positions;
            constexpr py::ssize_t kNumber = sizeof(float);
            const float* first = positions.empty() ? nullptr : positions.front().data();
            return view(first, {static_cast<py::ssize_t>(positions.size()), 3}, {3 * kNumber, kNumber}, self);
          },
          "(V, 3) float32, metres.")
      .def_property_readonly(
          "colors",
          [](const py::object& self) {
            const auto& colors = self.cast<const ScanTruth&>().colors;
            const std::uint8_t* first = colors.empty() ? nullptr : &colors.front().r;
            return view(first, {static_cast<py::ssize_t>(colors.size()), 3}, {py::ssize_t{sizeof(Rgb)}, 1}, self);
          },
          "(V, 3) uint8, red first.")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) {
            const auto& triangles = self.cast<const ScanTruth&>().triangles;
            constexpr py::ssize_t kIndex = sizeof(std::uint32_t);
            const std::uint32_t* first = triangles.empty() ? nullptr : triangles.front().data();
            return view(first, {static_cast<py::ssize_t>(triangles.size()), 3}, {3 * kIndex, kIndex}, self);
          },
          "(T, 3) uint32.")
      .def_property_readonly(
          "class_id",
          [](const py::object& self) {
            const auto& ids = self.cast<const ScanTruth&>().class_id;
            const auto* first = reinterpret_cast<const std::uint16_t*>(ids.data());
            return view(first, {static_cast<py::ssize_t>(ids.size())}, {py::ssize_t{sizeof(ClassId)}}, self);
          },
          "(V,) uint16, NYU40 numbers, 0 = not annotated.")
      .def_property_readonly(
          "instance",
          [](const py::object& self) {
            const auto& ids = self.cast<const ScanTruth&>().instance;
            return view(ids.data(), {static_cast<py::ssize_t>(ids.size())}, {py::ssize_t{sizeof(ids.front())}}, self);
          },
          "(V,) uint16, from 1; 0 = none.")
      .def_readonly("names", &ScanTruth::names, "The raw label of each instance.")
      .def("__repr__", [](const ScanTruth& t) {
        return fmt::format("<ScanTruth {} of {} vertices and {} instances>", t.scene, t.positions.size(), t.names.size());
      });
  m.def("read_scan_truth", &read_truth, py::arg("folder"), py::arg("category_map") = py::none(),
        "Reads an annotated scan in ScanNet's form; category_map: its TSV of labels, where it does not lie beside it.");
}

}  // namespace

void bind_scores(py::module_& m) {
  bind_truth(m);
  py::class_<Scorer>(m, "Evaluation", R"(Scores over several scenes, as the benchmarks take them: counts are summed, then divided.

Evaluation(variant="pq-scannet20"): add scenes, then read scores. docs/evaluation.md has the variants.)")
      .def(py::init<const std::string&>(), py::arg("variant") = "pq-scannet20")
      .def("add", &add, py::arg("map"), py::arg("truth"), py::kw_only(), py::arg("category_map") = py::none(),
           "Adds a scene: a Map or the folder of a run, and a ScanTruth or the folder of an annotated scan.")
      .def(
          "add_labels", &add_labels, py::arg("class_id"), py::arg("instance"), py::arg("truth"), py::kw_only(),
          py::arg("confidence") = py::dict(),
          R"(Adds any method's labels for the vertices of a ScanTruth: class_id (V,) NYU40 numbers, instance (V,) numbers, 0 = none.

confidence: {instance: 0 to 1}; 1 where it says nothing.)")
      .def(
          "scores",
          [](Scorer& self) {
            const Use use(self.use);
            return scores(self);
          },
          "A dict as `panoptic eval --json` writes: fractions from 0 to 1, None where nothing is defined.")
      .def(
          "table",
          [](Scorer& self) {
            const Use use(self.use);
            return to_table(self.evaluation.scores());
          },
          "The same for a person.");
  m.def(
      "evaluate", &evaluate, py::arg("map"), py::arg("truth"), py::kw_only(), py::arg("variant") = "pq-scannet20",
      py::arg("category_map") = py::none(),
      R"(Scores a Map, or the folder of a run, against an annotated scan in ScanNet's form: a dict as `panoptic eval --json` writes.)");
}

}  // namespace panoptic::python
