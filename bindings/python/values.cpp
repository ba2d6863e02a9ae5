// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/values.h"

#include <fmt/format.h>

namespace panoptic::python {
namespace {

std::string list_text(const py::sequence& list, const std::string& name) {
  const Level level;
  std::string text = "[";
  for (const py::handle element : list) text += (text.size() > 1 ? ", " : "") + toml_value(element, name);
  return text + "]";
}

}  // namespace

std::string toml_value(const py::handle& value, const std::string& name) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::int_>(value)) return py::str(value);
  if (py::isinstance<py::float_>(value)) return py::repr(value);
  if (py::isinstance<py::str>(value)) {  // JSON's escapes are TOML's too
    return py::str(py::module_::import("json").attr("dumps")(value, py::arg("ensure_ascii") = false));
  }
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    return list_text(py::reinterpret_borrow<py::sequence>(value), name);
  }
  if (py::hasattr(value, "__fspath__")) return toml_value(value.attr("__fspath__")(), name);
  if (py::hasattr(value, "item")) return toml_value(value.attr("item")(), name);  // a number of NumPy
  throw Error(fmt::format("{}: {} is no value for an option; it may be a bool, a number, a text or a list of texts", name,
                          std::string(py::repr(value))));
}

}  // namespace panoptic::python
