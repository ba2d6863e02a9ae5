// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Simulated homes, two maps of one place, and the evidence of a run on disk.
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
#include "bindings/python/objects.h"
#include "bindings/python/values.h"
#include "panoptic/evidence.h"
#include "panoptic/map_pairs.h"
#include "panoptic/parallel.h"
#include "panoptic/simulation.h"

namespace panoptic::python {
namespace {

namespace fs = std::filesystem;

// Ctrl-C ends it, and leaves nothing.
void make_home(const fs::path& folder, const py::object& progress, const py::kwargs& settings) {
  std::vector<std::string> assignments;
  for (const auto& [key, value] : settings) {
    const std::string name = py::str(key);
    const bool is_text = name == "seed" || name == "noise" || name == "predictions";
    assignments.push_back(fmt::format("{}={}", name, is_text ? std::string(py::str(value)) : toml_value(value, name)));
  }
  std::optional<py::error_already_set> raised;
  const auto watch = [&](std::size_t done, std::size_t frames) {
    const py::gil_scoped_acquire lock;
    if (is_ending()) return false;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!progress.is_none()) progress(done, frames);
    } catch (py::error_already_set& e) {
      raised.emplace(std::move(e));
    }
    return !raised.has_value();
  };
  const bool whole = released([&] { return simulate(folder, assignments, watch); });
  if (raised) throw std::move(*raised);
  if (!whole) throw Error("the program is ending: the home is not written");
}

py::list votes_of(const RunObject& o) {
  py::list stretches;
  for (const RunObject::Votes& v : o.votes) {
    const py::dict classes(py::cast(std::map(v.of_class.begin(), v.of_class.end())));
    stretches.append(py::dict(py::arg("first_frame") = v.first_frame, py::arg("classes") = classes));
  }
  return stretches;
}

py::list views_of(const RunObject& o) {
  py::list views;
  for (const RunObject::View& v : o.best_views) {
    views.append(py::dict(py::arg("frame") = v.frame, py::arg("class") = v.class_name, py::arg("score") = v.score,
                          py::arg("visible_px") = v.visible_px,
                          py::arg("box") = py::make_tuple(v.box.u0, v.box.v0, v.box.u1, v.box.v1)));
  }
  return views;
}

py::dict explain(const fs::path& folder, std::uint32_t id) {
  const Evidence evidence = released([&] { return read_evidence(folder, static_cast<PanopticId>(id)); });
  const RunObject& o = evidence.object;
  py::dict answer;
  answer["id"] = number(o.id);
  answer["class"] = o.class_name;
  answer["probabilities"] = std::map(o.probabilities.begin(), o.probabilities.end());
  answer["observations"] = o.observations;
  answer["first_frame"] = o.first_frame;
  answer["last_frame"] = o.last_frame;
  answer["frames_per_stretch"] = o.frames_per_bin;
  answer["votes"] = votes_of(o);
  answer["best_views"] = views_of(o);
  answer["min_m"] = vector_of(o.min_m);
  answer["max_m"] = vector_of(o.max_m);
  answer["area_m2"] = o.area_m2;
  answer["history"] = o.history;
  answer["text"] = to_text(evidence);
  return answer;
}

py::object object_or_none(const std::optional<FoundObject>& object, const LabelSet& labels) {
  return object ? py::cast(named(*object, labels)) : py::none();
}

// The later map in the world of the earlier one, if that is asked for, and how it lay.
struct ComparedMaps {
  MapWithFrames before;
  MapWithFrames after;
  std::optional<MapAlignment> alignment;
};

ComparedMaps compared_maps(const fs::path& a, const fs::path& b, bool align) {
  ComparedMaps maps{load_map_with_frames(a), load_map_with_frames(b), std::nullopt};
  if (!align) return maps;
  maps.alignment = align_maps(maps.before, maps.after, a.string(), b.string());
  maps.after = moved_map(maps.after, maps.alignment->a_from_b);
  return maps;
}

py::object alignment_or_none(const std::optional<MapAlignment>& alignment) {
  if (!alignment) return py::none();
  return py::dict(py::arg("a_from_b") = matrix_of(alignment->a_from_b), py::arg("agreement") = alignment->agreement,
                  py::arg("common_m2") = alignment->common_m2, py::arg("objects") = alignment->objects);
}

