// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The extension module panoptic._core; what users import is the package around it.
#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <string>

#include "bindings/python/bind.h"

namespace panoptic::python {
namespace {

// pybind11 asks for memory when it is handed an object whose __init__ never ran, as Mapper.__new__(Mapper) gives one, and would
// take what lies there for the object.
void* refuse_unmade(std::size_t /*bytes*/) { throw Error("the object was not made: __init__ of its class was never called"); }

void require_init(const py::module_& m) {
  for (const auto& [name, value] : py::dict(m.attr("__dict__"))) {
    if (!PyType_Check(value.ptr())) continue;
    auto* type = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr()));
    if (type != nullptr) type->operator_new = &refuse_unmade;
  }
}

// Names of files in a message may be bytes that are no UTF-8.
void raise(const py::handle& type, const std::string& message) {
  const auto text = py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(message.data(), static_cast<py::ssize_t>(message.size()), "backslashreplace"));
  if (text) PyErr_SetObject(type.ptr(), text.ptr());
}

}  // namespace
}  // namespace panoptic::python

PYBIND11_MODULE(_core, m) {
  using namespace panoptic::python;
  m.doc() = "Online volumetric panoptic mapping. Metres; camera axes x right, y down, z forward; docs/python.md.";
  static const py::handle error = py::register_exception<panoptic::Error>(m, "Error", PyExc_RuntimeError);
  error.doc() = "One line: what is wrong, where, what to do.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const panoptic::Error& e) {
      raise(error, e.what());
    } catch (const std::filesystem::filesystem_error& e) {
      raise(error, fmt::format("{}: {}", e.path1().string(), e.code().message()));
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
  bind_poses(m);
  bind_planning(m);
  bind_distances(m);
  bind_navigation(m);
  bind_home_plan(m);
  bind_tracking(m);
  require_init(m);
}
