// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/online.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "bindings/python/arrays.h"
#include "bindings/python/mapper.h"
#include "bindings/python/mesh.h"
#include "bindings/python/predictors.h"

namespace panoptic::python {
namespace {

// A pipeline with what it works on. It has the mapper from its beginning to its end.
class PythonPipeline {
 public:
  PythonPipeline(std::shared_ptr<PythonMapper> mapper, py::object predictor);
  ~PythonPipeline();
  PythonPipeline(const PythonPipeline&) = delete;
  PythonPipeline& operator=(const PythonPipeline&) = delete;

  bool push(const py::object& frame, const FrameArrays& arrays, bool wait);
  void skip(std::int64_t index, const std::string& reason);
  void stop(const std::string& why) { pipeline_->stop(why); }
  bool stopped() const { return ended_ || pipeline_->stopped(); }
  py::dict finish();
  PublishedMap published() const {
    return released([&] { return pipeline_->published(); });
  }
  const LabelSet& labels() const { return mapper_->mapper.map().labels; }

  // Ends every pipeline that still works: before Python goes.
  static void end_all();
  // In a child of fork: they are none of its own.
  static void forget_all() { going().clear(); }

 private:
  void take_parts();
  void give_back_parts();
  void end();
  void require_going() const;

  static std::set<PythonPipeline*>& going();

  std::shared_ptr<PythonMapper> mapper_;
  py::object predictor_;  // keeps it, and what is Python of it
  SharedPredictor* seeing_ = nullptr;
  WithThreads<OnlinePipeline> pipeline_;
  std::unique_ptr<WorkInProgress> in_progress_;
  Exclusive ending_{"end of the pipeline"};
  OnlineReport report_;
  bool ended_ = false;
};

std::set<PythonPipeline*>& PythonPipeline::going() {
  static std::set<PythonPipeline*> pipelines;
  return pipelines;
}

PythonPipeline::PythonPipeline(std::shared_ptr<PythonMapper> mapper, py::object predictor)
    : mapper_(std::move(mapper)), predictor_(std::move(predictor)) {
  if (!predictor_.is_none() && !py::isinstance<SharedPredictor>(predictor_)) throw Error("predictor must be a Predictor or None");
  if (!predictor_.is_none()) seeing_ = predictor_.cast<SharedPredictor*>();
  if (mapper_->finished) throw Error("the mapper is finished: no more can be added, so make a new one");
  take_parts();
  try {
    pipeline_ = WithThreads(released([&] {
      return std::make_unique<OnlinePipeline>(OnlinePipeline::Parts{mapper_->mapper, seeing_}, mapper_->options.online);
    }));
  } catch (...) {
    give_back_parts();
    throw;
  }
  in_progress_ = std::make_unique<WorkInProgress>();
  going().insert(this);
}

void PythonPipeline::take_parts() {
  constexpr const char* kUser = "an online pipeline (until its finish)";
  mapper_->use->take(kUser);
  if (seeing_ == nullptr) return;
  try {
    seeing_->use.take(kUser);
  } catch (...) {
    mapper_->use->give_back();
    throw;
  }
}

void PythonPipeline::give_back_parts() {
  mapper_->use->give_back();
  if (seeing_ != nullptr) seeing_->use.give_back();
}

PythonPipeline::~PythonPipeline() {
  if (ended_ || pipeline_.is_lost()) return;
  pipeline_->stop("abandoned");
  end();
}

// Threads of the pipeline may wait for Python's lock, so it is given away.
void PythonPipeline::end() {
  OnlinePipeline& pipeline = *pipeline_;
  ended_ = true;
  going().erase(this);
  report_ = released([&] { return pipeline.finish(); });
  mapper_->finished = true;
  give_back_parts();
  in_progress_.reset();
}

void PythonPipeline::end_all() {
  while (!going().empty()) {
    PythonPipeline& pipeline = **going().begin();
    const py::object kept_meanwhile = py::cast(&pipeline);  // whoever has it may let go of it
    pipeline.pipeline_->stop("the program ended");
    pipeline.end();
  }
}

void PythonPipeline::require_going() const {
  if (ended_) throw Error("the pipeline is finished: nothing can be pushed any more");
}

bool PythonPipeline::push(const py::object& frame, const FrameArrays& arrays, bool wait) {
  require_going();
  const GivenFrame given(frame, arrays);
  // Pixels that Python lent are copied there: whoever pushed may use his memory again.
  return released([&] { return wait ? pipeline_->push_when_free(*given) : pipeline_->push(*given); });
}

void PythonPipeline::skip(std::int64_t index, const std::string& reason) {
  require_going();
  released([&] { pipeline_->skip({index, reason}); });
}

std::string message_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "an unknown failure";
  }
}

py::dict PythonPipeline::finish() {
  const Use use(ending_, "another finish");
  if (!ended_) {
    end();
    if (seeing_ != nullptr) warn(seeing_->take_warnings());
  }
  if (report_.failure) {
    const auto* python = dynamic_cast<PythonPredictor*>(seeing_);
    py::object error = py::module_::import("panoptic").attr("Error")(message_of(report_.failure));
    if (python != nullptr && !python->raised().is_none()) error.attr("__cause__") = python->raised();
    PyErr_SetObject(py::type::handle_of(error).ptr(), error.ptr());
    throw py::error_already_set();
  }
  py::dict answer;
  answer["read"] = report_.read;
  answer["used"] = report_.used;
  answer["skipped"] = report_.skipped;
  answer["dropped"] = report_.dropped;
  answer["lost"] = report_.lost;
  answer["labelled"] = report_.labelled;
  answer["passed_over"] = report_.passed_over;
  answer["geometry_hz"] = report_.geometry_hz;
  answer["label_hz"] = report_.label_hz;
  answer["latency"] = stage_times(report_.latency);
  answer["stopped_by"] = report_.stopped_by;
  return answer;
}

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

// Before Python goes: what is at work ends, and only then threads may be cut off.
void end_work() {
  ending_in = std::this_thread::get_id();
  PythonPipeline::end_all();
  const py::gil_scoped_release release;
  while (work_in_progress > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
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
          const py::object& pose, const py::object& color_k, const py::object& color_from_depth,
          std::optional<double> depth_scale, std::int64_t index, double time_s) {
  return self.push(frame, {depth, color, k, pose, color_k, color_from_depth, depth_scale, index, time_s}, kWait);
}

template <bool kWait>
void bind_push(py::class_<PythonPipeline>& pipeline, const char* name, const char* help) {
  pipeline.def(name, &push<kWait>, py::arg("frame") = py::none(), py::kw_only(), py::arg("depth") = py::none(),
               py::arg("color") = py::none(), py::arg("K") = py::none(), py::arg("pose") = py::none(),
               py::arg("color_K") = py::none(), py::arg("color_from_depth") = py::none(), py::arg("depth_scale") = py::none(),
               py::arg("index") = 0, py::arg("time_s") = 0.0, help);
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

  py::class_<PythonPipeline> pipeline(m, "OnlinePipeline", R"(Maps while frames arrive, every stage on a thread of its own.

OnlinePipeline(mapper, predictor=None). The mapper belongs to it until finish. Any thread may push.)");
  pipeline.def(py::init<std::shared_ptr<PythonMapper>, py::object>(), py::arg("mapper"), py::arg("predictor") = py::none());
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
