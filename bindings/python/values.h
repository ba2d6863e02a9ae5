// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Values of Python as the texts that the library's lists of options take.
#pragma once

#include <pybind11/stl/filesystem.h>

#include <string>

#include "bindings/python/bind.h"

namespace panoptic::python {

// Levels of dicts and lists in one another are counted, because one may hold itself: throws RecursionError as Python does.
class Level {
 public:
  Level() {
    if (Py_EnterRecursiveCall(" in an option") != 0) throw py::error_already_set();
  }
  ~Level() { Py_LeaveRecursiveCall(); }
  Level(const Level&) = delete;
  Level& operator=(const Level&) = delete;
};

// A bool, number, text, path or list of these as TOML. `name`: of the option, for the message. Throws Error.
std::string toml_value(const py::handle& value, const std::string& name);

}  // namespace panoptic::python
