// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/free_space.h"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/map.h"

namespace panoptic::python {
namespace {

const FreeSpaceMap& space_of(const FreeSpaceView& view) { return view.map->map.free_space; }

py::array at(const FreeSpaceView& view, const py::object& points_m) {
  const Points points = points_from(points_m, "points");
  const Use use(*view.map->use);
  py::array_t<std::uint8_t> array(static_cast<py::ssize_t>(points.at.size()));
  std::uint8_t* out = array.mutable_data();
  for (const Vec3d& point : points.at) {
    const std::optional<CellIndex> cell = space_of(view).cell_around(point);
    *out++ = static_cast<std::uint8_t>(cell ? space_of(view).at(*cell) : Space::kUnknown);
  }
  return array;
}

py::tuple cells(const FreeSpaceView& view) {
  const Use use(*view.map->use);
  std::vector<Eigen::Vector3i> index;
  std::vector<std::uint8_t> space;
  released([&] {
    space_of(view).for_each([&](const CellIndex& cell, Space known) {
      index.emplace_back(cell[0], cell[1], cell[2]);
      space.push_back(static_cast<std::uint8_t>(known));
    });
  });
  return py::make_tuple(rows_of(index), py::array_t<std::uint8_t>(static_cast<py::ssize_t>(space.size()), space.data()));
}

py::object record(const FreeSpaceView& view, const py::object& point) {
  const Vec3d place = point_from(point, "point");
  const Use use(*view.map->use);
  const std::optional<CellIndex> cell = space_of(view).cell_around(place);
  if (!cell) return py::none();
  const CellRecord record = space_of(view).record(*cell);
  return py::dict(py::arg("evidence") = record.evidence, py::arg("empty_at") = record.empty_at,
                  py::arg("occupied_at") = record.occupied_at);
}

}  // namespace

void bind_free_space(py::module_& m) {
  py::class_<FreeSpaceView>(m, "FreeSpace", R"(The space of a map that was seen to be empty, in cells of 4 x 4 x 4 voxels.

Cell (i, j, k) spans [i, i + 1) * cell_size_m along x, and so on, in the world. pf.UNKNOWN, pf.FREE and pf.OCCUPIED are 0, 1 and 2.)")
      .def_property_readonly("cell_size_m", [](const FreeSpaceView& v) { return space_of(v).cell_size_m(); })
      .def("at", &at, py::arg("points"),
           "(N,) uint8 for points (N, 3), or one, in the world: what is known of the cells around them.")
      .def("cells", &cells, "(index (N, 3) int32, space (N,) uint8) of every cell that is not unknown.")
      .def(
          "record", &record, py::arg("point"),
          R"(A dict of the cell around a point (3,): evidence (views that saw it empty, less when something was seen in it), empty_at and
occupied_at (after how many used frames it was last seen so; None: never). None where no map reaches.)")
      .def("__repr__",
           [](const FreeSpaceView& v) { return fmt::format("<FreeSpace of cells of {:.3f} m>", space_of(v).cell_size_m()); });
}

}  // namespace panoptic::python
