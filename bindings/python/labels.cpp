// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

namespace panoptic::python {
namespace {

using Color = std::array<std::uint8_t, 3>;

LabelClass make_class(std::int64_t id, std::string name, bool is_thing, const Color& color, double max_size_m, bool is_support,
                      bool is_mobile) {
  constexpr std::int64_t kHighest = 999;
  if (id < 1 || id > kHighest) throw Error(fmt::format("class '{}' has the number {}: from 1 to {}", name, id, kHighest));
  return {static_cast<ClassId>(id), std::move(name), is_thing, {color[0], color[1], color[2]}, max_size_m, is_support, is_mobile};
}

// Queries say so of an object that has no known class.
bool is_unknown(const py::object& class_) { return !py::isinstance<py::str>(class_) && class_.equal(py::int_(0)); }

}  // namespace

LabelSet labels_from(const py::handle& object, const std::string& otherwise) {
  if (object.is_none()) return load_label_set(otherwise);
  if (py::isinstance<LabelSet>(object)) return object.cast<LabelSet>();
  if (py::isinstance<py::str>(object) || py::hasattr(object, "__fspath__")) return load_label_set(py::str(object));
  throw Error("labels must be a LabelSet, the name of one (\"indoor\") or the path of a TOML file");
}

ClassId class_from(const py::handle& object, const LabelSet* labels) {
  if (py::isinstance<py::str>(object)) {
    const std::string name = py::str(object);
    if (labels == nullptr)
      throw Error(fmt::format("class '{}': names need a label set; give labels=..., or the class's number", name));
    const LabelClass* found = labels->find(name);
    if (found == nullptr) throw Error(fmt::format("there is no class '{}' in the label set '{}'", name, labels->name()));
    return found->id;
  }
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(object.ptr()));
  if (!index) PyErr_Clear();
  const std::int64_t id = index ? PyLong_AsLongLong(index.ptr()) : -1;
  if (PyErr_Occurred() != nullptr) PyErr_Clear();  // too large: -1 is no class
  if (!index) throw Error(fmt::format("{} is no class: give its name or its number", std::string(py::repr(object))));
  return class_numbered(id, labels);
}

bool same_classes(const LabelSet& a, const LabelSet& b) {
  return std::ranges::equal(a.classes(), b.classes(), [](const LabelClass& x, const LabelClass& y) {
    return x.id == y.id && x.name == y.name && x.is_thing == y.is_thing;
  });
}

ClassId class_numbered(std::int64_t id, const LabelSet* labels) {
  const bool fits = id > 0 && id < number(LabelSlot::kNoVote);
  if (!fits || (labels != nullptr && labels->find(static_cast<ClassId>(id)) == nullptr)) {
    throw Error(fmt::format("there is no class with the number {}{}", id,
                            labels != nullptr ? fmt::format(" in the label set '{}'", labels->name()) : ""));
  }
  return static_cast<ClassId>(id);
}

void bind_labels(py::module_& m) {
  py::class_<LabelClass>(m, "LabelClass", "A class of a label set. max_size_m: nothing of it is longer, in metres; 0: no limit.")
      .def(py::init(&make_class), py::arg("id"), py::arg("name"), py::arg("is_thing") = true,
           py::arg("color") = Color{128, 128, 128}, py::arg("max_size_m") = 0.0, py::arg("is_support") = false,
           py::arg("is_mobile") = false)
      .def_property_readonly("id", [](const LabelClass& c) { return number(c.id); })
      .def_readonly("name", &LabelClass::name)
      .def_readonly("is_thing", &LabelClass::is_thing)
      .def_property_readonly("color", [](const LabelClass& c) { return py::make_tuple(c.color.r, c.color.g, c.color.b); })
      .def_readonly("max_size_m", &LabelClass::max_size_m)
      .def_readonly("is_support", &LabelClass::is_support)
      .def_readonly("is_mobile", &LabelClass::is_mobile)
      .def("__repr__", [](const LabelClass& c) { return fmt::format("<LabelClass {} {}>", number(c.id), c.name); });

  py::class_<LabelSet>(m, "LabelSet", R"(The classes of a map: LabelSet("indoor"), LabelSet("my_labels.toml") or
LabelSet("mine", [LabelClass(1, "wall", is_thing=False), LabelClass(2, "chair")]). Class numbers go from 1 to 999.)")
      .def(py::init([](const py::object& name, const std::optional<std::vector<LabelClass>>& classes) {
             return classes ? LabelSet(py::str(name), *classes) : labels_from(name, "indoor");
           }),
           py::arg("name"), py::arg("classes") = py::none())
      .def_property_readonly("name", &LabelSet::name)
      .def_property_readonly("classes", &LabelSet::classes)
      .def("__len__", [](const LabelSet& l) { return l.classes().size(); })
      .def(
          "id_of", [](const LabelSet& l, const std::string& name) { return number(class_from(py::str(name), &l)); },
          py::arg("name"))
      .def(
          "name_of",
          [](const LabelSet& l, std::int64_t id) { return id == 0 ? "unknown" : std::string(l.name_of(class_numbered(id, &l))); },
          py::arg("id"))
      .def(
          "is_thing", [](const LabelSet& l, const py::object& c) { return !is_unknown(c) && l.is_thing(class_from(c, &l)); },
          py::arg("class_"), "False for 0, the unknown class.")
      .def(
          "color_of",
          [](const LabelSet& l, std::uint32_t id) {
            const Rgb c = color_of(static_cast<PanopticId>(id), l);
            return py::make_tuple(c.r, c.g, c.b);
          },
          py::arg("panoptic_id"), "The colour that pictures of the map give to a panoptic id.")
      .def("__repr__",
           [](const LabelSet& l) { return fmt::format("<LabelSet '{}' of {} classes>", l.name(), l.classes().size()); });
}

}  // namespace panoptic::python
