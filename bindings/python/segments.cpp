// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/segments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/labels.h"
#include "bindings/python/pixels.h"

namespace panoptic::python {
namespace {

constexpr std::size_t kMaxSegments = 65000;  // their numbers have 16 bits
constexpr double kRounding = 1e-3;           // of probabilities in 16 bits

// A segment as the caller lists it, and the number that his image has for it, if he says.
struct ListedSegment {
  Segment segment;
  std::optional<std::int64_t> id;
};

float score_from(const py::handle& object, const std::string& of) {
  double score = 0;
  try {
    score = py::float_(py::reinterpret_borrow<py::object>(object));
  } catch (const py::error_already_set&) {
    throw Error(fmt::format("{} has the score {}: it must be a number", of, std::string(py::repr(object))));
  }
  if (!(score >= 0 && score <= 1)) throw Error(fmt::format("{} has the score {}: it must be from 0 to 1", of, score));
  return static_cast<float>(score);
}

std::int64_t id_from(const py::handle& object) {
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(object.ptr()));
  const std::int64_t id = index ? PyLong_AsLongLong(index.ptr()) : -1;
  if (PyErr_Occurred() == nullptr) return id;
  PyErr_Clear();
  throw Error(fmt::format("a segment has the id {}: it must be a whole number of 64 bits", std::string(py::repr(object))));
}

std::vector<ClassProbability> probabilities_from(const py::dict& by_class, const LabelSet* labels) {
  std::map<ClassId, float> sorted;
  for (const auto& [key, value] : by_class) sorted[class_from(key, labels)] = score_from(value, "a class of a segment");
  std::vector<ClassProbability> list;
  double sum = 0;
  for (const auto& [class_id, probability] : sorted) {
    list.push_back({class_id, probability});
    sum += double{probability};
  }
  if (sum > 1 + kRounding) throw Error(fmt::format("the probabilities of a segment add up to {}: it must be at most 1", sum));
  return list;
}

Segment make_segment(const py::object& class_, double score, const py::dict& probabilities, bool whole_class,
                     const py::object& labels) {
  const LabelSet set = labels.is_none() ? LabelSet() : labels_from(labels, "");
  const LabelSet* named = labels.is_none() ? nullptr : &set;
  return {class_from(class_, named), score_from(py::float_(score), "a segment"), probabilities_from(probabilities, named),
          whole_class};
}

ListedSegment from_dict(const py::dict& dict, const LabelSet* labels) {
  ListedSegment listed;
  bool has_class = false;
  for (const auto& [key, value] : dict) {
    const std::string name = py::str(key);
    if (name == "class") {
      listed.segment.class_id = class_from(value, labels);
      has_class = true;
    } else if (name == "score") {
      listed.segment.score = score_from(value, "a segment");
    } else if (name == "id") {
      listed.id = id_from(value);
    } else if (name == "probabilities") {
      listed.segment.class_probabilities = probabilities_from(py::dict(py::reinterpret_borrow<py::object>(value)), labels);
    } else if (name == "whole_class") {
      listed.segment.is_whole_class = py::bool_(py::reinterpret_borrow<py::object>(value));
    } else {
      throw Error(fmt::format("a segment has the key '{}'; known: class, score, id, probabilities, whole_class", name));
    }
  }
  if (!has_class) throw Error("a segment has no 'class'");
  return listed;
}

ListedSegment listed_from(const py::handle& object, const LabelSet* labels) {
  if (py::isinstance<Segment>(object)) return {object.cast<Segment>(), {}};
  if (py::isinstance<py::dict>(object)) return from_dict(py::reinterpret_borrow<py::dict>(object), labels);
  return {{class_from(object, labels)}, {}};
}

// The number of each segment in the caller's image: what he says, else its place in the list, from 1.
std::unordered_map<std::int64_t, std::uint16_t> numbers_of(const std::vector<ListedSegment>& listed) {
  std::unordered_map<std::int64_t, std::uint16_t> numbers;
  const bool named = std::any_of(listed.begin(), listed.end(), [](const ListedSegment& s) { return s.id.has_value(); });
  for (std::size_t i = 0; i < listed.size(); ++i) {
    if (named && !listed[i].id) throw Error("some segments have an 'id' and some have none");
    const std::int64_t id = named ? *listed[i].id : static_cast<std::int64_t>(i + 1);
    if (id == 0) throw Error("a segment has the id 0, which means unknown");
    if (!numbers.emplace(id, static_cast<std::uint16_t>(i + 1)).second)
      throw Error(fmt::format("two segments have the id {}", id));
  }
  return numbers;
}

Segmentation from_ids(const py::handle& ids, const py::sequence& segments, const LabelSet* labels) {
  std::vector<ListedSegment> listed;
  for (const py::handle segment : segments) listed.push_back(listed_from(segment, labels));
  if (listed.size() > kMaxSegments)
    throw Error(fmt::format("a frame has at most {} segments, not {}", kMaxSegments, listed.size()));
  const std::unordered_map<std::int64_t, std::uint16_t> numbers = numbers_of(listed);
  const auto segment_of = [&](std::int64_t id) {
    const auto found = numbers.find(id);
    if (found == numbers.end()) throw Error(fmt::format("ids holds {}, and no segment has that number", id));
    return found->second;
  };
  const LentNumbers pixels = whole_numbers(ids, "ids");
  Segmentation result{translated<std::uint16_t>(pixels.numbers, segment_of), {}};
  for (ListedSegment& one : listed) result.segments.push_back(std::move(one.segment));
  return result;
}

Image<ClassId> semantic_from(const py::object& object, int width, int height, const LabelSet& labels) {
  if (object.is_none()) return {width, height};
  const LentNumbers classes = whole_numbers(object, "semantic");
  if (classes.numbers.width != width || classes.numbers.height != height) {
    throw Error(fmt::format("semantic is {}, and the masks have {} rows of {} pixels", text_of(classes.array), height, width));
  }
  return translated<ClassId>(classes.numbers, [&](std::int64_t id) { return number(class_numbered(id, &labels)); });
}

Segmentation from_masks(const py::object& masks, const py::sequence& classes, const LabelSet& labels, const py::object& scores,
                        const py::object& semantic) {
  const py::array_t<std::uint8_t> stack = mask_stack(masks, "masks");
  const auto count = static_cast<std::size_t>(stack.shape(0));
  const auto height = static_cast<int>(stack.shape(1));
  const auto width = static_cast<int>(stack.shape(2));
  if (py::len(classes) != count) throw Error(fmt::format("there are {} masks and {} classes", count, py::len(classes)));
  if (!scores.is_none() && py::len(scores) != count)
    throw Error(fmt::format("there are {} masks and {} scores", count, py::len(scores)));
  Image<ClassId> background = semantic_from(semantic, width, height, labels);
  std::vector<Instance> things;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = fmt::format("mask {}", i);
    const std::uint8_t* mask = stack.data() + i * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    Instance instance = cut_out({mask, width, height});
    if (instance.mask.empty()) throw Error(fmt::format("{} has no pixel: leave it out", name));
    instance.segment.class_id = class_from(py::object(classes[i]), &labels);
    if (!scores.is_none()) instance.segment.score = score_from(py::object(scores[py::int_(i)]), name);
    if (labels.is_thing(instance.segment.class_id)) {
      things.push_back(std::move(instance));
    } else {
      paint(instance, background);
    }
  }
  return fuse(background, things, labels);
}

