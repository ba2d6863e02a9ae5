// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/planning.h"
#include "panoptic/distance_field.h"

namespace panoptic::python {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A field, and the map that its answers come from.
struct PythonField {
  std::shared_ptr<MapView> map;
  DistanceField field;
  Exclusive use{"distance field"};
};

// Asks while nobody changes the map.
template <typename Question>
auto ask(PythonField& self, const Question& question) {
  const Use use(self.use);
  const Use map(*self.map->use);
  return released([&] { return question(self.field); });
}

void update(PythonField& self) {
  const Use use(self.use);
  const Use map(*self.map->use);
  released([&] { self.field.update(self.map->map); });
}

std::shared_ptr<PythonField> make(const std::shared_ptr<MapView>& map, const std::optional<UpFrame>& frame, double cell_m,
                                  double cap_m) {
  std::optional<UpFrame> chosen;
  {
    const Use use(*map->use);
    chosen = frame_or_own(*map, frame);
  }
  auto made = std::make_shared<PythonField>(PythonField{map, DistanceField(*chosen, {cell_m, cap_m})});
  update(*made);
  return made;
}

py::object gradient(PythonField& self, const py::object& point) {
  const Vec3d place = point_from(point, "point");
  const auto gradient = ask(self, [&](const DistanceField& field) { return field.gradient(place); });
  return gradient ? py::object(vector_of(*gradient)) : py::none();
}

py::array distances(PythonField& self, const py::object& given) {
  const Points points = points_from(given, "points");
  py::array_t<double> array(static_cast<py::ssize_t>(points.at.size()));
  double* out = array.mutable_data();
  ask(self, [&](const DistanceField& field) {
    for (const Vec3d& point : points.at) *out++ = field.distance_m(point).value_or(kNan);
    return 0;
  });
  return array;
}

py::array gradients(PythonField& self, const py::object& given) {
  const Points points = points_from(given, "points");
  const std::vector<Vec3d> found = ask(self, [&](const DistanceField& field) {
    std::vector<Vec3d> gradients;
    for (const Vec3d& point : points.at) gradients.push_back(field.gradient(point).value_or(Vec3d::Constant(kNan)));
    return gradients;
  });
  return rows_of(found);
}

py::tuple values(PythonField& self) {
  auto all = std::make_unique<DistanceField::Values>(ask(self, [](const DistanceField& field) { return field.values(); }));
  const DistanceField::Values& cells = *all;
  const py::capsule owner(all.release(), [](void* memory) { delete static_cast<DistanceField::Values*>(memory); });
  const Eigen::Vector3i size = cells.size;
  constexpr py::ssize_t kNumber = sizeof(float);
  const py::array array = view(cells.distance_m.data(), {size.z(), size.y(), size.x()},
                               {kNumber * size.x() * size.y(), kNumber * size.x(), kNumber}, owner);
  return py::make_tuple(array, vector_of(cells.origin_m));
}

}  // namespace

void bind_distances(py::module_& m) {
  using One = std::optional<double>;
  py::class_<PythonField, std::shared_ptr<PythonField>>(m, "DistanceField",
                                                        R"(How far the nearest surface is, and which way leads away from it.

DistanceField(map, frame=None, cell_m=0.048, cap_m=2.0): Euclidean distances in the grid frame, metres, negative behind surfaces; they end
at cap_m. After every change of the map call update, which takes as long as the change is large.)")
      .def(py::init(&make), py::arg("map").none(false), py::arg("frame") = py::none(), py::kw_only(),
           py::arg("cell_m") = DistanceFieldOptions().cell_m, py::arg("cap_m") = DistanceFieldOptions().cap_m)
      .def("update", &update, "Brings the distances up to date with the map.")
      .def(
          "distance_m",
          [](PythonField& self, const py::object& point) -> One {
            const Vec3d place = point_from(point, "point");
            return ask(self, [&](const DistanceField& field) { return field.distance_m(place); });
          },
          py::arg("point"), "At a point (3,) of the grid frame, interpolated between cells; None where it is not known.")
      .def(
          "distance_at",
          [](PythonField& self, const py::object& point) -> One {
            const Vec3d place = point_from(point, "point");
            return ask(self, [&](const DistanceField& field) { return field.distance_at(place); });
          },
          py::arg("point"), "Of the cell around a point (3,); None where it is not known.")
      .def("gradient", &gradient, py::arg("point"),
           "(3,) float64, unit length: where the distance grows fastest. None where it is not known or the same all around.")
      .def("distances_m", &distances, py::arg("points"),
           "(N,) float64 for points (N, 3), as distance_m; NaN where it is not known.")
      .def("gradients", &gradients, py::arg("points"),
           "(N, 3) float64 for points (N, 3), as gradient; NaN where it is not known.")
      .def(
          "values", &values,
          R"((distances (Z, Y, X) float32, origin_m (3,)): all cells around the surface, indexed [z, y, x], NaN where nothing is known.
The centre of cell [0, 0, 0] lies at origin_m of the grid frame.)")
      .def_property_readonly("cell_m", [](const PythonField& f) { return f.field.cell_m(); })
      .def_property_readonly("cap_m", [](const PythonField& f) { return f.field.cap_m(); })
      .def_property_readonly(
          "grid_from_world", [](const PythonField& f) { return matrix_of(f.field.grid_from_world()); }, "(4, 4) float64.")
      .def("__repr__", [](const PythonField& f) {
        return fmt::format("<DistanceField in cells of {:.3f} m, up to {:.1f} m>", f.field.cell_m(), f.field.cap_m());
      });
}

}  // namespace panoptic::python
