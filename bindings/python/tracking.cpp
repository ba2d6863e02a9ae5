// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Poses for recordings that have none, and how far a trajectory is from the true one.
#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/map.h"
#include "bindings/python/mapper.h"
#include "panoptic/camera_tracker.h"
#include "panoptic/trajectory.h"

namespace panoptic::python {
namespace {

namespace fs = std::filesystem;

// A tracker, who uses it, and the frame that it may be told to keep.
struct Tracker {
  explicit Tracker(const CameraTrackerOptions& options) : tracker(options) {}

  CameraTracker tracker;
  Exclusive use{"camera tracker"};
  std::optional<Frame> known = {};  // the frame that was tracked last, if its pose is known

  bool has_tracked(const Frame& frame) const {
    return known && known->index == frame.index && known->time_s == frame.time_s && known->depth.row(0) == frame.depth.row(0);
  }
};

std::unique_ptr<Tracker> make(float min_depth_m, float max_depth_m, const py::object& start) {
  CameraTrackerOptions options{.min_depth_m = min_depth_m, .max_depth_m = max_depth_m, .start = {}};
  if (!start.is_none()) options.start = pose_from(start, "start");
  return std::make_unique<Tracker>(options);
}

CameraPose track(Tracker& self, const Frame& frame, PythonMapper& mapper) {
  const Use use(self.use);
  const Use map(*mapper.use);
  self.known.reset();
  const CameraPose pose = released([&] { return self.tracker.track(frame, mapper.mapper.map().voxels); });
  if (pose.is_known()) self.known = frame;
  return pose;
}

void keep(Tracker& self, const Frame& frame) {
  const Use use(self.use);
  if (!self.known) throw Error("keep: the frame that was tracked last is lost, or kept already");
  if (!self.has_tracked(frame)) throw Error("keep: this is not the frame that was tracked last, or one made of it by with_pose");
  self.known.reset();
  released([&] { self.tracker.keep(frame); });
}

py::object corrected_poses(Tracker& self) {
  const Use use(self.use);
  const auto poses = released([&] { return self.tracker.corrected_poses(); });
  if (!poses) return py::none();
  py::dict dict;
  for (const FramePose& pose : *poses) dict[py::int_(pose.frame)] = matrix_of(pose.world_from_camera);
  return dict;
}

py::tuple trajectory(Tracker& self) {
  const Use use(self.use);
  const std::vector<FramePose> poses = self.tracker.trajectory();
  return py::make_tuple(times_of(poses), matrices_of(poses));
}

py::list loops(Tracker& self) {
  const Use use(self.use);
  py::list list;
  for (const Loop& loop : self.tracker.loops()) {
    list.append(py::dict(py::arg("frame") = loop.frame, py::arg("earlier_frame") = loop.earlier_frame,
                         py::arg("earlier_from_frame") = matrix_of(loop.earlier_from_frame), py::arg("moved_m") = loop.moved_m,
                         py::arg("is_believed") = loop.is_believed, py::arg("corrects") = loop.corrects));
  }
  return list;
}

py::array covariance(const CameraPose& pose) {
  constexpr py::ssize_t kSide = 6;
  py::array_t<double> array({kSide, kSide});
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> matrix(array.mutable_data());
  matrix = pose.covariance;
  return array;
}

std::vector<StampedPose> trajectory_in(const py::object& path, const char* what) {
  fs::path file;
  try {
    file = path.cast<fs::path>();
  } catch (const py::cast_error&) {
    throw Error(fmt::format("{} must be (times, poses), or the path of a file", what));
  }
  return released([&] { return read_trajectory(file); });
}

// A trajectory: a file, or times (N,) and poses (N, 4, 4).
std::vector<StampedPose> stamped(const py::object& given, const char* what) {
  if (!py::isinstance<py::tuple>(given) && !py::isinstance<py::list>(given)) return trajectory_in(given, what);
  const auto pair = given.cast<py::sequence>();
  if (pair.size() != 2) throw Error(fmt::format("{} must be (times, poses), or the path of a file", what));
  const std::vector<double> times = times_from(pair[0], what);
  const py::array poses = array_of(pair[1], what);
  if (poses.ndim() != 3 || static_cast<std::size_t>(poses.shape(0)) != times.size())
    throw Error(fmt::format("{}: {} times and poses of {}: they must be (N,) and (N, 4, 4)", what, times.size(), text_of(poses)));
  std::vector<StampedPose> list;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i])) throw Error(fmt::format("{}: time {} is not finite", what, i));
    list.push_back({times[i], pose_from(poses[py::int_(i)], what)});
  }
  std::stable_sort(list.begin(), list.end(), [](const StampedPose& a, const StampedPose& b) { return a.time_s < b.time_s; });
  return list;
}

// Without a pair there is nothing to say.
py::dict dict_of(const ErrorStatistics& s) {
  if (s.count == 0) {
    py::dict empty = dict_of(ErrorStatistics{.count = 1});
    for (const auto& [name, value] : py::dict(empty)) empty[name] = py::none();
    empty["count"] = 0;
    return empty;
  }
  return py::dict(py::arg("count") = s.count, py::arg("rmse") = s.rmse, py::arg("mean") = s.mean, py::arg("median") = s.median,
                  py::arg("standard_deviation") = s.standard_deviation, py::arg("least") = s.least, py::arg("most") = s.most);
}

