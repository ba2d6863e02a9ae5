// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/navigation.h"

#include <fmt/format.h>

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/objects.h"
#include "bindings/python/planning.h"

namespace panoptic::python {
namespace {

struct PythonNavigation {
  UpFrame frame;
  NavigationMesh mesh;
  Exclusive use{"navigation mesh"};
};

std::shared_ptr<PythonNavigation> make(const std::shared_ptr<MapView>& map, const std::optional<UpFrame>& frame,
                                       const AgentSize& agent) {
  const Use use(*map->use);
  const UpFrame chosen = frame_or_own(*map, frame);
  return std::make_shared<PythonNavigation>(
      PythonNavigation{chosen, released([&] { return NavigationMesh(map->map, chosen, agent); })});
}

template <typename Question>
auto ask(PythonNavigation& self, const Question& question) {
  const Use use(self.use);
  return released([&] { return question(self.mesh); });
}

bool is_walkable(PythonNavigation& self, const py::object& point) {
  const Vec3d place = point_from(point, "point");
  return ask(self, [&](const NavigationMesh& mesh) { return mesh.is_walkable(place); });
}

Path path(PythonNavigation& self, const py::object& start, const py::object& goal) {
  const Vec3d from = point_from(start, "start");
  const Vec3d to = point_from(goal, "goal");
  return ask(self, [&](const NavigationMesh& mesh) { return mesh.path(from, to); });
}

Path path_to(PythonNavigation& self, const py::object& start, const py::object& object) {
  const Vec3d from = point_from(start, "start");
  const std::int64_t id = object_number(object);
  if (id < 1 || id > std::numeric_limits<std::uint32_t>::max()) throw Error(fmt::format("there is no object with the id {}", id));
  return ask(self, [&](const NavigationMesh& mesh) { return mesh.path_to(from, static_cast<PanopticId>(id)); });
}

py::tuple triangles(PythonNavigation& self) {
  const NavigationMesh::Triangles found = ask(self, [](const NavigationMesh& mesh) { return mesh.triangles(); });
  py::array_t<std::uint32_t> corners({static_cast<py::ssize_t>(found.corners.size()), py::ssize_t{3}});
  std::uint32_t* out = corners.mutable_data();
  for (const auto& triangle : found.corners) out = std::copy(triangle.begin(), triangle.end(), out);
  return py::make_tuple(rows_of(found.vertices_m), corners);
}

}  // namespace

void bind_navigation(py::module_& m) {
  py::class_<Path>(m, "FloorPath", "A way over the floor: true in conditions if there is one, else `why_not` says why not.")
      .def_readonly("found", &Path::found)
      .def_readonly("length_m", &Path::length_m)
      .def_property_readonly(
          "points_m", [](const Path& p) { return rows_of(p.points_m); },
          "(N, 3) float64, where the feet go in the grid frame, start and goal included.")
      .def_readonly("why_not", &Path::why_not)
      .def("__bool__", [](const Path& p) { return p.found; })
      .def("__repr__", [](const Path& p) {
        return p.found ? fmt::format("<FloorPath of {:.2f} m>", p.length_m) : fmt::format("<no path: {}>", p.why_not);
      });

  py::class_<PythonNavigation, std::shared_ptr<PythonNavigation>>(m, "NavigationMesh",
                                                                  R"(The floor on which an agent may stand, and the ways over it.

NavigationMesh(map, frame=None, agent=AgentSize()): points are in the grid frame, metres; frame.to_grid brings those of the world there.
It is a copy of what it needs: the map may change afterwards.)")
      .def(py::init(&make), py::arg("map").none(false), py::arg("frame") = py::none(), py::arg("agent") = AgentSize())
      .def("path", &path, py::arg("start"), py::arg("goal"),
           R"(The way between two points (3,): a FloorPath. They may be nearer to an obstacle than the agent's radius.
Raises Error if one is in an obstacle, or where no floor was seen.)")
      .def("path_to", &path_to, py::arg("start"), py::arg("id"),
           "The way to a place next to an object (MapObject.id) or a class of stuff (its number), at most 1.5 m away.")
      .def("is_walkable", &is_walkable, py::arg("point"),
           "Whether the agent's centre may be at a point (3,), or at most 2 m below it.")
      .def("triangles", &triangles, "(vertices (V, 3) float32, triangles (T, 3) uint32) of the polygons, in the grid frame.")
      .def(
          "detour_bytes",
          [](PythonNavigation& self) {
            return py::bytes(ask(self, [](const NavigationMesh& mesh) { return mesh.detour_bytes(); }));
          },
          "The contents of a navmesh.bin as RecastDemo saves it; its axes are (x, z, -y) of the grid frame.")
      .def_property_readonly(
          "frame", [](const PythonNavigation& n) { return n.frame; }, "The UpFrame that its points are in.")
      .def_property_readonly(
          "area_m2", [](const PythonNavigation& n) { return n.mesh.area_m2(); }, "On which the agent's centre may be.")
      .def_property_readonly(
          "islands", [](const PythonNavigation& n) { return n.mesh.islands(); }, "Parts of the floor without a way between them.")
      .def_property_readonly("polygon_count", [](const PythonNavigation& n) { return n.mesh.polygon_count(); })
      .def("__repr__", [](const PythonNavigation& n) {
        return fmt::format("<NavigationMesh of {:.1f} m2 in {} parts>", n.mesh.area_m2(), n.mesh.islands());
      });
}

}  // namespace panoptic::python
