// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "panoptic/predict/class_names.h"
#include "panoptic/predict/decoders.h"
#include "panoptic/predict/mask_shape.h"
#include "panoptic/predict/output_shapes.h"

namespace panoptic {
namespace {

constexpr int kMostBoxMaskSide = 64;  // a mask that small lies in its box, a larger one over the whole image

struct Outputs {
  const std::vector<Tensor>& all;
  const Model& model;
  std::optional<std::size_t> boxes = {};
  std::optional<std::size_t> labels = {};
  std::optional<std::size_t> scores = {};  // absent: the fifth number of a box
  std::optional<std::size_t> masks = {};
  std::optional<std::size_t> distribution = {};  // of classes, with the background
  std::optional<std::size_t> image_size = {};    // detectron2 gives it after everything else

  bool taken(std::size_t i) const { return boxes == i || labels == i || scores == i || masks == i || distribution == i; }
};

// The output that the description names, else the first that fits and has a name that says so, else the first that fits.
template <typename Fits>
std::optional<std::size_t> find(const Outputs& outputs, std::string_view role, std::initializer_list<std::string_view> words,
                                Fits fits) {
  if (const auto named = output_named_for(role, outputs.all, outputs.model, fits)) return named;
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < outputs.all.size(); ++i) {
    if (outputs.taken(i) || !fits(outputs.all[i])) continue;
    const bool says =
        std::any_of(words.begin(), words.end(), [&](std::string_view word) { return name_contains(outputs.all[i], word); });
    if (says) return i;
    if (!first) first = i;
  }
  return first;
}

bool has_columns(const Tensor& tensor, int columns) {
  const auto shape = shape_of_rank(tensor, 2);
  return shape && !tensor.is_whole && (*shape)[1] == columns;
}

bool is_list(const Tensor& tensor, int count) {
  const auto shape = shape_of_rank(tensor, 1);
  return shape && (*shape)[0] == count;
}

// Masks of so many detections; what lies between count and height is 1, or one for each class.
bool is_masks(const Tensor& tensor, int count, std::size_t classes) {
  const std::vector<int>& s = tensor.shape;
  if (s.size() < 3 || (count > 0 && tensor.values.empty())) return false;
  if (s.size() == 5) return s[0] == 1 && s[1] == count && s[2] == 1;
  if (s.size() == 3) return s[0] == count;
  if (s.size() != 4) return false;
  return (s[0] == count && (s[1] == 1 || s[1] == static_cast<int>(classes))) || (s[0] == 1 && s[1] == count);
}

// Returns what is missing, or nothing.
std::string find_outputs(Outputs& outputs) {
  const std::size_t classes = outputs.model.classes.size();
  outputs.boxes = find(outputs, "boxes", {"box", "det"}, [](const Tensor& t) { return has_columns(t, 4) || has_columns(t, 5); });
  if (!outputs.boxes) return "no output has n boxes of 4 numbers";
  const std::vector<int> shape = *shape_of_rank(outputs.all[*outputs.boxes], 2);
  const int count = shape[0];
  outputs.labels = find(outputs, "labels", {"label", "class", "cls"}, [&](const Tensor& t) {
    return is_list(t, count) && (t.is_whole || name_contains(t, "label") || name_contains(t, "class")) &&
           !name_contains(t, "num") && !name_contains(t, "size");
  });
  if (!outputs.labels) return fmt::format("no output has the {} class numbers (integers) of its {} boxes", count, count);
  if (shape[1] == 4) {
    outputs.scores =
        find(outputs, "scores", {"score", "conf"}, [&](const Tensor& t) { return is_list(t, count) && !t.is_whole; });
    if (!outputs.scores) return fmt::format("no output has the scores of its {} boxes", count);
  }
  outputs.masks = find(outputs, "masks", {"mask", "segm"}, [&](const Tensor& t) { return is_masks(t, count, classes); });
  if (!outputs.masks) return "it gives boxes and no masks: export the variant with masks";
  const int columns = static_cast<int>(classes);
  outputs.distribution = find(outputs, "distribution", {"prob", "logit", "dist"}, [&](const Tensor& t) {
    const bool has_classes =
        has_columns(t, columns) || has_columns(t, columns + 1) || (is_coco80(outputs.model.classes) && has_columns(t, 91));
    return has_classes && (*shape_of_rank(t, 2))[0] == count;
  });
  outputs.image_size = find(outputs, "", {"size"}, [](const Tensor& t) { return t.is_whole && is_list(t, 2); });
  return "";
}

// Classes are numbered from one where 0 is the background (torchvision, maskrcnn-benchmark), and from zero where the background
// comes last (detectron2, mmdetection). Who exported it is told by names, by the image size that detectron2 adds, and by the
// order of outputs: detectron2 sorts them by name (boxes, classes, masks, scores), the others give boxes, labels, scores, masks.
std::optional<LabelsFrom> labels_from(const Outputs& outputs, bool masks_in_boxes) {
  const std::vector<std::string>& classes = outputs.model.classes;
  const std::string chosen = output_setting("first_class", {"0", "1", "coco"}, outputs.model);
  if (chosen == "0") return LabelsFrom::kZero;
  if (chosen == "1") return LabelsFrom::kOne;
  if (chosen == "coco") return LabelsFrom::kCoco;
  if (is_background(classes.front())) return LabelsFrom::kZero;
  const auto is_of_detectron = [](const Tensor& t) { return name_contains(t, "pred_"); };
  if (!outputs.scores) return LabelsFrom::kZero;  // mmdetection: a score beside each box
  const bool sorted = outputs.labels < outputs.masks && outputs.masks < outputs.scores;
  if (std::any_of(outputs.all.begin(), outputs.all.end(), is_of_detectron) || outputs.image_size || sorted)
    return LabelsFrom::kZero;
  const bool is_named = name_contains(outputs.all[*outputs.labels], "label");
  const bool in_order = outputs.boxes < outputs.labels && outputs.labels < outputs.scores && outputs.scores < outputs.masks;
  if (!is_named && !in_order) return std::nullopt;
  return is_coco80(classes) && !masks_in_boxes ? LabelsFrom::kCoco : LabelsFrom::kOne;
}

}  // namespace

