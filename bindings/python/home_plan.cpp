// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/home_plan.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/objects.h"
#include "bindings/python/planning.h"

namespace panoptic::python {
namespace {

// A plan with the classes that it names.
struct PythonPlan {
  HomePlan plan;
  LabelSet labels;
};

std::shared_ptr<PythonPlan> make(const MapView& view, const std::optional<UpFrame>& frame) {
  const Use use(*view.use);
  const UpFrame chosen = frame_or_own(view, frame);
  return std::make_shared<PythonPlan>(
      PythonPlan{released([&] { return plan_home(view.map, chosen.grid_from_world); }), view.map.labels});
}

void save(const PythonPlan& self, const std::filesystem::path& folder) {
  released([&] {
    std::filesystem::create_directories(folder);
    write_home_plan(self.plan, self.labels, folder);
  });
}

py::array flat(const Eigen::Vector2d& vector) { return py::array_t<double>(2, vector.data()); }

// A list with a dict for each.
template <typename Thing, typename ToDict>
py::list listed(const std::vector<Thing>& things, const ToDict& to_dict) {
  py::list list;
  for (const Thing& thing : things) list.append(to_dict(thing));
  return list;
}

py::dict seat(const Seat& s) {
  return py::dict(py::arg("position") = vector_of(s.position), py::arg("normal") = vector_of(s.normal),
                  py::arg("facing") = vector_of(s.facing), py::arg("height_m") = s.height_m, py::arg("has_back") = s.has_back,
                  py::arg("object") = id_or_none(s.object));
}

py::dict lying_place(const LyingPlace& p) {
  return py::dict(py::arg("polygon") = rows_of(p.polygon), py::arg("center") = vector_of(p.center),
                  py::arg("axis") = vector_of(p.axis), py::arg("length_m") = p.length_m, py::arg("width_m") = p.width_m,
                  py::arg("height_m") = p.height_m, py::arg("object") = id_or_none(p.object));
}

py::dict table_top(const TableTop& t) {
  const py::list rectangles = listed(t.free_rectangles, [](const std::vector<Vec3d>& corners) { return rows_of(corners); });
  return py::dict(py::arg("polygon") = rows_of(t.polygon), py::arg("free_rectangles") = rectangles,
                  py::arg("height_m") = t.height_m, py::arg("area_m2") = t.area_m2, py::arg("object") = id_or_none(t.object));
}

py::dict door(const Opening& d) {
  py::dict entry(py::arg("center") = vector_of(d.center), py::arg("along") = vector_of(d.along), py::arg("width_m") = d.width_m,
                 py::arg("height_m") = d.height_m, py::arg("wall_m") = d.wall_m, py::arg("is_open") = d.is_open,
                 py::arg("rooms") = d.rooms, py::arg("object") = id_or_none(d.leaf));
  entry["leaf_line"] = rows_of(d.leaf_line);
  return entry;
}

py::dict room(const MappedRoom& r) {
  py::list objects;
  for (const PanopticId id : r.objects) objects.append(number(id));
  return py::dict(py::arg("id") = r.id, py::arg("class_name") = r.class_name, py::arg("polygon") = rows_of(r.polygon),
                  py::arg("area_m2") = r.area_m2, py::arg("objects") = objects, py::arg("doors") = r.doors);
}

py::dict wall(const WallLine& w) {
  return py::dict(py::arg("start") = flat(w.from), py::arg("end") = flat(w.to), py::arg("normal") = flat(w.normal));
}

py::list footprints(const PythonPlan& self) {
  return listed(self.plan.furniture, [&](const ThingFootprint& f) {
    return py::dict(py::arg("object") = id_or_none(f.object), py::arg("class_id") = number(f.class_id),
                    py::arg("class_name") = std::string(self.labels.name_of(f.class_id)), py::arg("polygon") = rows_of(f.polygon),
                    py::arg("low_m") = f.low_m, py::arg("high_m") = f.high_m);
  });
}

}  // namespace

void bind_home_plan(py::module_& m) {
  py::class_<PythonPlan, std::shared_ptr<PythonPlan>>(m, "HomePlan",
                                                      R"(A mapped home for those who live in it, in the grid frame. Metres.

Lists of dicts; `object` is a MapObject.id, or None. docs/home_plan.md has the rules.)")
      .def_property_readonly(
          "seats", [](const PythonPlan& p) { return listed(p.plan.seats, &seat); },
          "Places to sit: position, normal and facing (3,), height_m above the floor, has_back, object.")
      .def_property_readonly(
          "lying_places", [](const PythonPlan& p) { return listed(p.plan.lying_places, &lying_place); },
          "polygon (N, 3), center and axis (3,), length_m, width_m, height_m, object.")
      .def_property_readonly(
          "table_tops", [](const PythonPlan& p) { return listed(p.plan.table_tops, &table_top); },
          "polygon (N, 3), free_rectangles (a list of (4, 3), the largest first), height_m, area_m2, object.")
      .def_property_readonly(
          "doors", [](const PythonPlan& p) { return listed(p.plan.doors, &door); },
          R"(center (3,) on the floor, along (3,) the wall, width_m, height_m, wall_m (its thickness), is_open, rooms (ids), object (its leaf),
leaf_line (2, 2).)")
      .def_property_readonly(
          "rooms", [](const PythonPlan& p) { return listed(p.plan.rooms, &room); },
          "id, class_name, polygon (N, 2), area_m2, objects (ids), doors (places in `doors`).")
      .def_property_readonly(
          "walls", [](const PythonPlan& p) { return listed(p.plan.walls, &wall); }, "start, end and normal (2,), into the room.")
      .def_property_readonly("furniture", &footprints,
                             "object, class_id, class_name, polygon (N, 2), low_m and high_m above the floor.")
      .def_property_readonly(
          "grid_from_world", [](const PythonPlan& p) { return matrix_of(p.plan.grid_from_world); }, "(4, 4) float64.")
      .def(
          "svg", [](const PythonPlan& p) { return released([&] { return floor_plan_svg(p.plan, p.labels); }); },
          "The plan as architects draw it.")
      .def("save", &save, py::arg("folder"), "Writes affordances.json, rooms.json and floorplan.svg.")
      .def("__repr__", [](const PythonPlan& p) {
        return fmt::format("<HomePlan of {} rooms, {} doors and {} seats>", p.plan.rooms.size(), p.plan.doors.size(),
                           p.plan.seats.size());
      });
  m.def("plan_home", &make, py::arg("map"), py::arg("frame") = py::none(),
        "Seats, places to lie, table tops, doors, rooms and walls of a map: a HomePlan. frame: a UpFrame, else the map's own.");
}

}  // namespace panoptic::python
