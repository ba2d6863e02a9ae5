// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/mesh.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/directions.h"
#include "bindings/python/labels.h"
#include "panoptic/outputs.h"

namespace panoptic::python {
namespace {

constexpr py::ssize_t kVertex = sizeof(MeshVertex);
const MeshVertex kNoVertex;

// A view of one property of all vertices; `columns` of them if it is more than one number.
template <typename T, typename Property>
py::array vertex_view(const py::object& self, Property MeshVertex::*property, py::ssize_t columns) {
  const Mesh& mesh = self.cast<const LabelledMesh&>().mesh;
  const MeshVertex& first = mesh.vertices.empty() ? kNoVertex : mesh.vertices.front();
  const auto* data = reinterpret_cast<const T*>(&(first.*property));
  const auto count = static_cast<py::ssize_t>(mesh.vertices.size());
  if (columns == 1) return view(data, {count}, {kVertex}, self);
  return view(data, {count, columns}, {kVertex, py::ssize_t{sizeof(T)}}, self);
}

py::array triangles(const py::object& self) {
  static const std::array<std::uint32_t, 3> kNone{};
  const Mesh& mesh = self.cast<const LabelledMesh&>().mesh;
  const auto* data = mesh.triangles.empty() ? kNone.data() : mesh.triangles.front().data();
  constexpr py::ssize_t kIndex = sizeof(std::uint32_t);
  return view(data, {static_cast<py::ssize_t>(mesh.triangles.size()), 3}, {3 * kIndex, kIndex}, self);
}

void save(const LabelledMesh& mesh, const std::filesystem::path& path, const py::object& up) {
  std::optional<Vec3d> upwards;
  if (!up.is_none()) upwards = direction_from(up, "up");
  if (path.extension() == ".ply") {
    if (upwards) throw Error(fmt::format("{}: a PLY keeps the axes of the map: leave out up", path.string()));
    released([&] { write_ply(path, mesh.mesh); });
  } else if (path.extension() == ".glb") {
    released([&] { write_glb(path, mesh.mesh, mesh.labels, upwards); });
  } else {
    throw Error(fmt::format("{}: a mesh is saved as .ply or .glb", path.string()));
  }
}

void save_views(const LabelledMesh& mesh, const std::filesystem::path& folder, const py::object& up) {
  const Vec3d upwards = direction_from(up, "up");
  released([&] { write_views(folder, mesh.mesh, upwards, mesh.labels); });
}

py::list shapes(const LabelledMesh& mesh) {
  const std::vector<ObjectShape> found = released([&] { return object_shapes(mesh.mesh); });
  py::list list;
  for (const ObjectShape& shape : found) {
    py::dict entry(py::arg("id") = number(shape.id), py::arg("class_id") = number(shape.class_id),
                   py::arg("class_name") = std::string(mesh.labels.name_of(shape.class_id)), py::arg("vertices") = shape.vertices,
                   py::arg("area_m2") = shape.area_m2);
    entry["min_m"] = vector_of(shape.min_m);
    entry["max_m"] = vector_of(shape.max_m);
    entry["centroid_m"] = vector_of(shape.centroid_m);
    entry["box_center_m"] = vector_of(shape.oriented_box.center_m);
    entry["box_size_m"] = vector_of(shape.oriented_box.size_m);
    Pose world_from_box = Pose::Identity();
    world_from_box.linear() = shape.oriented_box.axes;
    world_from_box.translation() = shape.oriented_box.center_m;
    entry["world_from_box"] = matrix_of(world_from_box);
    list.append(std::move(entry));
  }
  return list;
}

py::dict class_areas(const LabelledMesh& mesh) {
  const std::map<ClassId, double> areas = released([&] { return class_areas_m2(mesh.mesh); });
  py::dict answer;
  for (const auto& [id, area_m2] : areas) answer[py::str(std::string(mesh.labels.name_of(id)))] = area_m2;
  return answer;
}

}  // namespace

void bind_mesh(py::module_& m) {
  py::class_<LabelledMesh, std::shared_ptr<LabelledMesh>>(m, "Mesh", R"(The surface of a map, with labels. Metres, world axes.

The arrays are views of the mesh's memory, which they keep alive; they cannot be written to.)")
      .def_property_readonly(
          "vertices", [](const py::object& s) { return vertex_view<float>(s, &MeshVertex::position, 3); },
          "(V, 3) float32, metres.")
      .def_property_readonly(
          "normals", [](const py::object& s) { return vertex_view<float>(s, &MeshVertex::normal, 3); },
          "(V, 3) float32, unit length, out of the surface.")
      .def_property_readonly(
          "colors", [](const py::object& s) { return vertex_view<std::uint8_t>(s, &MeshVertex::color, 3); },
          "(V, 3) uint8, red first.")
      .def_property_readonly(
          "class_id", [](const py::object& s) { return vertex_view<std::uint16_t>(s, &MeshVertex::class_id, 1); },
          "(V,) uint16, 0 = unknown.")
      .def_property_readonly(
          "panoptic_id", [](const py::object& s) { return vertex_view<std::uint32_t>(s, &MeshVertex::panoptic_id, 1); },
          "(V,) uint32: an object's id, or the class number of what was not told apart.")
      .def_property_readonly("triangles", &triangles, "(T, 3) uint32, counter-clockwise seen from free space.")
      .def_property_readonly("labels", [](const LabelledMesh& mesh) { return mesh.labels; })
      .def("save", &save, py::arg("path"), py::arg("up") = py::none(),
           "Writes a .ply, or a .glb with one node per object; `up` (3,) turns a glb upright.")
      .def("save_views", &save_views, py::arg("folder"), py::arg("up"),
           "Writes pictures from the front, the side and the top: colours, classes and objects. `up` (3,), as Mapper.up.")
      .def(
          "shapes", &shapes,
          R"(A dict for each panoptic id that has surface: id, class_id, class_name, vertices, area_m2, min_m and max_m (3,), centroid_m (3,),
and the oriented box: box_center_m (3,), box_size_m (3,) along its axes, the longest first, and world_from_box (4, 4).)")
      .def("class_areas_m2", &class_areas, "Square metres of surface by the name of the class.")
      .def("__repr__", [](const LabelledMesh& mesh) {
        return fmt::format("<Mesh of {} vertices and {} triangles>", mesh.mesh.vertices.size(), mesh.mesh.triangles.size());
      });

  m.def(
      "read_ply",
      [](const std::filesystem::path& path, const py::object& labels) {
        return std::make_shared<LabelledMesh>(
            LabelledMesh{released([&] { return read_ply(path); }), labels_from(labels, "indoor")});
      },
      py::arg("path"), py::arg("labels") = "indoor", "Reads a mesh.ply that was written before.");
}

}  // namespace panoptic::python
