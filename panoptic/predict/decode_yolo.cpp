// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/predict/decoders.h"
#include "panoptic/predict/instance_mask.h"

namespace panoptic {
namespace {

constexpr std::size_t kMaxCandidates = 1000;  // suppression is quadratic in them
constexpr float kLeastProbability = 1e-3F;    // shares below are not worth their place in the map

// The outputs of one stride: planes of width x height cells.
struct Head {
  const Tensor* sides = nullptr;         // 4 x bins planes: distances to left, top, right, bottom
  const Tensor* logits = nullptr;        // one plane per class
  const Tensor* coefficients = nullptr;  // one plane per prototype
  int width = 0;
  int height = 0;
  double stride_px = 0;  // of the network's input

  std::size_t cells() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

struct Candidate {
  const Head* head = nullptr;
  std::size_t cell = 0;
  float score = 0;
  ClassId class_id = ClassId::kUnknown;
  Box box;
};

float sigmoid(float x) { return 1.0F / (1.0F + std::exp(-x)); }

bool is_image_batch(const Tensor& tensor) { return tensor.shape.size() == 4 && tensor.shape[0] == 1; }

bool same_grid(const Tensor& a, const Tensor& b) { return a.shape[2] == b.shape[2] && a.shape[3] == b.shape[3]; }

// Nothing, or what is wrong with the shapes.
std::string why_not_yolo(const std::vector<Tensor>& outputs, const DecodeContext& context) {
  constexpr int kMinBins = 2;
  if (outputs.size() < 4 || outputs.size() % 3 != 1) return fmt::format("it has {} outputs", outputs.size());
  if (!std::all_of(outputs.begin(), outputs.end(), is_image_batch)) return "an output is not 1 x channels x height x width";
  const std::size_t strides = outputs.size() / 3;
  const Tensor& prototypes = outputs.back();
  for (std::size_t s = 0; s < strides; ++s) {
    const Tensor& sides = outputs[s];
    const Tensor& logits = outputs[strides + s];
    const Tensor& coefficients = outputs[2 * strides + s];
    if (sides.shape[1] % 4 != 0 || sides.shape[1] < 4 * kMinBins)
      return fmt::format("output {} has {} channels", s, sides.shape[1]);
    if (logits.shape[1] != static_cast<int>(context.model.classes.size())) {
      return fmt::format("output {} has {} classes, the description {}", strides + s, logits.shape[1],
                         context.model.classes.size());
    }
    if (coefficients.shape[1] != prototypes.shape[1]) return "mask coefficients and prototypes differ in number";
    if (!same_grid(sides, logits) || !same_grid(sides, coefficients)) return "boxes, classes and masks differ in size";
    const int width = sides.shape[3];
    const int height = sides.shape[2];
    if (width < 1 || height < 1 || context.placement.input_width % width != 0 || context.placement.input_height % height != 0 ||
        context.placement.input_width / width != context.placement.input_height / height) {
      return fmt::format("output {} is {} x {}, which does not divide the input", s, width, height);
    }
  }
  return prototypes.shape[2] < 1 || prototypes.shape[3] < 1 ? "the prototypes are empty" : "";
}

std::vector<Head> heads_of(const std::vector<Tensor>& outputs, const DecodeContext& context) {
  if (const std::string why = why_not_yolo(outputs, context); !why.empty()) {
    throw Error(
        fmt::format("{}: the decoder 'yolo_seg' reads boxes, classes and mask coefficients per stride, then prototypes, but {}; "
                    "check decoder, classes and [input]",
                    context.model.path.string(), why));
  }
  const std::size_t strides = outputs.size() / 3;
  std::vector<Head> heads;
  for (std::size_t s = 0; s < strides; ++s) {
    const int width = outputs[s].shape[3];
    heads.push_back({&outputs[s], &outputs[strides + s], &outputs[2 * strides + s], width, outputs[s].shape[2],
                     static_cast<double>(context.placement.input_width) / width});
  }
  return heads;
}

// The distance from a cell's centre to one side of the box, in strides: the expectation over the bins.
double side_distance(const Head& head, std::size_t side, std::size_t cell) {
  const auto bins = static_cast<std::size_t>(head.sides->shape[1]) / 4;
  const float* logits = head.sides->values.data() + side * bins * head.cells() + cell;
  float highest = logits[0];
  for (std::size_t bin = 1; bin < bins; ++bin) highest = std::max(highest, logits[bin * head.cells()]);
  double sum = 0;
  double expectation = 0;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const double weight = std::exp(logits[bin * head.cells()] - highest);
    sum += weight;
    expectation += weight * static_cast<double>(bin);
  }
  return expectation / sum;
}

Box box_at(const Head& head, std::size_t cell, const Placement& placement) {
  const auto row = static_cast<int>(cell / static_cast<std::size_t>(head.width));
  const double x = static_cast<int>(cell) - row * head.width + 0.5;
  const double y = row + 0.5;
  const double to_image_x = head.stride_px / placement.scale_x;
  const double to_image_y = head.stride_px / placement.scale_y;
  return {(x - side_distance(head, 0, cell)) * to_image_x, (y - side_distance(head, 1, cell)) * to_image_y,
          (x + side_distance(head, 2, cell)) * to_image_x, (y + side_distance(head, 3, cell)) * to_image_y};
}

// Cells whose best class scores well enough and has a counterpart.
void collect(const Head& head, const DecodeContext& context, std::vector<Candidate>& candidates) {
  std::vector<float> best_logit(head.logits->values.begin(),
                                head.logits->values.begin() + static_cast<std::ptrdiff_t>(head.cells()));
  std::vector<std::int32_t> best_class(head.cells(), 0);
  for (std::size_t c = 1; c < context.class_of.size(); ++c) {
    const float* logits = head.logits->values.data() + c * head.cells();
    for (std::size_t i = 0; i < head.cells(); ++i) {
      best_class[i] = logits[i] > best_logit[i] ? static_cast<std::int32_t>(c) : best_class[i];
      best_logit[i] = logits[i] > best_logit[i] ? logits[i] : best_logit[i];
    }
  }
  // Comparing logits spares a sigmoid for nearly every cell; exact within rounding, so the score itself decides at the end.
  const double threshold = context.model.thresholds.score;
  const double least_logit = std::log(threshold / (1 - threshold)) - 1e-3;
  for (std::size_t i = 0; i < head.cells(); ++i) {
    if (!(best_logit[i] >= least_logit)) continue;
    const ClassId id = context.class_of[static_cast<std::size_t>(best_class[i])];
    const float score = sigmoid(best_logit[i]);
    if (id == ClassId::kUnknown || score < context.model.thresholds.score) continue;
    const Box box = box_at(head, i, context.placement);
    const bool finite = std::isfinite(box.left + box.top + box.right + box.bottom);
    if (finite) candidates.push_back({&head, i, score, id, box});
  }
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
  std::map<ClassId, float> score_of;
  for (std::size_t c = 0; c < class_of.size(); ++c) {
    if (class_of[c] == ClassId::kUnknown) continue;
    score_of[class_of[c]] += sigmoid(candidate.head->logits->values[c * candidate.head->cells() + candidate.cell]);
  }
  float total = 0;
  for (const auto& [id, score] : score_of) total += score;
  std::erase_if(score_of, [&](const auto& entry) { return !(entry.second >= kLeastProbability * total); });
  float kept = 0;
  for (const auto& [id, score] : score_of) kept += score;
  std::vector<ClassProbability> probabilities;
  for (const auto& [id, score] : score_of) probabilities.push_back({id, score / kept});
  return probabilities;
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
    const float coefficient = candidate.head->coefficients->values[p * candidate.head->cells() + candidate.cell];
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

std::vector<Instance> decode_yolo_seg(const std::vector<Tensor>& outputs, const DecodeContext& context) {
  const std::vector<Head> heads = heads_of(outputs, context);
  std::vector<Candidate> candidates;
  for (const Head& head : heads) collect(head, context, candidates);
  candidates = suppress(std::move(candidates), context.model.thresholds);

  std::vector<Instance> instances(candidates.size());
  parallel_for(candidates.size(), [&](std::size_t i) { instances[i] = to_instance(candidates[i], outputs.back(), context); });
  std::erase_if(instances, [&](const Instance& instance) {
    const auto pixels = instance.mask.pixels();
    return std::count(pixels.begin(), pixels.end(), 1) < context.model.thresholds.min_area_px;
  });
  return instances;
}

}  // namespace panoptic