// Cityscapes' form, which Detectron2 and others write too: class number * divisor + number of the instance.
Segmentation from_panoptic(const py::object& image, const LabelSet& labels, std::int64_t divisor) {
  if (divisor < 1) throw Error("divisor must be above zero");
  std::vector<Segment> segments;
  std::unordered_map<std::int64_t, std::uint16_t> numbers;
  const auto segment_of = [&](std::int64_t value) {
    std::uint16_t& segment = numbers[value];
    if (segment != 0) return segment;
    const ClassId class_id = class_numbered(value / divisor, &labels);
    if (segments.size() >= kMaxSegments) throw Error(fmt::format("a frame has at most {} segments", kMaxSegments));
    segments.push_back({class_id, 1.0F, {}, labels.is_thing(class_id) && value % divisor == 0});
    return segment = static_cast<std::uint16_t>(segments.size());
  };
  const LentNumbers pixels = whole_numbers(image, "the panoptic image");
  Image<std::uint16_t> segment_at = translated<std::uint16_t>(pixels.numbers, segment_of);
  return {std::move(segment_at), std::move(segments)};
}

Segmentation from_pair(const py::sequence& pair, const LabelSet& labels) {
  if (py::len(pair) < 2 || py::len(pair) > 3)
    throw Error("segments must be (ids, segments), (masks, classes) or (masks, classes, scores)");
  const py::object first = pair[0];
  const py::object list = pair[1];
  if (!py::isinstance<py::sequence>(list) && !py::hasattr(list, "__getitem__"))
    throw Error("segments: the second part must be a list");
  if (array_of(first, "segments").ndim() == 3) {
    return from_masks(first, list, labels, py::len(pair) == 3 ? py::object(pair[2]) : py::none(), py::none());
  }
  if (py::len(pair) == 3) throw Error("segments: scores go with masks; a list of segments has them in itself");
  return from_ids(first, list, &labels);
}

}  // namespace

