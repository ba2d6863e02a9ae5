// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Files of corrected poses, for Mapper.update_poses.
#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <vector>

#include "bindings/python/arrays.h"
#include "panoptic/pose_update.h"

namespace panoptic::python {
namespace {

namespace fs = std::filesystem;

py::dict dict_of(const std::vector<PoseUpdate>& poses) {
  py::dict dict;
  for (const PoseUpdate& update : poses) dict[py::int_(update.frame)] = matrix_of(update.world_from_camera);
  return dict;
}

py::list updates(const fs::path& path) {
  py::list list;
  for (const PoseUpdates& moment : released([&] { return read_pose_updates(path); })) {
    list.append(py::make_tuple(moment.at_frame, dict_of(moment.poses)));
  }
  return list;
}

py::dict corrected(const fs::path& path, const std::map<std::int64_t, double>& times) {
  std::vector<FrameTime> frames;
  for (const auto& [frame, time_s] : times) {
    if (!std::isfinite(time_s)) throw Error(fmt::format("the time of frame {} is not finite", frame));
    frames.push_back({frame, time_s});
  }
  const CorrectedPoses found = released([&] { return read_corrected_poses(path, frames); });
  if (found.left_over > 0) warn({fmt::format("{}: {} poses are of none of the frames", path.string(), found.left_over)});
  return dict_of(found.poses);
}

}  // namespace

void bind_poses(py::module_& m) {
  m.def(
      "read_pose_updates", &updates, py::arg("path"),
      R"(Reads corrections as `panoptic run --pose-updates` does: a list of (at_frame, {frame index: (4, 4) world_from_camera}).)");
  m.def("read_corrected_poses", &corrected, py::arg("path"), py::arg("times"),
        R"(Reads a trajectory of a SLAM system, `time x y z qx qy qz qw`, or with frames instead of times: {frame index: (4, 4)}.

times: {frame index: seconds} of the frames that were mapped. A pose is of the frame nearest in time, at most 20 ms away.)");
}

}  // namespace panoptic::python