MaskShape mask_shape_of(const Tensor& masks, int detections, const InputFormat& input) {
  const std::size_t rank = masks.shape.size();
  MaskShape shape{masks.shape[rank - 1], masks.shape[rank - 2], 1, false};
  if (rank == 4 && masks.shape[0] == detections) shape.per_detection = masks.shape[1];
  const bool is_input = shape.width == input.width && shape.height == input.height;
  shape.in_boxes = !is_input && std::max(shape.width, shape.height) <= kMostBoxMaskSide;
  return shape;
}

Match recognise_mask_rcnn(const std::vector<Tensor>& outputs, const Model& model) {
  Outputs found{outputs, model};
  if (const std::string missing = find_outputs(found); !missing.empty()) return {.why_not = missing};
  const MaskShape shape = mask_shape_of(outputs[*found.masks], (*shape_of_rank(outputs[*found.boxes], 2))[0], model.input);
  const std::optional<LabelsFrom> from = labels_from(found, shape.in_boxes);
  if (!from) {
    return {.choices =
                "are its classes numbered from 0 (detectron2) or from 1, with 0 for the background (torchvision)? Say so in the "
                "description: [outputs] first_class = \"0\" or \"1\""};
  }
  Reading reading;
  reading.roles = {*found.boxes, *found.labels, found.scores.value_or(kAbsent), *found.masks,
                   found.distribution.value_or(kAbsent)};
  reading.labels_from = *from;
  constexpr std::string_view kFrom[] = {"numbered from 0", "numbered from 1", "with the category numbers of COCO"};
  reading.text =
      fmt::format("boxes, classes {}, {} and masks of {} x {} {} ({} detections)", kFrom[static_cast<std::size_t>(*from)],
                  found.distribution ? "their distributions, scores" : "scores", shape.width, shape.height,
                  shape.in_boxes ? "in their boxes" : "over the image", (*shape_of_rank(outputs[*found.boxes], 2))[0]);
  return {.reading = std::move(reading)};
}

}  // namespace panoptic
