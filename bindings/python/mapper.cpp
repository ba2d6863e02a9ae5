// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/mapper.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/labels.h"
#include "bindings/python/map.h"
#include "bindings/python/mesh.h"
#include "bindings/python/segments.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/run_outputs.h"
#include "panoptic/simulation.h"

namespace panoptic::python {
namespace {

using SharedMapper = std::shared_ptr<PythonMapper>;

SharedMapper make(const Options& options, const py::object& labels) {
  return std::make_shared<PythonMapper>(options, labels_from(labels, options.labels.empty() ? "indoor" : options.labels));
}

void require_unfinished(const PythonMapper& self) {
  if (self.finished) throw Error("the mapper is finished: no more can be added, so make a new one");
}

Outcome add(PythonMapper& self, const py::object& frame, const py::object& segments, const FrameArrays& arrays) {
  const Use use(*self.use);
  require_unfinished(self);
  const LabelSet& labels = self.mapper.map().labels;
  const GivenFrame given(frame, self.numbered(arrays));
  self.next_index = (*given).index + 1;
  const std::shared_ptr<const Segmentation> segmentation = segmentation_from(segments, labels);
  require_sound(*segmentation, labels);
  const Outcome fits = check(*segmentation, (*given).color.width(), (*given).color.height());
  if (!fits.used) throw Error(fits.reason);
  return released([&] { return self.mapper.add(*given, *segmentation); });
}

void skip(PythonMapper& self, std::int64_t index, const std::string& reason) {
  const Use use(*self.use);
  require_unfinished(self);
  self.mapper.skip({index, reason});
}

void regularize(PythonMapper& self) {
  const Use use(*self.use);
  require_unfinished(self);
  released([&] { self.mapper.regularize(); });
}

void finish(PythonMapper& self) {
  const Use use(*self.use);
  require_unfinished(self);
  self.finished = true;
  released([&] { self.mapper.finish(); });
}

// Reads a frame by what Python has for that.
ReadResult read_by(const py::object& read, std::int64_t frame) {
  const py::gil_scoped_acquire lock;
  try {
    const py::object given = read(frame);
    if (!py::isinstance<Frame>(given)) return {std::nullopt, {frame, "`read` must return a Frame"}};
    ReadResult result{kept(*given.cast<std::shared_ptr<Frame>>()), {}};
    result.frame->index = frame;
    return result;
  } catch (const std::exception& e) {
    return {std::nullopt, {frame, e.what()}};
  }
}

py::dict update_poses(PythonMapper& self, const py::dict& poses, const py::object& read) {
  const Use use(*self.use);
  std::vector<PoseUpdate> updates;
  for (const auto& [frame, pose] : poses) updates.push_back({frame.cast<std::int64_t>(), pose_from(pose, "pose")});
  const ReadFrame read_frame = [&](std::int64_t frame) { return read_by(read, frame); };
  const bool can_read = !read.is_none();
  const Correction c = released([&] { return self.mapper.update_poses(updates, can_read ? read_frame : ReadFrame()); });
  return py::dict(py::arg("frames") = c.frames, py::arg("unknown") = c.unknown, py::arg("blocks") = c.blocks,
                  py::arg("blocks_refused") = c.blocks_refused, py::arg("ms") = c.ms, py::arg("wait_ms") = c.wait_ms,
                  py::arg("pause_ms") = c.pause_ms);
}

std::shared_ptr<LabelledMesh> mesh(PythonMapper& self) {
  const Use use(*self.use);
  return std::make_shared<LabelledMesh>(LabelledMesh{released([&] { return self.mapper.mesh(); }), self.mapper.map().labels});
}

std::shared_ptr<MapView> map(const SharedMapper& self) {
  auto view = std::make_shared<MapView>(MapView{self, self->mapper.map(), self->use, self->options});
  view->mapper = &self->mapper;
  return view;
}

std::string hash(const PythonMapper& self) {
  const Use use(*self.use);
  return fmt::format("{:016x}", released([&] { return self.mapper.map().voxels.hash(); }));
}

py::dict frames(const PythonMapper& self) {
  const Use use(*self.use);
  const FrameStatistics& statistics = self.mapper.frames();
  py::dict answer;
  answer["used"] = statistics.used();
  answer["labelled"] = self.mapper.labelled();
  answer["skipped"] = statistics.skipped();
  answer["skipped_by_reason"] = statistics.skipped_by_reason();
  py::list first;
  for (const SkippedFrame& frame : statistics.first_skipped()) first.append(py::make_tuple(frame.index, frame.reason));
  answer["first_skipped"] = first;
  return answer;
}

py::tuple trajectory(const PythonMapper& self) {
  const Use use(*self.use);
  const std::vector<TimedPose>& poses = self.mapper.frames().trajectory();
  return py::make_tuple(times_of(poses), matrices_of(poses));
}

// A row of three numbers for each box.
py::array corners(const std::vector<TrackedBox>& boxes, Vec3d TrackedBox::*corner) {
  std::vector<Vec3d> points;
  for (const TrackedBox& box : boxes) points.push_back(box.*corner);
  return rows_of(points);
}

py::list moving_tracks(const PythonMapper& self) {
  const Use use(*self.use);
  py::list list;
  for (const MovingTrack& track : self.mapper.moving_tracks()) {
    std::vector<std::int64_t> frames;
    std::vector<double> times_s;
    for (const TrackedBox& box : track.boxes) {
      frames.push_back(box.frame);
      times_s.push_back(box.time_s);
    }
    list.append(py::dict(py::arg("id") = track.id, py::arg("class_id") = number(track.class_id),
                         py::arg("class_name") = std::string(self.mapper.map().labels.name_of(track.class_id)),
                         py::arg("frames") = py::array_t<std::int64_t>(static_cast<py::ssize_t>(frames.size()), frames.data()),
                         py::arg("times_s") = py::array_t<double>(static_cast<py::ssize_t>(times_s.size()), times_s.data()),
                         py::arg("min_m") = corners(track.boxes, &TrackedBox::min_m),
                         py::arg("max_m") = corners(track.boxes, &TrackedBox::max_m)));
  }
  return list;
}

py::list segment_ids(const PythonMapper& self) {
  const Use use(*self.use);
  py::list ids;
  for (const PanopticId id : self.mapper.segment_ids()) ids.append(number(id));
  return ids;
}

void save(const PythonMapper& self, const std::filesystem::path& path) {
  const Use use(*self.use);
  released([&] { save_map(path, self.mapper, self.options); });
}

void save_outputs(PythonMapper& self, const std::filesystem::path& folder, const std::string& recording,
                  const std::string& calibration, const std::string& predictor, bool pictures) {
  const Use use(*self.use);
  RunSummary summary;
  const bool is_path = !recording.empty() && !recording.starts_with("sim:");
  summary.recording = is_path ? std::filesystem::absolute(recording).lexically_normal().string() : recording;
  if (!calibration.empty()) summary.calibration = std::filesystem::absolute(calibration).string();
  if (!recording.empty())
    summary.dataset = released([&] { return open_dataset(summary.recording, summary.calibration)->description(); });
  summary.predictor = predictor;
  summary.complete = self.finished;
  summary.stopped_by = self.finished ? "" : "written before the mapper was finished";
  summary.pictures = pictures;
  released([&] {
    std::filesystem::create_directories(folder);
    write_outputs(folder, self.mapper, self.options, summary);
  });
}

}  // namespace

GivenFrame::GivenFrame(const py::object& frame, const FrameArrays& arrays) {
  if (frame.is_none()) {
    made_.emplace(arrays);
    return;
  }
  if (!py::isinstance<Frame>(frame))
    throw Error("the first argument must be a Frame; arrays go by name: depth=, color=, K=, pose=");
  if (arrays.any()) throw Error("give a Frame or its arrays, not both");
  frame_ = frame.cast<std::shared_ptr<Frame>>();
}

void refuse_call(const char* name, const py::args& args, const py::kwargs& named) {
  static const std::set<std::string> kNames = {"frame",   "segments",         "depth",       "color", "K",      "pose",
                                               "color_K", "color_from_depth", "depth_scale", "index", "time_s", "depth_weight"};
  for (const auto& [key, value] : named) {
    const std::string given = py::str(key);
    if (!kNames.contains(given))
      throw Error(fmt::format("{}: there is no argument '{}'; there are {}", name, given, fmt::join(kNames, ", ")));
  }
  if (args.size() > 2) throw Error(fmt::format("{}: give a Frame, or its arrays by name: depth=, color=, K=, pose=", name));
  throw Error(fmt::format("{}: an argument was given twice", name));
}

py::dict stage_times(const Profile& profile) {
  py::dict stages;
  for (const auto& [name, times] : profile.stages()) {
    stages[py::str(name)] = py::dict(py::arg("count") = times.count(), py::arg("mean_ms") = times.mean_ms(),
                                     py::arg("p50_ms") = times.percentile_ms(0.5), py::arg("p95_ms") = times.percentile_ms(0.95),
                                     py::arg("max_ms") = times.max_ms());
  }
  return stages;
}

void bind_mapper(py::module_& m) {
  py::class_<Outcome>(m, "Outcome", "Whether a frame was used: true in conditions if it was, else `reason` says why not.")
      .def_readonly("used", &Outcome::used)
      .def_readonly("reason", &Outcome::reason)
      .def("__bool__", [](const Outcome& o) { return o.used; })
      .def("__repr__", [](const Outcome& o) { return o.used ? std::string("<used>") : fmt::format("<not used: {}>", o.reason); });

  py::class_<PythonMapper, SharedMapper>(m, "Mapper", R"(From frames and what networks see in them to one labelled map.

Mapper(options, labels="indoor"). The same frames give the same map, bit for bit. One thread at a time may use it; other threads of
Python run while it works.)")
      .def(py::init(&make), py::arg("options") = Options(), py::arg("labels") = py::none())
      .def(
          "add",
          [](PythonMapper& self, const py::object& frame, const py::object& segments, const py::object& depth,
             const py::object& color, const py::object& k, const py::object& pose, const py::object& color_k,
             const py::object& color_from_depth, const py::object& depth_scale, const py::object& index, const py::object& time_s,
             const py::object& depth_weight) {
            return add(self, frame, segments,
                       {depth, color, k, pose, color_k, color_from_depth, depth_scale, index, time_s, depth_weight});
          },
          py::arg("frame") = py::none(), py::arg("segments") = py::none(), py::kw_only(), py::arg("depth") = py::none(),
          py::arg("color") = py::none(), py::arg("K") = py::none(), py::arg("pose") = py::none(), py::arg("color_K") = py::none(),
          py::arg("color_from_depth") = py::none(), py::arg("depth_scale") = py::none(), py::arg("index") = py::none(),
          py::arg("time_s") = 0.0, py::arg("depth_weight") = py::none(),
          R"(Fuses a frame: a Frame, or its arrays by name as Frame takes them. They are read while the call lasts. Without an index a frame
has the number after the last.

segments: a Segmentation; or (ids, segments), ids (h, w) whole numbers and a list as Segmentation takes it; or (masks, classes[,
scores]), masks (N, h, w); or a panoptic image (h, w), class number * 1000 + instance; or None: labels stay as they are.
Returns an Outcome: a frame without a depth reading, say, is counted and changes nothing.)")
      .def("add",
           [](PythonMapper&, const py::args& args, const py::kwargs& named) -> Outcome { refuse_call("add", args, named); })
      .def("skip", &skip, py::arg("index"), py::arg("reason"), "Counts a frame that could not be read.")
      .def("regularize", &regularize, "Regularizes the labels of what changed; add does so every regularizer.every_frames.")
      .def("finish", &finish, "After the last frame. Nothing can be added any more; everything can be read.")
      .def("update_poses", &update_poses, py::arg("poses"), py::arg("read") = py::none(),
           R"(The map follows corrected poses: it is fused anew from all its frames, without networks, and objects keep their ids.

Needs Options(map=dict(log="copy")), which keeps depth and colour without loss, or log="reference" and read. poses: {frame index: (4, 4) world_from_camera}, for all frames or some. read(index): the
Frame of that index once more; its pose does not matter. Returns counts and times: frames (whose pose changed), unknown (indices that are
not in the map), blocks, blocks_refused, ms, wait_ms, pause_ms. Raises Error and leaves the map as it was if a frame cannot be read again.)")
      .def("mesh", &mesh, "The surface as it is now; only what changed is extracted anew.")
      .def("map_hash", &hash, "A fingerprint of every voxel bit, as `map_hash` in report.json.")
      .def("save", &save, py::arg("path"), "Saves the map as a file for load_map, query, diff, merge and the program.")
      .def("save_outputs", &save_outputs, py::arg("folder"), py::kw_only(), py::arg("recording") = "",
           py::arg("calibration") = "", py::arg("predictor") = "python", py::arg("pictures") = true,
           "Writes what `panoptic run -o FOLDER` writes: mesh.ply, scene.glb, objects.json, report.json ...")
      .def("segment_ids", &segment_ids, "Per segment of the last frame: its panoptic id in the map.")
      .def("moving_tracks", &moving_tracks,
           R"(The things that moved and were seen to in three frames or more; they are no part of the map.

A dict each: id, class_id (0: only its motion gave it away), class_name, frames (N,), times_s (N,), and the boxes around what was seen
of it, min_m and max_m (N, 3), metres, world.)")
      .def("trajectory", &trajectory,
           "(times (N,) float64 s, poses (N, 4, 4) float64 world_from_camera) of the frames that were used.")
      .def_property_readonly("map", &map, "A Map that shows the mapper's state whenever it is asked.")
      .def_property_readonly(
          "frames", &frames,
          "Counts: used, labelled, skipped, skipped_by_reason; and first_skipped, at most 1000 of (index, reason).")
      .def_property_readonly(
          "profile",
          [](const PythonMapper& self) {
            const Use use(*self.use);
            return stage_times(self.mapper.profile());
          },
          "Times of each stage, in milliseconds.")
      .def_property_readonly(
          "up",
          [](const PythonMapper& self) {
            const Use use(*self.use);
            return vector_of(self.mapper.up());
          },
          "(3,) float64: upwards in the world, as the cameras were mostly held.")
      .def_property_readonly("labels", [](const PythonMapper& self) { return self.mapper.map().labels; })
      .def_property_readonly("options", [](const PythonMapper& self) { return self.options; })
      .def_property_readonly("finished", [](const PythonMapper& self) { return self.finished; });
}

}  // namespace panoptic::python
