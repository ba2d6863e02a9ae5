// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/predict/class_names.h"
#include "panoptic/predict/decoders.h"
#include "panoptic/predict/instance_mask.h"
#include "panoptic/predict/mask_shape.h"
#include "panoptic/predict/output_shapes.h"

namespace panoptic {
namespace {

struct Detection {
  std::size_t row = 0;
  std::size_t class_index = 0;  // of the network
  Segment segment;
  Box box;
};

// The position of a class in the description; nothing for a number that COCO gives to no class.
std::optional<std::size_t> index_of_label(float label, const Reading& reading, const Model& model) {
  if (reading.labels_from == LabelsFrom::kZero) return class_index(label, model);
  const bool is_coco = reading.labels_from == LabelsFrom::kCoco;
  if (!(label >= 1) || (is_coco && !(label <= kLastCocoCategory))) {
    throw Error(
        fmt::format("{}: the network gives the class number {}, but {}; say in the description: [outputs] first_class = "
                    "\"0\"{}",
                    model.path.string(), label,
                    is_coco ? "is taken to give the category numbers of COCO, 1 to 90" : "is taken to number classes from 1",
                    is_coco ? " or \"1\"" : ""));
  }
  if (!is_coco) return class_index(label - 1, model);
  const int index = index_of_coco_category(static_cast<int>(label));
  if (index < 0) return std::nullopt;
  return static_cast<std::size_t>(index);
}

// Probabilities of the background and of each class of the description.
struct Distribution {
  float background = 0;
  std::vector<float> classes;
};

// Logits become probabilities by softmax.
std::vector<float> probabilities_of(std::span<const float> row) {
  std::vector<float> p(row.begin(), row.end());
  constexpr float kTolerance = 0.02F;
  const float sum = std::accumulate(p.begin(), p.end(), 0.0F);
  if (are_shares(row) && std::abs(sum - 1) <= kTolerance) return p;
  softmax(p);
  return p;
}

// The background is first where classes are numbered from one, else last, unless the description lists it among the classes.
Distribution distribution_in(std::span<const float> row, const Reading& reading, const Model& model) {
  const std::vector<float> p = probabilities_of(row);
  Distribution result;
  if (reading.labels_from == LabelsFrom::kCoco && p.size() != model.classes.size() + 1) {
    result.background = p[0];
    result.classes.assign(model.classes.size(), 0.0F);
    for (std::size_t id = 1; id < p.size(); ++id) {
      const int index = index_of_coco_category(static_cast<int>(id));
      if (index >= 0) result.classes[static_cast<std::size_t>(index)] = p[id];
    }
    return result;
  }
  if (p.size() == model.classes.size()) {
    result.classes = p;
    for (std::size_t c = 0; c < p.size(); ++c) {
      if (is_background(model.classes[c])) result.background += p[c];
    }
    return result;
  }
  const bool first = reading.labels_from != LabelsFrom::kZero;
  result.background = first ? p.front() : p.back();
  result.classes.assign(p.begin() + (first ? 1 : 0), p.end() - (first ? 0 : 1));
  return result;
}

// p(O) = 1 - p(background) and p(l | O) where the network gives distributions (Eq. 12), else its score and its class alone.
void add_evidence(const std::vector<Tensor>& outputs, const Reading& reading, const DecodeContext& context,
                  Detection& detection) {
  if (reading.roles[4] == kAbsent) return;
  const Tensor& all = outputs[reading.roles[4]];
  const auto columns = static_cast<std::size_t>(all.shape.back());
  const Distribution p = distribution_in(std::span(all.values).subspan(detection.row * columns, columns), reading, context.model);
  detection.segment.score = 1 - p.background;
  detection.segment.class_probabilities = distribution_of(p.classes, context.class_of);
}

std::vector<Detection> detections_in(const std::vector<Tensor>& outputs, const Reading& reading, const DecodeContext& context) {
  const Tensor& boxes = outputs[reading.roles[0]];
  const auto columns = static_cast<std::size_t>(boxes.shape.back());
  const std::size_t count = boxes.values.size() / columns;
  std::vector<Detection> detections;
  for (std::size_t i = 0; i < count; ++i) {
    const float* box = boxes.values.data() + i * columns;
    const float score = reading.roles[2] == kAbsent ? box[4] : outputs[reading.roles[2]].values[i];
    if (!(score >= context.model.thresholds.score) || score <= 0) continue;  // places that are not used hold zeros
    require_probability(score, context.model);
    const auto class_index = index_of_label(outputs[reading.roles[1]].values[i], reading, context.model);
    if (!class_index) continue;
    Detection d{i, *class_index, {}, {}};
    d.segment.class_id = context.class_of[d.class_index];
    d.segment.score = score;
    const Placement& placement = context.placement;
    d.box = {box[0] / placement.scale_x, box[1] / placement.scale_y, box[2] / placement.scale_x, box[3] / placement.scale_y};
    const bool finite = std::isfinite(d.box.left + d.box.top + d.box.right + d.box.bottom);
    if (d.segment.class_id == ClassId::kUnknown || !finite) continue;
    add_evidence(outputs, reading, context, d);
    if (d.segment.score >= context.model.thresholds.score) detections.push_back(std::move(d));
  }
  std::stable_sort(detections.begin(), detections.end(),
                   [](const Detection& a, const Detection& b) { return a.segment.score > b.segment.score; });
  detections.resize(std::min(detections.size(), static_cast<std::size_t>(context.model.thresholds.max_instances)));
  return detections;
}

struct Masks {
  const Tensor& tensor;
  MaskShape shape;
  bool are_probabilities = false;
};

ScoreGrid grid_of(const Detection& detection, const MaskShape& shape, const Placement& placement) {
  if (!shape.in_boxes) {
    return {shape.width, shape.height, placement.scale_x * shape.width / placement.input_width,
            placement.scale_y * shape.height / placement.input_height};
  }
  const Box& box = detection.box;
  return {shape.width,
          shape.height,
          shape.width / std::max(box.right - box.left, 1e-6),
          shape.height / std::max(box.bottom - box.top, 1e-6),
          box.left,
          box.top};
}

Instance to_instance(const Detection& detection, const Masks& masks, const DecodeContext& context) {
  const MaskShape& shape = masks.shape;
  const PixelRect rect = pixels_in(detection.box, context.placement.image_width, context.placement.image_height);
  Instance instance{detection.segment, rect.x0, rect.y0, {}};
  if (rect.width < 1 || rect.height < 1) return instance;
  const ScoreGrid grid = grid_of(detection, shape, context.placement);
  ScoreWindow window = window_around(rect, grid);
  const auto stride = static_cast<std::size_t>(shape.width);
  const std::size_t plane = stride * static_cast<std::size_t>(shape.height);
  const std::size_t which =
      detection.row * static_cast<std::size_t>(shape.per_detection) + (shape.per_detection > 1 ? detection.class_index : 0);
  for (int y = 0; y < window.height; ++y) {
    const float* in = masks.tensor.values.data() + which * plane + static_cast<std::size_t>(window.y0 + y) * stride +
                      static_cast<std::size_t>(window.x0);
    for (int x = 0; x < window.width; ++x) window.scores.push_back(masks.are_probabilities ? in[x] : sigmoid(in[x]));
  }
  instance.mask = draw_mask(rect, grid, window, context.model.thresholds.mask);
  return instance;
}

}  // namespace

Findings decode_mask_rcnn(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context) {
  const std::vector<Detection> detections = detections_in(outputs, reading, context);
  const Tensor& tensor = outputs[reading.roles[3]];
  const int count = (*shape_of_rank(outputs[reading.roles[0]], 2))[0];
  const Masks masks{tensor, mask_shape_of(tensor, count, context.model.input), are_shares(tensor.values)};
  std::vector<Instance> instances(detections.size());
  parallel_for(detections.size(), [&](std::size_t i) { instances[i] = to_instance(detections[i], masks, context); });
  drop_small(instances, context.model.thresholds);
  return {.instances = std::move(instances)};
}

}  // namespace panoptic
