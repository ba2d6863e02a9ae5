// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/map.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/labels.h"
#include "bindings/python/mesh.h"
#include "bindings/python/objects.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/navigation.h"
#include "panoptic/run_outputs.h"
#include "panoptic/surface.h"

namespace panoptic::python {
namespace {

struct Block {
  std::shared_ptr<MapView> view;
  Slot slot;
  BlockIndex index;
};

std::shared_ptr<MapView> load(const std::filesystem::path& path) {
  auto [saved, frames] = released([&] { return std::pair(std::make_shared<SavedMap>(load_map(path)), load_frames(path)); });
  if (const std::string note = note_of_format(*saved, path); !note.empty()) warn({note});
  Options options = options_of(*saved);
  options.map = saved->options;
  const PanopticMap& map = saved->map;
  const std::optional<Vec3d> up = noted_up(*saved);
  auto view = std::make_shared<MapView>(
      MapView{std::move(saved), map, std::make_shared<Exclusive>("map"), std::move(options), std::move(frames), true});
  view->noted_up = up;
  return view;
}

// Asks the map as it is now.
template <typename Question>
auto ask(MapView& view, const Question& question) {
  const Use use(*view.use);
  if (!view.is_fixed) {
    const MapQuery query = released([&] { return MapQuery(view.map); });
    return question(query);
  }
  if (!view.query) released([&] { view.query.emplace(view.map); });
  return question(*view.query);
}

std::vector<NamedObject> all_named(const std::vector<FoundObject>& objects, const MapView& view) {
  std::vector<NamedObject> list;
  for (const FoundObject& object : objects) list.push_back(named(object, view.map.labels));
  return list;
}

std::vector<NamedObject> objects(MapView& view, const py::object& class_) {
  if (class_.is_none()) return ask(view, [&](const MapQuery& query) { return all_named(query.objects(), view); });
  const std::string name = py::isinstance<py::str>(class_)
                               ? std::string(py::str(class_))
                               : std::string(view.map.labels.name_of(class_from(class_, &view.map.labels)));
  return ask(view, [&](const MapQuery& query) { return all_named(query.of_class(name), view); });
}

std::vector<NamedObject> in_box(MapView& view, const py::object& min_m, const py::object& max_m) {
  const Vec3d low = point_from(min_m, "min_m");
  const Vec3d high = point_from(max_m, "max_m");
  if ((low.array() > high.array()).any()) throw Error("min_m is above max_m along an axis");
  return ask(view, [&](const MapQuery& query) { return all_named(query.in_box(low, high), view); });
}

std::vector<std::pair<NamedObject, double>> nearest(MapView& view, const py::object& point, std::int64_t count) {
  if (count < 0) throw Error("count is below zero");
  const Vec3d place = point_from(point, "point");
  return ask(view, [&](const MapQuery& query) {
    std::vector<std::pair<NamedObject, double>> list;
    for (const NearObject& near : query.nearest(place, static_cast<std::size_t>(count))) {
      list.emplace_back(named(near.object, view.map.labels), near.distance_m);
    }
    return list;
  });
}

std::optional<PointAnswer> at(MapView& view, const py::object& point) {
  const Vec3d place = point_from(point, "point");
  return ask(view, [&](const MapQuery& query) { return query.at(place); });
}

std::vector<Block> blocks(const std::shared_ptr<MapView>& view) {
  const Use use(*view->use);
  std::vector<Block> list;
  for (Slot slot = 0; slot < view->map.voxels.block_count(); ++slot)
    list.push_back({view, slot, view->map.voxels.index_of(slot)});
  return list;
}

std::string hash(const MapView& view) {
  const Use use(*view.use);
  return fmt::format("{:016x}", released([&] { return view.map.voxels.hash(); }));
}

std::shared_ptr<LabelledMesh> surface(const MapView& view) {
  const Use use(*view.use);
  return std::make_shared<LabelledMesh>(
      LabelledMesh{released([&] { return surface_of(view.map, view.options.mesher); }), view.map.labels});
}

// A copy of a property of the 16^3 voxels, indexed [x, y, z].
template <typename To, typename Property>
py::array voxels(const Block& block, const Property& property) {
  const Use use(*block.view->use);
  const VoxelBlock& from = block.view->map.voxels.block(block.slot);
  py::array_t<To, py::array::f_style> array({kBlockSide, kBlockSide, kBlockSide});
  for (int offset = 0; offset < kBlockVoxels; ++offset) array.mutable_data()[offset] = property(from, offset);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

py::array floats(const Block& block, float (VoxelBlock::*property)(int offset) const) {
  return voxels<float>(block, [&](const VoxelBlock& from, int offset) { return (from.*property)(offset); });
}

template <typename To, typename Name>
py::array named_labels(const Block& block, const Name& name) {
  return voxels<To>(block,
                    [&](const VoxelBlock& from, int offset) { return number(name(static_cast<LabelSlot>(from.label(offset)))); });
}

py::array colors(const Block& block) {
  const Use use(*block.view->use);
  const VoxelBlock& from = block.view->map.voxels.block(block.slot);
  py::array_t<std::uint8_t> array({kBlockSide, kBlockSide, kBlockSide, 3});
  auto out = array.mutable_unchecked<4>();
  for (int offset = 0; offset < kBlockVoxels; ++offset) {
    const int x = offset % kBlockSide;
    const int y = offset / kBlockSide % kBlockSide;
    const int z = offset / kBlockSide / kBlockSide;
    const Voxel voxel = from.at(offset);
    out(x, y, z, 0) = static_cast<std::uint8_t>(voxel.red >> 8);
    out(x, y, z, 1) = static_cast<std::uint8_t>(voxel.green >> 8);
    out(x, y, z, 2) = static_cast<std::uint8_t>(voxel.blue >> 8);
  }
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

py::tuple index_of(const Block& block) { return py::make_tuple(block.index.x, block.index.y, block.index.z); }

py::array origin_of(const Block& block) {
  return vector_of(Vec3d(block.index.x, block.index.y, block.index.z) * double{block.view->map.voxels.block_size_m()});
}

void bind_blocks(py::module_& m) {
  py::class_<Block>(m, "Block", R"(16 x 16 x 16 voxels. The arrays are copies, indexed [x, y, z], and cannot be written to.

The centre of voxel (x, y, z) lies at origin_m + ((x, y, z) + 0.5) * voxel_size_m.)")
      .def_property_readonly("index", &index_of, "(x, y, z), in blocks.")
      .def_property_readonly("origin_m", &origin_of, "(3,) float64, the corner of voxel (0, 0, 0), metres.")
      .def_property_readonly(
          "distance", [](const Block& b) { return floats(b, &VoxelBlock::distance); },
          "(16, 16, 16) float32, to the nearest surface, metres, positive in front of it.")
      .def_property_readonly(
          "weight", [](const Block& b) { return floats(b, &VoxelBlock::weight); }, "(16, 16, 16) float32, 0 = never observed.")
      .def_property_readonly(
          "label_weight", [](const Block& b) { return floats(b, &VoxelBlock::label_weight); }, "(16, 16, 16) float32.")
      .def_property_readonly(
          "vote_sum", [](const Block& b) { return floats(b, &VoxelBlock::vote_sum); }, "(16, 16, 16) float32.")
      .def_property_readonly(
          "panoptic_id",
          [](const Block& b) {
            return named_labels<std::uint32_t>(b, [&](LabelSlot slot) { return b.view->map.objects.id_of(slot); });
          },
          "(16, 16, 16) uint32, as Mesh.panoptic_id.")
      .def_property_readonly(
          "class_id",
          [](const Block& b) {
            return named_labels<std::uint16_t>(b, [&](LabelSlot slot) { return b.view->map.class_of(slot); });
          },
          "(16, 16, 16) uint16, 0 = unknown.")
      .def_property_readonly("color", &colors, "(16, 16, 16, 3) uint8, red first.")
      .def("__repr__", [](const Block& b) { return fmt::format("<Block {}>", std::string(py::str(index_of(b)))); });
}

std::uint32_t node(const MapView& view, const std::string& name) {
  const Use use(*view.use);
  return number(node_named(view.map, name));
}

py::object up(const MapView& view) {
  const Use use(*view.use);
  const std::optional<Vec3d> up = up_of(view);
  return up ? py::object(vector_of(*up)) : py::none();
}

py::list frame_list(const MapView& view) {
  py::list list;
  for (const FrameRecord& frame : view.frames) {
    py::dict entry;
    entry["frame"] = frame.frame;
    entry["time_s"] = frame.time_s;
    entry["pose"] = frame.world_from_camera ? py::object(matrix_of(*frame.world_from_camera)) : py::none();
    entry["labelled"] = frame.labelled;
    entry["unused_because"] = frame.unused_because;
    list.append(std::move(entry));
  }
  return list;
}

py::dict dict_of(const ObjectSpan& span, const LabelSet& labels) {
  return py::dict(py::arg("id") = number(span.id), py::arg("class_id") = number(span.class_id),
                  py::arg("class_name") = std::string(labels.name_of(span.class_id)),
                  py::arg("min_m") = vector_of(span.box.min_m), py::arg("max_m") = vector_of(span.box.max_m),
                  py::arg("first_s") = span.first_s, py::arg("gone_s") = span.gone_s, py::arg("appeared") = span.appeared,
                  py::arg("moved_from") = id_or_none(span.moved_from), py::arg("moved_to") = id_or_none(span.moved_to));
}

// The frames of the map: of the file, or of the mapper so far.
std::vector<FrameRecord> frames_of(const MapView& view) {
  if (view.mapper == nullptr) return view.frames;
  std::vector<FrameRecord> frames;
  for (const TimedPose& pose : view.mapper->frames().trajectory()) {
    FrameRecord& frame = frames.emplace_back();
    frame.frame = pose.frame;
    frame.time_s = pose.time_s;
  }
  return frames;
}

py::list history(const MapView& view, std::optional<double> when, std::optional<double> changes_since) {
  const Use use(*view.use);
  if (when && changes_since) throw Error("give `when` or `changes_since`, not both");
  if (!std::isfinite(when.value_or(0)) || !std::isfinite(changes_since.value_or(0))) throw Error("the time is not finite");
  std::vector<ObjectSpan> spans = released([&] { return object_spans(view.map, frames_of(view)); });
  if (when) spans = present_at(spans, *when);
  if (changes_since) spans = changed_since(spans, *changes_since);
  py::list list;
  for (const ObjectSpan& span : spans) list.append(dict_of(span, view.map.labels));
  return list;
}

}  // namespace

void bind_map(py::module_& m) {
  bind_objects(m);
  bind_blocks(m);
  bind_free_space(m);
  py::class_<MapView, std::shared_ptr<MapView>>(m, "Map", R"(A map to ask: what is where. Metres, world of the poses.

load_map gives one, and Mapper.map is one that shows the mapper's state whenever it is asked.)")
      .def("objects", &objects, py::arg("class_") = py::none(),
           R"(Objects with surface, ascending by id; those of a class, by its name or number. "unknown": of no known class.)")
      .def("in_box", &in_box, py::arg("min_m"), py::arg("max_m"), "Objects whose boxes share a point with this one.")
      .def("nearest", &nearest, py::arg("point"), py::arg("count") = 1, "[(object, distance in metres)], the nearest first.")
      .def("at", &at, py::arg("point"), "What the map holds at a point, or None where nothing was observed.")
      .def(
          "explain",
          [](MapView& v, const py::object& id) {
            const Use use(*v.use);
            return explain_object(v.map, object_number(id));
          },
          py::arg("id"), "Why an object is what it is: a dict of probabilities, votes over time, best views and parts.")
      .def("history", &history, py::arg("when") = py::none(), py::arg("changes_since") = py::none(),
           R"(When objects were there, those that are gone included, ascending by id. Times are seconds of the recording.

when: those that were there at that time. changes_since: those that came, were moved or were found to be gone after it. A dict each: id,
class_id, class_name, min_m, max_m (its last place), first_s, gone_s (None: it is there), appeared (it came to a place that had been
free), moved_from and moved_to (ids; None).)")
      .def("blocks", &blocks, "Every block of voxels, in the order of their making.")
      .def("hash", &hash, "A fingerprint of every voxel bit, as `map_hash` in report.json.")
      .def("mesh", &surface, "The surface, anew at each call; Mapper.mesh does only what changed.")
      .def(
          "node_named", &node, py::arg("name"),
          R"(The id that a node of scene.glb is called after: "chair_31", "floor". An object that was merged is the one it is a part of.)")
      .def_property_readonly(
          "free_space", [](const std::shared_ptr<MapView>& v) { return FreeSpaceView{v}; },
          "A FreeSpace: the space that was seen to be empty.")
      .def_property_readonly("up", &up, "(3,) float64, upwards in the world as the cameras were held; None if nobody knows.")
      .def_property_readonly("labels", [](const MapView& v) { return v.map.labels; })
      .def_property_readonly(
          "options", [](const MapView& v) { return v.options; }, "Of the run that made it.")
      .def_property_readonly("voxel_size_m", [](const MapView& v) { return v.map.voxels.voxel_size_m(); })
      .def_property_readonly("truncation_m", [](const MapView& v) { return v.map.voxels.truncation_m(); })
      .def_property_readonly("frames", &frame_list,
                             "What became of each frame, as the map file lists them; empty for a mapper's map.")
      .def("__repr__", [](const MapView& v) {
        const Use use(*v.use);
        return fmt::format("<Map of {} blocks and {} objects>", v.map.voxels.block_count(), v.map.objects.count());
      });
  m.def("load_map", &load, py::arg("path"), "Loads a map file (`panoptic run --map`, Mapper.save).");
}

}  // namespace panoptic::python
