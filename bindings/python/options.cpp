// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/options.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>

#include "bindings/python/bind.h"
#include "bindings/python/values.h"
#include "panoptic/run_outputs.h"

namespace panoptic::python {
namespace {

void set(Options& options, const std::string& name, const py::handle& value) {
  set_option(options, fmt::format("{}={}", name, toml_value(value, name)));
}

void require_no_group(const Options& options, const std::string& name) {
  const std::string heading = fmt::format("\n[{}]\n", name);
  if (to_toml(options).find(heading) != std::string::npos)
    throw Error(fmt::format("'{}' is a group of options: give a dict, as {}=dict(...)", name, name));
}

// A group of options is a dict, or another one inside: map=dict(voxel_size_m=0.05).
void set_all(Options& options, const std::string& prefix, const py::dict& values) {
  const Level level;
  for (const auto& [key, value] : values) {
    const std::string name = prefix + std::string(py::str(key));
    if (py::isinstance<py::dict>(value)) {
      set_all(options, name + ".", py::reinterpret_borrow<py::dict>(value));
    } else {
      require_no_group(options, name);
      set(options, name, value);
    }
  }
}

Options make(const std::string& preset, const std::optional<std::filesystem::path>& file, const py::kwargs& groups) {
  if (file && preset != kDefaultPreset) throw Error("options come from a preset or from a file, not from both");
  Options options = file ? load_options(*file) : preset_options(preset);
  set_all(options, "", groups);
  return options;
}

py::dict as_dict(const Options& options) { return py::module_::import("tomllib").attr("loads")(to_toml(options)); }

py::object at(const Options& options, const std::string& name) {
  py::object value = as_dict(options);
  std::string_view rest = name;
  for (bool more = true; more;) {
    const std::size_t dot = rest.find('.');
    const py::str key{std::string(rest.substr(0, dot))};
    if (!py::isinstance<py::dict>(value) || !value.contains(key))
      throw py::key_error(fmt::format("there is no option '{}'", name));
    value = value[key];
    more = dot != std::string_view::npos;
    if (more) rest.remove_prefix(dot + 1);
  }
  return value;
}

}  // namespace

void bind_options(py::module_& m) {
  py::class_<Options>(m, "Options", R"(Every option of the mapper, by the names that `panoptic options` lists.

Options(preset="paper"), Options(file="options.toml"), Options(map={"voxel_size_m": 0.05}); a group of options is a dict.
Lengths are in metres, times in seconds. A name or value that there is not raises Error and says what there is.)")
      .def(py::init(&make), py::kw_only(), py::arg("preset") = kDefaultPreset, py::arg("file") = py::none())
      .def("set", &set, py::arg("name"), py::arg("value"), R"(Sets one option: options.set("map.voxel_size_m", 0.05).)")
      .def("__setitem__", &set, py::arg("name"), py::arg("value"))
      .def("__getitem__", &at, py::arg("name"), R"(The value of options["map.voxel_size_m"], or the dict of options["map"].)")
      .def("as_dict", &as_dict, "All options as nested dicts; Options(**options.as_dict()) has the same.")
      .def("toml", py::overload_cast<const Options&>(&to_toml), "All options as TOML with a line of help before each.")
      .def(
          "__eq__", [](const Options& a, const Options& b) { return to_toml(a) == to_toml(b); }, py::is_operator())
      .def("__copy__", [](const Options& o) { return Options(o); })
      .def(
          "__deepcopy__", [](const Options& o, const py::dict&) { return Options(o); }, py::arg("memo"));
}

}  // namespace panoptic::python
