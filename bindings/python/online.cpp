// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Python's side of the online pipeline, and the end of all work.
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "bindings/python/arrays.h"
#include "bindings/python/mesh.h"
#include "bindings/python/pipeline.h"

namespace panoptic::python {
namespace {

// A snapshot as Python sees it; the mesh is one object, so that its arrays are views.
struct Published {
  PublishedMap map;
  std::shared_ptr<LabelledMesh> mesh;
};

std::shared_ptr<Published> newest(const PythonPipeline& pipeline) {
  auto published = std::make_shared<Published>(Published{pipeline.published(), nullptr});
  published->mesh = std::make_shared<LabelledMesh>(LabelledMesh{std::move(published->map.mesh), pipeline.labels()});
  return published;
}

py::list objects(const Published& published) {
  py::list list;
  for (const SnapshotObject& object : published.map.objects) {
    py::dict entry;
    entry["id"] = number(object.id);
    entry["class_id"] = number(object.class_id);
    entry["class_name"] = std::string(published.mesh->labels.name_of(object.class_id));
    py::dict probabilities;
    for (const ClassProbability& p : object.probabilities) {
      probabilities[py::str(std::string(published.mesh->labels.name_of(p.class_id)))] = p.probability;
    }
    entry["probabilities"] = probabilities;
    entry["observations"] = object.observations;
    entry["first_frame"] = object.first_frame;
    entry["last_frame"] = object.last_frame;
    entry["vertices"] = object.vertices;
    entry["min_m"] = vector_of(object.min_m.cast<double>());
    entry["max_m"] = vector_of(object.max_m.cast<double>());
    list.append(std::move(entry));
  }
  return list;
}

py::array path(const Published& published) {
  const auto count = static_cast<py::ssize_t>(published.map.path_m.size());
  py::array_t<float> array({count, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < count; ++i) {
    std::copy_n(published.map.path_m[static_cast<std::size_t>(i)].data(), 3, array.mutable_data() + 3 * i);
  }
  return array;
}

// Before Python goes: what is at work ends, and only then threads may be cut off. A thread that was making a pipeline has it
// only when it gets Python's lock, so pipelines may come as long as work is in progress.
void end_work() {
  ending_in = std::this_thread::get_id();
  for (;;) {
    PythonPipeline::end_all();
    if (work_in_progress == 0) return;
    const py::gil_scoped_release release;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// ONNX Runtime ends its threads when the process ends. In a child it would wait for ever, as they are the parent's: what comes
// after Python's own end is left out there.
void end_without_runtime(int status, void* /*unused*/) {
  std::fflush(nullptr);
  ::_exit(status);
}

void begin_in_child() {
  static bool is_told = false;
  if (made_networks && !is_told) is_told = ::on_exit(&end_without_runtime, nullptr) == 0;
  ++generation;
  work_in_progress = 0;
  PythonPipeline::forget_all();
}

template <bool kWait>
bool push(PythonPipeline& self, const py::object& frame, const py::object& depth, const py::object& color, const py::object& k,
          const py::object& pose, const py::object& color_k, const py::object& color_from_depth, const py::object& depth_scale,
          const py::object& index, const py::object& time_s, const py::object& depth_weight) {
  return self.push(frame, {depth, color, k, pose, color_k, color_from_depth, depth_scale, index, time_s, depth_weight}, kWait);
}

using Pipeline = py::class_<PythonPipeline, std::unique_ptr<PythonPipeline, Dropped>>;

template <bool kWait>
void bind_push(Pipeline& pipeline, const char* name, const char* help) {
  pipeline.def(name, &push<kWait>, py::arg("frame") = py::none(), py::kw_only(), py::arg("depth") = py::none(),
               py::arg("color") = py::none(), py::arg("K") = py::none(), py::arg("pose") = py::none(),
               py::arg("color_K") = py::none(), py::arg("color_from_depth") = py::none(), py::arg("depth_scale") = py::none(),
               py::arg("index") = py::none(), py::arg("time_s") = 0.0, py::arg("depth_weight") = py::none(), help);
  pipeline.def(
      name, [name](PythonPipeline&, const py::args& args, const py::kwargs& named) -> bool { refuse_call(name, args, named); });
}

}  // namespace

void bind_online(py::module_& m) {
  py::class_<Published, std::shared_ptr<Published>>(m, "Snapshot", "The map as it was published last; it stays as it is.")
      .def_property_readonly(
          "revision", [](const Published& p) { return p.map.revision; }, "Rises with each; 0 = nothing yet.")
      .def_property_readonly(
          "frame", [](const Published& p) { return p.map.frame; }, "The newest frame in it; -1 = none.")
      .def_property_readonly(
          "finished", [](const Published& p) { return p.map.finished; }, "No newer one will come.")
      .def_readonly("mesh", &Published::mesh)
      .def_property_readonly(
          "objects", &objects,
          R"(A dict for each object: id, class_id, class_name, probabilities, observations, first_frame, last_frame, vertices, min_m, max_m.)")
      .def_property_readonly("path", &path, "(N, 3) float32: where the camera was, metres.");

  Pipeline pipeline(m, "OnlinePipeline", R"(Maps while frames arrive, every stage on a thread of its own.

OnlinePipeline(mapper, predictor=None). The mapper belongs to it until finish. Any thread may push.)");
  pipeline.def(py::init<std::shared_ptr<PythonMapper>, py::object>(), py::arg("mapper").none(false),
               py::arg("predictor") = py::none());
  bind_push<false>(pipeline, "push",
                   R"(Takes a frame as it comes from a camera, a Frame or its arrays, and copies it. Never waits: False if it
was dropped because fusion is behind, or if the run is over.)");
  bind_push<true>(pipeline, "push_when_free", "The same for recordings that should be mapped whole: waits for room.");
  pipeline.def("skip", &PythonPipeline::skip, py::arg("index"), py::arg("reason"), "Counts a frame that could not be read.")
      .def("stop", &PythonPipeline::stop, py::arg("why") = "stopped", "Takes no more frames; what was taken is still mapped.")
      .def_property_readonly("stopped", &PythonPipeline::stopped)
      .def("snapshot", &newest, "The newest Snapshot, published every online.mesh_every_s.")
      .def("finish", &PythonPipeline::finish,
           R"(After the last frame: maps what was taken and finishes the mapper. Returns counts, rates and latencies.
Raises Error if a stage failed, with what the predictor raised as its cause; the map holds what was fused by then.)");
  py::module_::import("atexit").attr("register")(py::cpp_function(&end_work));
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") = py::cpp_function(&begin_in_child));
}

}  // namespace panoptic::python
