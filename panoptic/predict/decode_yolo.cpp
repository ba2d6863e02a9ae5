// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "panoptic/parallel.h"
#include "panoptic/predict/decoders.h"
#include "panoptic/predict/instance_mask.h"
#include "panoptic/predict/output_shapes.h"
#include "panoptic/predict/yolo_form.h"

namespace panoptic {
namespace {

constexpr std::size_t kMaxCandidates = 1000;  // suppression is quadratic in them

// 1 x masks x height x width, whatever order the network gives.
Tensor channels_first(const Tensor& tensor, bool is_last) {
  const std::vector<int> shape = *shape_of_rank(tensor, 3);
  if (!is_last) return {{1, shape[0], shape[1], shape[2]}, tensor.values};
  return {{1, shape[2], shape[0], shape[1]}, to_planes(tensor.values, static_cast<std::size_t>(shape[2]))};
}

// Numbers of many cells or boxes, several of each.
struct Strided {
  const float* data = nullptr;
  std::size_t per_channel = 0;
  std::size_t per_cell = 0;

  float at(std::size_t channel, std::size_t cell) const { return data[channel * per_channel + cell * per_cell]; }
  Strided from(std::size_t channel) const { return {data + channel * per_channel, per_channel, per_cell}; }
};

// The outputs of one stride, or all boxes at once.
struct Head {
  YoloForm form = YoloForm::kHeads;
  Strided boxes;    // distributions of 4 sides over bins; or centre and size; or corners
  Strided objects;  // kRawWithObjects: whether there is any; kSuppressed: score and class number
  Strided classes;
  Strided coefficients;
  std::size_t cells = 0;
  std::size_t bins = 0;
  int width = 0;         // kHeads: cells in a row
  double stride_px = 1;  // of the network's input, for the numbers in `boxes`
  double stride_y_px = 1;
  bool are_probabilities = false;