py::dict score(const py::object& estimate, const py::object& truth, double most_apart_s, double step_s) {
  if (!(most_apart_s >= 0) || !(step_s > 0) || !std::isfinite(most_apart_s + step_s))
    throw Error("most_apart_s must not be below 0, step_s must be above 0, and both finite");
  const std::vector<StampedPose> guessed = stamped(estimate, "estimate");
  const std::vector<StampedPose> true_ones = stamped(truth, "truth");
  const TrajectoryScores s = released([&] { return score_trajectory(guessed, true_ones, {most_apart_s, step_s}); });
  return py::dict(py::arg("poses") = s.poses, py::arg("true_poses") = s.true_poses, py::arg("way_m") = s.way_m,
                  py::arg("absolute_m") = dict_of(s.absolute_m), py::arg("relative_m") = dict_of(s.relative_m),
                  py::arg("relative_deg") = dict_of(s.relative_deg),
                  py::arg("truth_from_estimate") = matrix_of(s.truth_from_estimate));
}

void bind_poses_found(py::module_& m) {
  py::class_<CameraPose>(m, "CameraPose",
                         "Where the camera is, as a CameraTracker found it: true in conditions if that is known.")
      .def_property_readonly(
          "state", [](const CameraPose& p) { return std::string(to_text(p.state)); }, "begun, tracked, found again, or lost.")
      .def_property_readonly(
          "pose", [](const CameraPose& p) { return p.is_known() ? py::object(matrix_of(p.world_from_camera)) : py::none(); },
          "(4, 4) float64 world_from_camera, metres; None if it is lost.")
      .def_readonly("reason", &CameraPose::reason, "Why it is lost.")
      .def_readonly("quality", &CameraPose::quality,
                    "0 to 1: the share of the readings near surface of the map that lie on it as well as the sensor can tell.")
      .def_property_readonly("covariance", &covariance,
                             "(6, 6) float64, of the motion by which the pose may be off: translation (m^2), rotation (rad^2).")
      .def("__bool__", &CameraPose::is_known)
      .def("__repr__", [](const CameraPose& p) {
        return p.is_known() ? fmt::format("<{}, quality {:.2f}>", to_text(p.state), p.quality)
                            : fmt::format("<lost: {}>", p.reason);
      });
}

}  // namespace

void bind_tracking(py::module_& m) {
  bind_poses_found(m);
  py::class_<Tracker>(m, "CameraTracker", R"(Finds the poses of a camera from the map that the frames before have made.

Ask it for the pose of a frame, add the frame with it, and tell the tracker; a frame that is lost must not be added:

    found = tracker.track(frame, mapper)
    if found:
        frame = frame.with_pose(found.pose)
        if mapper.add(frame, segments):
            tracker.keep(frame)

Readings outside of min_depth_m to max_depth_m count as missing. start: (4, 4), the pose of the first frame; without it the camera
looks along the world's y axis, z is up. The same frames give the same poses on one machine at any number of threads.)")
      .def(py::init(&make), py::kw_only(), py::arg("min_depth_m") = CameraTrackerOptions{}.min_depth_m,
           py::arg("max_depth_m") = CameraTrackerOptions{}.max_depth_m, py::arg("start") = py::none())
      .def("track", &track, py::arg("frame"), py::arg("mapper"),
           "The CameraPose of the next frame in the map of the frames before; the pose that it has is not looked at.")
      .def("keep", &keep, py::arg("frame"), "The frame that was tracked last is in the map, with the pose that was found.")
      .def("corrected_poses", &corrected_poses,
           R"({frame index: (4, 4)} of all frames if a loop changed them since the last call, else None.

The tracker goes on from these, so the map must follow before the next frame: Mapper.update_poses, which needs
Options(map=dict(log="reference")).)")
      .def("trajectory", &trajectory,
           "(times (N,) float64 s, poses (N, 4, 4) float64 world_from_camera) of the frames that were kept.")
      .def_property_readonly(
          "loops", &loops,
          "Places that were recognised: dicts of frame, earlier_frame, earlier_from_frame, moved_m, is_believed, corrects.")
      .def_property_readonly("keyframes", [](Tracker& t) {
        const Use use(t.use);
        return t.tracker.keyframes();
      });

  m.def(
      "read_trajectory",
      [](const fs::path& path) {
        const std::vector<StampedPose> poses = released([&] { return read_trajectory(path); });
        return py::make_tuple(times_of(poses), matrices_of(poses));
      },
      py::arg("path"),
      "Reads `time tx ty tz qx qy qz qw` a line: (times (N,) float64 s, poses (N, 4, 4) float64), in the order of time.");
  m.def("score_trajectory", &score, py::arg("estimate"), py::arg("truth"), py::kw_only(),
        py::arg("most_apart_s") = TrajectoryOptions{}.most_apart_s, py::arg("step_s") = TrajectoryOptions{}.step_s,
        R"(How far an estimated trajectory is from the true one, as the tools of the TUM RGB-D benchmark measure it.

estimate, truth: (times (N,), poses (N, 4, 4)), or the path of a file as read_trajectory reads it. most_apart_s: between the two stamps
of a pair. step_s: of the relative error. A dict: poses, true_poses, way_m, absolute_m (ATE, after rigid alignment without scale),
relative_m and relative_deg (RPE; each with count, rmse, mean, median, standard_deviation, least, most; all None where no two poses lie step_s apart), truth_from_estimate (4, 4).)");
}

}  // namespace panoptic::python