std::shared_ptr<const Segmentation> segmentation_from(const py::handle& object, const LabelSet& labels) {
  if (object.is_none()) return std::make_shared<Segmentation>();
  if (py::isinstance<Segmentation>(object)) return object.cast<std::shared_ptr<Segmentation>>();
  if (py::isinstance<py::tuple>(object) || py::isinstance<py::list>(object)) {
    return std::make_shared<Segmentation>(from_pair(py::reinterpret_borrow<py::sequence>(object), labels));
  }
  return std::make_shared<Segmentation>(from_panoptic(py::reinterpret_borrow<py::object>(object), labels, 1000));
}

void require_sound(const Segmentation& segmentation, const LabelSet& labels) {
  for (const Segment& segment : segmentation.segments) {
    class_numbered(number(segment.class_id), &labels);
    for (const ClassProbability& p : segment.class_probabilities) class_numbered(number(p.class_id), &labels);
  }
}

void bind_segments(py::module_& m) {
  py::class_<Segment>(m, "Segment", R"(A region of one frame: one object, or all pixels of a stuff class.

class_: the class's number or, with labels, its name. score: 0 to 1. probabilities: {class: p} over thing classes, empty = class_
alone. whole_class: things that were not told apart.)")
      .def(py::init(&make_segment), py::arg("class_"), py::arg("score") = 1.0, py::arg("probabilities") = py::dict(),
           py::arg("whole_class") = false, py::arg("labels") = py::none())
      .def_property_readonly("class_id", [](const Segment& s) { return number(s.class_id); })
      .def_readonly("score", &Segment::score)
      .def_readonly("whole_class", &Segment::is_whole_class)
      .def_property_readonly("probabilities", [](const Segment& s) {
        py::dict by_class;
        for (const ClassProbability& p : s.class_probabilities) by_class[py::int_(number(p.class_id))] = p.probability;
        return by_class;
      });

  py::class_<Segmentation, std::shared_ptr<Segmentation>>(m, "Segmentation", R"(What is in a frame, per pixel of its colour image.

Segmentation(ids, segments, labels): ids (h, w), any whole numbers, 0 = unknown; segments: a list of Segments, classes or dicts with
"class" and, as needed, "score", "probabilities", "whole_class" and "id", the number in ids (else its place in the list, from 1).
Segmentation() is a frame without a prediction.)")
      .def(py::init<>())
      .def(py::init([](const py::object& ids, const py::sequence& segments, const py::object& labels) {
             if (labels.is_none()) return from_ids(ids, segments, nullptr);
             const LabelSet set = labels_from(labels, "");
             return from_ids(ids, segments, &set);
           }),
           py::arg("ids"), py::arg("segments"), py::arg("labels") = py::none())
      .def_static(
          "from_masks",
          [](const py::object& masks, const py::sequence& classes, const py::object& labels, const py::object& scores,
             const py::object& semantic) { return from_masks(masks, classes, labels_from(labels, "indoor"), scores, semantic); },
          py::arg("masks"), py::arg("classes"), py::arg("labels"), py::kw_only(), py::arg("scores") = py::none(),
          py::arg("semantic") = py::none(),
          R"(From what a detector gives: masks (N, h, w) bool or uint8, a class and a score for each; semantic (h, w), class
numbers of everything else. Where masks overlap the smaller one is in front (Eq. 1). N may be 0; a mask without a pixel may not.)")
      .def_static(
          "from_panoptic",
          [](const py::object& image, const py::object& labels, std::int64_t divisor) {
            return from_panoptic(image, labels_from(labels, "indoor"), divisor);
          },
          py::arg("image"), py::arg("labels"), py::arg("divisor") = 1000,
          "From (h, w) whole numbers: class number * divisor + number of the instance; 0 = unknown.")
      .def_property_readonly(
          "ids",
          [](const py::object& self) { return image_view<std::uint16_t>(self.cast<const Segmentation&>().segment_at, self); },
          "(h, w) uint16: 0 = unknown, else 1 + the index of the segment; a view.")
      .def_property_readonly("segments", [](const Segmentation& s) { return s.segments; })
      .def("__bool__", [](const Segmentation& s) { return !s.segment_at.empty(); })
      .def(
          "__eq__", [](const Segmentation& a, const Segmentation& b) { return a == b; }, py::is_operator())
      .def("__repr__", [](const Segmentation& s) {
        return fmt::format("<Segmentation {}x{}, {} segments>", s.segment_at.width(), s.segment_at.height(), s.segments.size());
      });
}

}  // namespace panoptic::python
