// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/objects.h"

#include <fmt/format.h>

#include <limits>

#include "bindings/python/arrays.h"

namespace panoptic::python {
namespace {

py::str name_of(ClassId id, const LabelSet& labels) { return std::string(labels.name_of(id)); }

py::list votes_of(const Object& object, const LabelSet& labels) {
  py::list stretches;
  for (const VoteHistory::Bin& bin : object.votes.bins()) {
    py::dict classes;
    for (const auto& [class_id, count] : bin.votes) classes[name_of(class_id, labels)] = count;
    stretches.append(py::dict(py::arg("first_frame") = object.votes.first_frame(bin), py::arg("classes") = classes));
  }
  return stretches;
}

py::list views_of(const Object& object, const LabelSet& labels) {
  py::list views;
  for (const ObjectView& view : object.best_views.views()) {
    const py::tuple box = py::make_tuple(view.box.u0, view.box.v0, view.box.u1, view.box.v1);
    views.append(py::dict(py::arg("frame") = view.frame, py::arg("class") = name_of(view.class_id, labels),
                          py::arg("score") = view.score, py::arg("visible_px") = view.visible_px, py::arg("box") = box));
  }
  return views;
}

const Object& object_of(const ObjectRegistry& objects, std::int64_t id) {
  const bool fits = id > 0 && id <= std::numeric_limits<std::uint32_t>::max();
  const Object* object = fits ? objects.find(objects.survivor(static_cast<PanopticId>(id))) : nullptr;
  if (object == nullptr) throw Error(fmt::format("there is no object with the id {}", id));
  return *object;
}

}  // namespace

NamedObject named(const FoundObject& object, const LabelSet& labels) {
  return {object, std::string(labels.name_of(object.class_id))};
}

std::int64_t object_number(const py::handle& object) {
  if (py::isinstance<NamedObject>(object)) return number(object.cast<const NamedObject&>().object.id);
  try {
    return object.cast<std::int64_t>();
  } catch (const py::cast_error&) {
    throw Error(fmt::format("{} is no object: give its id or a MapObject (room.node_named has the id of a name)",
                            std::string(py::repr(object))));
  }
}

py::dict explain_object(const PanopticMap& map, std::int64_t id) {
  const Object& object = object_of(map.objects, id);
  py::dict probabilities;
  for (const ClassProbability& p : map.objects.probabilities(object.slot)) {
    probabilities[name_of(p.class_id, map.labels)] = p.probability;
  }
  py::list parts;
  for (const ObjectPart& part : object.parts.latest()) {
    parts.append(py::dict(py::arg("id") = number(part.id), py::arg("frame") = part.frame));
  }
  py::dict answer;
  answer["id"] = number(object.id);
  answer["class"] = name_of(map.objects.class_of(object.slot), map.labels);
  answer["probabilities"] = probabilities;
  answer["observations"] = object.observations;
  answer["first_frame"] = object.first_frame;
  answer["last_frame"] = object.last_frame;
  answer["frames_per_stretch"] = object.votes.frames_per_bin();
  answer["votes"] = votes_of(object, map.labels);
  answer["best_views"] = views_of(object, map.labels);
  answer["parts"] = parts;
  return answer;
}

void bind_objects(py::module_& m) {
  py::class_<NamedObject>(m, "MapObject", "An object of a map. Metres, world.")
      .def_property_readonly("id", [](const NamedObject& o) { return number(o.object.id); })
      .def_property_readonly("class_id", [](const NamedObject& o) { return number(o.object.class_id); })
      .def_readonly("class_name", &NamedObject::class_name)
      .def_property_readonly(
          "probability", [](const NamedObject& o) { return o.object.probability; }, "Of that class (Eq. 12).")
      .def_property_readonly(
          "min_m", [](const NamedObject& o) { return vector_of(o.object.box.min_m); }, "(3,) float64.")
      .def_property_readonly(
          "max_m", [](const NamedObject& o) { return vector_of(o.object.box.max_m); }, "(3,) float64.")
      .def_property_readonly(
          "center_m", [](const NamedObject& o) { return vector_of(o.object.box.center_m); },
          "(3,) float64, the mean of its surface voxels.")
      .def_property_readonly(
          "voxels", [](const NamedObject& o) { return o.object.voxels; }, "Near the surface.")
      .def_property_readonly("observations", [](const NamedObject& o) { return o.object.observations; })
      .def_property_readonly("first_frame", [](const NamedObject& o) { return o.object.first_frame; })
      .def_property_readonly("last_frame", [](const NamedObject& o) { return o.object.last_frame; })
      .def("__repr__", [](const NamedObject& o) {
        const Vec3d& c = o.object.box.center_m;
        return fmt::format("<{} {} at ({:.2f}, {:.2f}, {:.2f}) m>", o.class_name, number(o.object.id), c.x(), c.y(), c.z());
      });

  py::class_<PointAnswer>(m, "PointAnswer", "What the map holds at a point.")
      .def_property_readonly("panoptic_id", [](const PointAnswer& a) { return number(a.id); })
      .def_property_readonly("class_id", [](const PointAnswer& a) { return number(a.class_id); })
      .def_readonly("distance_m", &PointAnswer::distance_m, "To the nearest surface, positive in front of it.")
      .def_readonly("weight", &PointAnswer::weight, "Of the observations.")
      .def_readonly("label_share", &PointAnswer::label_share, "Of all votes, 0 to 1: how sure the label is.")
      .def("__repr__", [](const PointAnswer& a) {
        return fmt::format("<class {}, id {}, {:.3f} m from the surface>", number(a.class_id), number(a.id), a.distance_m);
      });
}

}  // namespace panoptic::python