  float probability(float value) const { return are_probabilities ? value : sigmoid(value); }
};

struct Candidate {
  const Head* head = nullptr;
  std::size_t cell = 0;
  float score = 0;
  ClassId class_id = ClassId::kUnknown;
  Box box;
};

Strided planes_of(const Tensor& tensor, std::size_t cells) { return {tensor.values.data(), cells, 1}; }

std::vector<Head> heads_of(const std::vector<Tensor>& outputs, const Reading& reading, const DecodeContext& context) {
  const std::size_t strides = reading.roles.size() / 3;
  std::vector<Head> heads;
  for (std::size_t s = 0; s < strides; ++s) {
    const Tensor& sides = outputs[reading.roles[s]];
    Head head;
    head.width = sides.shape[3];
    head.cells = static_cast<std::size_t>(sides.shape[2]) * static_cast<std::size_t>(head.width);
    head.bins = static_cast<std::size_t>(sides.shape[1]) / 4;
    head.boxes = planes_of(sides, head.cells);
    head.classes = planes_of(outputs[reading.roles[strides + s]], head.cells);
    head.coefficients = planes_of(outputs[reading.roles[2 * strides + s]], head.cells);
    head.stride_px = static_cast<double>(context.placement.input_width) / head.width;
    head.stride_y_px = head.stride_px;
    head.are_probabilities = reading.numbers == Numbers::kProbabilities;
    heads.push_back(head);
  }
  return heads;
}

// One output with a row or a column for every box.
Head boxes_of(const Tensor& tensor, const Reading& reading, const DecodeContext& context) {
  const auto rows = static_cast<std::size_t>(tensor.shape[tensor.shape.size() - 2]);
  const auto columns = static_cast<std::size_t>(tensor.shape.back());
  Head head;
  head.form = static_cast<YoloForm>(reading.form);
  head.cells = reading.channels_last ? rows : columns;
  head.boxes = reading.channels_last ? Strided{tensor.values.data(), 1, columns} : Strided{tensor.values.data(), columns, 1};
  head.objects = head.boxes.from(4);
  head.classes = head.boxes.from(head.form == YoloForm::kRawWithObjects ? 5 : 4);
  head.coefficients = head.form == YoloForm::kSuppressed ? head.boxes.from(6) : head.classes.from(context.class_of.size());
  head.are_probabilities = reading.numbers == Numbers::kProbabilities;
  constexpr float kLargestShare = 2;  // boxes as shares of the input may reach beyond it
  float largest = 0;
  for (std::size_t i = 0; i < head.cells; ++i) largest = std::max({largest, head.boxes.at(2, i), head.boxes.at(3, i)});
  if (largest > 0 && largest <= kLargestShare) {
    head.stride_px = context.placement.input_width;
    head.stride_y_px = context.placement.input_height;
  }
  return head;
}

// The distance from a cell's centre to one side of the box, in strides: the expectation over the bins.
double side_distance(const Head& head, std::size_t side, std::size_t cell) {
  const Strided logits = head.boxes.from(side * head.bins);
  float highest = logits.at(0, cell);
  for (std::size_t bin = 1; bin < head.bins; ++bin) highest = std::max(highest, logits.at(bin, cell));
  double sum = 0;
  double expectation = 0;
  for (std::size_t bin = 0; bin < head.bins; ++bin) {
    const double weight = std::exp(logits.at(bin, cell) - highest);
    sum += weight;
    expectation += weight * static_cast<double>(bin);
  }
  return expectation / sum;
}

// In the numbers of the head: strides or pixels of the input, or shares of it.
Box box_in_head(const Head& head, std::size_t cell) {
  const auto number = [&](std::size_t i) { return static_cast<double>(head.boxes.at(i, cell)); };
  if (head.form == YoloForm::kSuppressed) return {number(0), number(1), number(2), number(3)};
  if (head.form != YoloForm::kHeads) {
    return {number(0) - number(2) / 2, number(1) - number(3) / 2, number(0) + number(2) / 2, number(1) + number(3) / 2};
  }
  const auto row = static_cast<int>(cell / static_cast<std::size_t>(head.width));
  const double x = static_cast<int>(cell) - row * head.width + 0.5;
  const double y = row + 0.5;
  return {x - side_distance(head, 0, cell), y - side_distance(head, 1, cell), x + side_distance(head, 2, cell),
          y + side_distance(head, 3, cell)};
}

Box box_at(const Head& head, std::size_t cell, const Placement& placement) {
  const Box box = box_in_head(head, cell);
  const double to_image_x = head.stride_px / placement.scale_x;
  const double to_image_y = head.stride_y_px / placement.scale_y;
  return {box.left * to_image_x, box.top * to_image_y, box.right * to_image_x, box.bottom * to_image_y};
}

void add_candidate(Candidate found, const DecodeContext& context, std::vector<Candidate>& candidates) {
  if (found.class_id == ClassId::kUnknown || !(found.score >= context.model.thresholds.score)) return;
  found.box = box_at(*found.head, found.cell, context.placement);
  if (std::isfinite(found.box.left + found.box.top + found.box.right + found.box.bottom)) candidates.push_back(found);
}

// Cells whose best class scores well enough and has a counterpart.
void collect(const Head& head, const DecodeContext& context, std::vector<Candidate>& candidates) {
  std::vector<float> best_value(head.cells);
  std::vector<std::int32_t> best_class(head.cells, 0);
  for (std::size_t i = 0; i < head.cells; ++i) best_value[i] = head.classes.at(0, i);
  for (std::size_t c = 1; c < context.class_of.size(); ++c) {
    for (std::size_t i = 0; i < head.cells; ++i) {
      const float value = head.classes.at(c, i);
      best_class[i] = value > best_value[i] ? static_cast<std::int32_t>(c) : best_class[i];
      best_value[i] = value > best_value[i] ? value : best_value[i];
    }
  }
  // Comparing logits spares a sigmoid for nearly every cell; exact within rounding, so the score itself decides at the end.
  const double threshold = context.model.thresholds.score;
  const double least_value = head.are_probabilities ? threshold : std::log(threshold / (1 - threshold)) - 1e-3;
  for (std::size_t i = 0; i < head.cells; ++i) {
    if (!(best_value[i] >= least_value)) continue;
    float score = head.probability(best_value[i]);
    if (head.form == YoloForm::kRawWithObjects) score *= head.probability(head.objects.at(0, i));
    add_candidate({&head, i, score, context.class_of[static_cast<std::size_t>(best_class[i])], {}}, context, candidates);
  }
}

// Boxes that the network has suppressed itself: a score and a class number each; unused rows are zeros.
std::vector<Candidate> collect_suppressed(const Head& head, const DecodeContext& context) {
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < head.cells; ++i) {
    const float score = head.objects.at(0, i);
    if (!(score > 0)) continue;
    require_probability(score, context.model);
    const std::size_t c = class_index(head.objects.at(1, i), context.model);
    add_candidate({&head, i, score, context.class_of[c], {}}, context, candidates);
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  candidates.resize(std::min(candidates.size(), static_cast<std::size_t>(context.model.thresholds.max_instances)));
  return candidates;
}

// Non-maximum suppression within each class of the label set.
std::vector<Candidate> suppress(std::vector<Candidate> candidates, const Thresholds& thresholds) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  if (candidates.size() > kMaxCandidates) candidates.resize(kMaxCandidates);
  std::vector<Candidate> kept;
  for (const Candidate& candidate : candidates) {
    const bool covered = std::any_of(kept.begin(), kept.end(), [&](const Candidate& better) {
      return better.class_id == candidate.class_id && intersection_over_union(better.box, candidate.box) > thresholds.nms_iou;
    });
    if (!covered) kept.push_back(candidate);
    if (kept.size() >= static_cast<std::size_t>(thresholds.max_instances)) break;
  }
  return kept;
}

std::vector<ClassProbability> class_probabilities(const Candidate& candidate, const std::vector<ClassId>& class_of) {
  if (candidate.head->form == YoloForm::kSuppressed) return {};
  std::vector<float> shares(class_of.size());
  for (std::size_t c = 0; c < shares.size(); ++c) {
    shares[c] = candidate.head->probability(candidate.head->classes.at(c, candidate.cell));
  }
  return distribution_of(shares, class_of);
}

// sigmoid(coefficients . prototypes) within the window.
void fill_mask_scores(const Candidate& candidate, const Tensor& prototypes, ScoreWindow& window) {
  const auto stride = static_cast<std::size_t>(prototypes.shape[3]);
  const std::size_t plane = stride * static_cast<std::size_t>(prototypes.shape[2]);
  const auto width = static_cast<std::size_t>(window.width);
  const auto height = static_cast<std::size_t>(window.height);
  const std::size_t corner = static_cast<std::size_t>(window.y0) * stride + static_cast<std::size_t>(window.x0);
  window.scores.assign(width * height, 0.0F);
  for (std::size_t p = 0; p < static_cast<std::size_t>(prototypes.shape[1]); ++p) {
    const float coefficient = candidate.head->coefficients.at(p, candidate.cell);
    for (std::size_t y = 0; y < height; ++y) {
      const float* in = prototypes.values.data() + p * plane + corner + y * stride;
      float* out = window.scores.data() + y * width;
      for (std::size_t x = 0; x < width; ++x) out[x] += coefficient * in[x];
    }
  }
  std::transform(window.scores.begin(), window.scores.end(), window.scores.begin(), sigmoid);
}

Instance to_instance(const Candidate& candidate, const Tensor& prototypes, const DecodeContext& context) {
  const Placement& placement = context.placement;
  const ScoreGrid grid{prototypes.shape[3], prototypes.shape[2], placement.scale_x * prototypes.shape[3] / placement.input_width,
                       placement.scale_y * prototypes.shape[2] / placement.input_height};
  const PixelRect rect = pixels_in(candidate.box, placement.image_width, placement.image_height);
  Instance instance{
      {candidate.class_id, candidate.score, class_probabilities(candidate, context.class_of)}, rect.x0, rect.y0, {}};
  if (rect.width < 1 || rect.height < 1) return instance;
  ScoreWindow window = window_around(rect, grid);
  fill_mask_scores(candidate, prototypes, window);
  instance.mask = draw_mask(rect, grid, window, context.model.thresholds.mask);
  return instance;
}

}  // namespace

Findings decode_yolo(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context) {
  const Tensor prototypes = channels_first(outputs[reading.roles.back()], reading.masks_last);
  const bool are_heads = static_cast<YoloForm>(reading.form) == YoloForm::kHeads;
  if (are_heads && reading.channels_last) {
    for (std::size_t i = 0; i + 1 < reading.roles.size(); ++i) {
      outputs[reading.roles[i]] = channels_first(outputs[reading.roles[i]], true);
    }
  }
  std::vector<Head> heads;
  if (are_heads) {
    heads = heads_of(outputs, reading, context);
  } else {
    heads = {boxes_of(outputs[reading.roles[0]], reading, context)};
  }
  std::vector<Candidate> candidates;
  if (heads[0].form == YoloForm::kSuppressed) {
    candidates = collect_suppressed(heads[0], context);
  } else {
    for (const Head& head : heads) collect(head, context, candidates);
    candidates = suppress(std::move(candidates), context.model.thresholds);
  }
  std::vector<Instance> instances(candidates.size());
  parallel_for(candidates.size(), [&](std::size_t i) { instances[i] = to_instance(candidates[i], prototypes, context); });
  drop_small(instances, context.model.thresholds);
  return {.instances = std::move(instances)};
}

}  // namespace panoptic