py::dict diff(const fs::path& a, const fs::path& b, bool align) {
  const ComparedMaps maps = released([&] { return compared_maps(a, b, align); });
  const auto& before = maps.before;
  const auto& after = maps.after;
  const MapDiff found = released([&] { return diff_maps(before, after, a.string(), b.string()); });
  warn(found.notes);
  py::list changes;
  for (const ObjectChange& change : found.changes) {
    py::dict entry;
    entry["kind"] = std::string(name_of(change.kind));
    entry["before"] = object_or_none(change.before, before.saved.map.labels);
    entry["after"] = object_or_none(change.after, after.saved.map.labels);
    entry["empty_share"] = change.empty_share;
    entry["moved_m"] = change.moved_m;
    changes.append(std::move(entry));
  }
  return py::dict(
      py::arg("changes") = changes, py::arg("unchanged") = found.unchanged, py::arg("too_small") = found.too_small,
      py::arg("alignment") = alignment_or_none(maps.alignment),
      py::arg("surfaces") = py::dict(py::arg("common") = found.shift.common, py::arg("apart_median_m") = found.shift.median_m,
                                     py::arg("apart_p95_m") = found.shift.p95_m));
}

py::dict merge(const fs::path& a, const fs::path& b, const fs::path& merged, bool align) {
  const MergedFiles files = released([&] { return merge_map_files(a, b, merged, align); });
  warn(files.notes);
  return py::dict(py::arg("objects_a") = files.objects_a, py::arg("objects_b") = files.objects_b,
                  py::arg("objects") = files.objects, py::arg("same") = files.same, py::arg("parts") = files.parts,
                  py::arg("blocks") = files.blocks, py::arg("alignment") = alignment_or_none(files.alignment));
}

void set_threads(int threads) {
  constexpr int kMost = 1024;  // as for the program
  if (threads < 0 || threads > kMost) throw Error(fmt::format("threads are 0, for one per core, up to {}", kMost));
  if (work_in_progress > 0) throw Error("the number of threads is set before work starts, and some is in progress");
  set_thread_count(threads);
  if (threads > 1 && thread_count() != threads) {
    throw Error(
        "this process is a child of os.fork, whose parent had threads, and maps on one: start it with multiprocessing's "
        "\"spawn\" for more");
  }
}

}  // namespace

void bind_tools(py::module_& m) {
  m.def("simulate", &make_home, py::arg("folder"), py::arg("progress") = py::none(),
        R"(Writes a simulated home as a ScanNet scan with truth and predictions: simulate("home", seed=7, rooms=2, frames=300).

Settings by name: seed, rooms, frames (0: as many as the way through the rooms takes), noise, predictions, jpeg_quality, truth_stride. progress(done, frames) is called meanwhile.)");
  m.def("explain", &explain, py::arg("folder"), py::arg("id"),
        "Why an object of a run on disk is what it is: a dict of votes, best views, boxes, mergers, and a text for people.");
  m.def("diff_maps", &diff, py::arg("before"), py::arg("after"), py::arg("align") = false,
        R"(What changed between two map files of one place: a dict.

changes: a list of dicts with kind ("vanished", "appeared", "moved", "other_label", "not_seen_in_b", "not_seen_in_a"), before, after,
empty_share and moved_m. unchanged: how many objects are at their place. too_small: how many are too small to say so. align=True brings `after` into the world of
`before` first; alignment says how: a_from_b [4,4], agreement, common_m2, objects; else it is None.)");
  m.def("merge_maps", &merge, py::arg("a"), py::arg("b"), py::arg("merged"), py::arg("align") = false,
        "Makes one map file of two of the same place; returns counts. align=True brings b into the world of a first; alignment "
        "says "
        "how, as for diff_maps.");
  m.def("set_threads", &set_threads, py::arg("threads"), "Threads that mapping may use; 0 = one per core. Before work starts.");
  m.def("threads", &thread_count, "How many threads mapping uses.");
}

}  // namespace panoptic::python
