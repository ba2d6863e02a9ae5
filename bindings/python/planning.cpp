// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The z-up frame of a map, grids of its floor, and all files of a plan.
#include "bindings/python/planning.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/directions.h"
#include "panoptic/floor_grids.h"

namespace panoptic::python {
namespace {

namespace fs = std::filesystem;
using Bands = std::vector<std::pair<double, double>>;

UpFrame frame_of(const MapView& view, const py::object& up) {
  std::optional<Vec3d> upwards;
  if (!up.is_none()) upwards = direction_from(up, "up");
  const Use use(*view.use);
  if (!upwards) upwards = up_of(view);
  return released([&] { return up_frame(view.map, upwards); });
}

// Cells have whole numbers, and samples of the surface single precision: a millimetre so far out.
UpFrame frame_from(const py::object& matrix) {
  constexpr double kFarthest_m = 1e4;
  const Pose pose = pose_from(matrix, "grid_from_world");
  if (pose.translation().cwiseAbs().maxCoeff() <= kFarthest_m) return UpFrame{pose};
  throw Error("grid_from_world moves the map farther than 10 km: take an origin that is nearer");
}

py::array moved(const Pose& pose, const py::object& points) {
  Points given = points_from(points, "points");
  for (Vec3d& point : given.at) point = pose * point;
  return given.is_single ? vector_of(given.at.front()) : rows_of(given.at);
}

AgentSize make_agent(double radius_m, double height_m, double climb_m) {
  const AgentSize agent{radius_m, height_m, climb_m};
  check(agent);
  return agent;
}

std::vector<HeightBand> bands_of(const Bands& given) {
  std::vector<HeightBand> bands;
  for (const auto& [low_m, high_m] : given) bands.push_back({low_m, high_m});
  return bands;
}

std::shared_ptr<FloorGrids> grids(const MapView& view, const std::optional<UpFrame>& frame, const AgentSize& agent,
                                  const Bands& bands) {
  const Use use(*view.use);
  const UpFrame chosen = frame_or_own(view, frame);
  return std::make_shared<FloorGrids>(released([&] { return floor_grids(view.map, chosen, agent, bands_of(bands)); }));
}

// A view of a property of all cells, (rows, columns).
template <typename To, typename From>
py::array cell_view(const py::object& self, const std::vector<From>& cells) {
  static_assert(sizeof(To) == sizeof(From));
  const auto& grids = self.cast<const FloorGrids&>();
  const auto* first = reinterpret_cast<const To*>(cells.data());
  return view(first, {grids.rows, grids.columns}, {py::ssize_t{sizeof(To)} * grids.columns, py::ssize_t{sizeof(To)}}, self);
}

py::list band_views(const py::object& self) {
  py::list list;
  for (const auto& band : self.cast<const FloorGrids&>().bands) list.append(cell_view<std::uint8_t>(self, band));
  return list;
}

std::optional<Journey> journey_of(const py::object& start, const py::object& goal) {
  if (start.is_none() != goal.is_none()) throw Error("a way takes both: start, and goal");
  if (start.is_none()) return std::nullopt;
  Journey journey{point_from(start, "start"), {}, {}};
  if (py::isinstance<py::str>(goal)) {
    journey.to_object = py::str(goal);
  } else {
    journey.to_m = point_from(goal, "goal");
  }
  return journey;
}

py::dict summary_of(const PlanSummary& s) {
  py::dict answer(py::arg("cell_m") = s.cell_m, py::arg("walkable_m2") = s.walkable_m2, py::arg("islands") = s.islands,
                  py::arg("polygons") = s.polygons, py::arg("walls") = s.walls, py::arg("mesh_ms") = s.mesh_ms,
                  py::arg("length_m") = s.length_m, py::arg("why_not") = s.why_not);
  answer["frame"] = s.frame;
  return answer;
}

// Asks Python between two steps whether to go on: Ctrl-C and what `progress` raises end the plan.
class StepWatch {
 public:
  explicit StepWatch(const py::object& progress) : progress_(progress) {}

  void operator()(std::size_t number) {
    const py::gil_scoped_acquire lock;
    if (is_ending()) throw Error("the program is ending: the plan is not whole");
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!progress_.is_none()) progress_(number, kPlanSteps);
    } catch (py::error_already_set& e) {
      raised_.emplace(std::move(e));
      throw Error("stopped");
    }
  }
  std::optional<py::error_already_set>& raised() { return raised_; }

 private:
  const py::object& progress_;
  std::optional<py::error_already_set> raised_;
};

py::dict plan(const fs::path& folder, const MapView& view, const AgentSize& agent, const Bands& bands, const py::object& start,
              const py::object& goal, const py::object& up, const py::object& progress) {
  PlanOptions options{agent, bands_of(bands), journey_of(start, goal), {}};
  if (!up.is_none()) options.up = direction_from(up, "up");
  const Use use(*view.use);
  if (!options.up) options.up = up_of(view);
  StepWatch watch(progress);
  PlanSummary summary;
  try {
    summary = released(
        [&] { return write_plan(folder, view.map, options, [&](const std::string&, std::size_t number) { watch(number); }); });
  } catch (const Error&) {
    if (watch.raised()) throw std::move(*watch.raised());
    throw;
  }
  if (!progress.is_none()) progress(kPlanSteps, kPlanSteps);
  warn(summary.notes);
  return summary_of(summary);
}

