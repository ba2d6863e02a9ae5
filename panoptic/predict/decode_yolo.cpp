// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "panoptic/base/error.h"
#include "panoptic/base/parallel.h"
#include "panoptic/predict/decoders.h"

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

// Edges in pixels of the colour image: pixel u covers [u, u + 1).
struct Box {
  double left = 0;
  double top = 0;
  double right = 0;
  double bottom = 0;

  double area() const { return std::max(0.0, right - left) * std::max(0.0, bottom - top); }
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
  const double x = static_cast<double>(cell % static_cast<std::size_t>(head.width)) + 0.5;
  const double y = static_cast<double>(cell / static_cast<std::size_t>(head.width)) + 0.5;
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

double overlap(const Box& a, const Box& b) {
  const Box common{std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right), std::min(a.bottom, b.bottom)};
  const double joint = a.area() + b.area() - common.area();
  return joint > 0 ? common.area() / joint : 0;
}

// Non-maximum suppression within each class of the label set.
std::vector<Candidate> suppress(std::vector<Candidate> candidates, const Thresholds& thresholds) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  if (candidates.size() > kMaxCandidates) candidates.resize(kMaxCandidates);
  std::vector<Candidate> kept;
  for (const Candidate& candidate : candidates) {
    const bool covered = std::any_of(kept.begin(), kept.end(), [&](const Candidate& better) {
      return better.class_id == candidate.class_id && overlap(better.box, candidate.box) > thresholds.nms_iou;
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

// A window of the prototypes' grid.
struct Window {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;
};

// sigmoid(coefficients . prototypes) within the window.
std::vector<float> mask_scores(const Candidate& candidate, const Tensor& prototypes, const Window& window) {
  const auto stride = static_cast<std::size_t>(prototypes.shape[3]);
  const std::size_t plane = stride * static_cast<std::size_t>(prototypes.shape[2]);
  const auto width = static_cast<std::size_t>(window.width);
  std::vector<float> scores(width * static_cast<std::size_t>(window.height), 0.0F);
  for (std::size_t p = 0; p < static_cast<std::size_t>(prototypes.shape[1]); ++p) {
    const float coefficient = candidate.head->coefficients->values[p * candidate.head->cells() + candidate.cell];
    for (std::size_t y = 0; y < static_cast<std::size_t>(window.height); ++y) {
      const float* in =
          &prototypes
               .values[p * plane + (static_cast<std::size_t>(window.y0) + y) * stride + static_cast<std::size_t>(window.x0)];
      float* out = &scores[y * width];
      for (std::size_t x = 0; x < width; ++x) out[x] += coefficient * in[x];
    }
  }
  std::transform(scores.begin(), scores.end(), scores.begin(), sigmoid);
  return scores;
}

// Where pixel i of the image lies on the prototypes' grid along one axis.
double on_grid(int i, double cells_per_px, int cells) {
  return std::clamp((i + 0.5) * cells_per_px - 0.5, 0.0, static_cast<double>(cells - 1));
}

Instance to_instance(const Candidate& candidate, const Tensor& prototypes, const DecodeContext& context) {
  const Placement& placement = context.placement;
  const auto first = [](double edge) { return std::max(0, static_cast<int>(std::ceil(edge - 0.5))); };
  const auto last = [](double edge, int size) { return std::min(size, static_cast<int>(std::ceil(edge - 0.5))); };
  Instance instance{{candidate.class_id, candidate.score, {}}, first(candidate.box.left), first(candidate.box.top), {}};
  const int width = last(candidate.box.right, placement.image_width) - instance.x0;
  const int height = last(candidate.box.bottom, placement.image_height) - instance.y0;
  if (width < 1 || height < 1) return instance;

  const int grid_width = prototypes.shape[3];
  const int grid_height = prototypes.shape[2];
  const double per_px_x = placement.scale_x * grid_width / placement.input_width;
  const double per_px_y = placement.scale_y * grid_height / placement.input_height;
  const auto column = [&](int u) { return on_grid(instance.x0 + u, per_px_x, grid_width); };
  const auto row = [&](int v) { return on_grid(instance.y0 + v, per_px_y, grid_height); };
  Window window{static_cast<int>(column(0)), static_cast<int>(row(0)), 0, 0};
  window.width = std::min(static_cast<int>(column(width - 1)) + 1, grid_width - 1) - window.x0 + 1;
  window.height = std::min(static_cast<int>(row(height - 1)) + 1, grid_height - 1) - window.y0 + 1;
  const std::vector<float> scores = mask_scores(candidate, prototypes, window);

  instance.mask = Image<std::uint8_t>(width, height);
  for (int v = 0; v < height; ++v) {
    const double y = row(v) - window.y0;
    const int y0 = static_cast<int>(y);
    const auto share_y = static_cast<float>(y - y0);
    const float* upper = &scores[static_cast<std::size_t>(y0) * static_cast<std::size_t>(window.width)];
    const float* lower = y0 + 1 < window.height ? upper + window.width : upper;
    for (int u = 0; u < width; ++u) {
      const double x = column(u) - window.x0;
      const int x0 = static_cast<int>(x);
      const int x1 = std::min(x0 + 1, window.width - 1);
      const auto share_x = static_cast<float>(x - x0);
      const float above = upper[x0] + share_x * (upper[x1] - upper[x0]);
      const float below = lower[x0] + share_x * (lower[x1] - lower[x0]);
      instance.mask(u, v) = above + share_y * (below - above) > context.model.thresholds.mask ? 1 : 0;
    }
  }
  return instance;
}

}  // namespace

std::vector<Instance> decode_yolo_seg(const std::vector<Tensor>& outputs, const DecodeContext& context) {
  const std::vector<Head> heads = heads_of(outputs, context);
  std::vector<Candidate> candidates;
  for (const Head& head : heads) collect(head, context, candidates);
  candidates = suppress(std::move(candidates), context.model.thresholds);

  std::vector<Instance> instances(candidates.size());
  parallel_for(candidates.size(), [&](std::size_t i) {
    instances[i] = to_instance(candidates[i], outputs.back(), context);
    instances[i].segment.class_probabilities = class_probabilities(candidates[i], context.class_of);
  });
  std::erase_if(instances, [&](const Instance& instance) {
    const auto pixels = instance.mask.pixels();
    return std::count(pixels.begin(), pixels.end(), 1) < context.model.thresholds.min_area_px;
  });
  return instances;
}

}  // namespace panoptic
