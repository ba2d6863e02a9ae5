// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The extension module panoptic._core; what users import is the package around it.
#include <fmt/format.h>

#include <exception>
#include <filesystem>

#include "bindings/python/bind.h"

PYBIND11_MODULE(_core, m) {
  using namespace panoptic::python;
  m.doc() = "Online volumetric panoptic mapping. Metres; camera axes x right, y down, z forward; docs/python.md.";
  static const py::handle error = py::register_exception<panoptic::Error>(m, "Error", PyExc_RuntimeError);
  error.doc() = "One line: what is wrong, where, what to do.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const std::filesystem::filesystem_error& e) {
      PyErr_SetString(error.ptr(), fmt::format("{}: {}", e.path1().string(), e.code().message()).c_str());
    }
  });
  bind_labels(m);
  bind_options(m);
  bind_frames(m);
  bind_segments(m);
  bind_sources(m);
  bind_predictors(m);
  bind_mesh(m);
  bind_map(m);
  bind_mapper(m);
  bind_online(m);
  bind_scores(m);
  bind_tools(m);
}