void bind_frame(py::module_& m) {
  py::class_<UpFrame>(m, "UpFrame", R"(The grid frame of a map: z is up and the floor lies near z = 0. Metres.

up_frame gives a map's own. UpFrame(grid_from_world) is one that somebody else decided on, for example the frame of a robot.)")
      .def(py::init(&frame_from), py::arg("grid_from_world"))
      .def_property_readonly(
          "grid_from_world", [](const UpFrame& f) { return matrix_of(f.grid_from_world); }, "(4, 4) float64.")
      .def_property_readonly(
          "world_from_grid", [](const UpFrame& f) { return matrix_of(Pose(f.grid_from_world.inverse())); }, "(4, 4) float64.")
      .def_property_readonly(
          "up", [](const UpFrame& f) { return vector_of(f.up()); }, "(3,) float64, upwards in the world.")
      .def_readonly("floor_is_labelled", &UpFrame::floor_is_labelled, "Else the floor is the lowest large level surface.")
      .def_readonly("floor_area_m2", &UpFrame::floor_area_m2, "Level surface near z = 0.")
      .def(
          "to_grid", [](const UpFrame& f, const py::object& points) { return moved(f.grid_from_world, points); },
          py::arg("points"), "Points (N, 3), or one (3,), from the world into this frame.")
      .def(
          "to_world", [](const UpFrame& f, const py::object& points) { return moved(Pose(f.grid_from_world.inverse()), points); },
          py::arg("points"), "Points (N, 3), or one (3,), from this frame into the world.")
      .def("__repr__", [](const UpFrame& f) {
        const Vec3d up = f.up();
        return fmt::format("<UpFrame, up is ({:.3f}, {:.3f}, {:.3f})>", up.x(), up.y(), up.z());
      });
  m.def(
      "up_frame", &frame_of, py::arg("map"), py::arg("up") = py::none(),
      R"(The grid frame of a map. up (3,): about upwards in the world; without it Map.up counts, else the normals of floor and ceiling.)");

  py::class_<AgentSize>(m, "AgentSize", R"(Whoever moves: a cylinder that stands upright. Metres.

AgentSize(radius_m=0.2, height_m=1.5, climb_m=0.05); climb_m is the highest step that it takes.)")
      .def(py::init(&make_agent), py::arg("radius_m") = AgentSize().radius_m, py::arg("height_m") = AgentSize().height_m,
           py::arg("climb_m") = AgentSize().climb_m)
      .def_readonly("radius_m", &AgentSize::radius_m)
      .def_readonly("height_m", &AgentSize::height_m)
      .def_readonly("climb_m", &AgentSize::climb_m)
      .def("__repr__", [](const AgentSize& a) {
        return fmt::format("AgentSize(radius_m={}, height_m={}, climb_m={})", a.radius_m, a.height_m, a.climb_m);
      });
}

void bind_grids(py::module_& m) {
  py::class_<FloorGrids, std::shared_ptr<FloorGrids>>(m, "FloorGrids", R"(A map from above, in the grid frame. Metres.

The arrays are views that cannot be written to, indexed [row, column]: rows along y, columns along x. The corner of cell [0, 0] lies at
origin_m, so that the centre of [r, c] is origin_m + (c + 0.5, r + 0.5) * cell_m. pf.UNKNOWN, pf.FREE and pf.OCCUPIED are 0, 1 and 2.)")
      .def_readonly("cell_m", &FloorGrids::cell_m)
      .def_property_readonly(
          "origin_m", [](const FloorGrids& g) { return py::array_t<double>(2, g.origin_m.data()); }, "(2,) float64.")
      .def_property_readonly(
          "standing", [](const py::object& s) { return cell_view<std::uint8_t>(s, s.cast<const FloorGrids&>().standing); },
          "(rows, columns) uint8, from the step to the height of the agent: where it bumps into nothing.")
      .def_property_readonly("bands", &band_views, "The same for each band of heights, a list.")
      .def_property_readonly(
          "class_id", [](const py::object& s) { return cell_view<std::uint16_t>(s, s.cast<const FloorGrids&>().class_at); },
          "(rows, columns) uint16, of the highest surface below the ceiling; 0 = unknown, or no surface.")
      .def_property_readonly(
          "is_seen", [](const py::object& s) { return cell_view<bool>(s, s.cast<const FloorGrids&>().is_seen); },
          "(rows, columns) bool: there is surface below the ceiling.")
      .def("__repr__", [](const FloorGrids& g) {
        return fmt::format("<FloorGrids of {} x {} cells of {:.3f} m>", g.rows, g.columns, g.cell_m);
      });
  m.def(
      "floor_grids", &grids, py::arg("map"), py::arg("frame") = py::none(), py::kw_only(), py::arg("agent") = AgentSize(),
      py::arg("bands") = Bands(),
      R"(Grids of a map for an agent, and for bands of heights above the floor: bands=[(0.6, 0.9)]. frame: a UpFrame, else the map's own.)");
}

}  // namespace

UpFrame frame_or_own(const MapView& view, const std::optional<UpFrame>& frame) {
  if (frame) return *frame;
  const std::optional<Vec3d> up = up_of(view);
  return released([&] { return up_frame(view.map, up); });
}

void bind_planning(py::module_& m) {
  bind_frame(m);
  bind_grids(m);
  m.def("write_plan", &plan, py::arg("folder"), py::arg("map"), py::kw_only(), py::arg("agent") = AgentSize(),
        py::arg("bands") = Bands(), py::arg("start") = py::none(), py::arg("goal") = py::none(), py::arg("up") = py::none(),
        py::arg("progress") = py::none(),
        R"(Writes what `panoptic plan` writes (docs/planning.md), and returns a dict of sizes and the frame.

start (3,) and goal, a point (3,) or the name of a node such as "chair_31", in the world of the map: a way between them, whose length_m
is None where why_not says why there is none. progress(step, steps) is called before each step and at the end.)");
}

}  // namespace panoptic::python
