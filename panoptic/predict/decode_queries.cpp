// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// DETR, MaskFormer, Mask2Former: a number of queries, each with a distribution of classes, "no object" among them, and a mask.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "panoptic/parallel.h"
#include "panoptic/predict/class_names.h"
#include "panoptic/predict/decoders.h"
#include "panoptic/predict/instance_mask.h"
#include "panoptic/predict/output_shapes.h"

namespace panoptic {
namespace {

// The findings of one query.
struct Query {
  std::size_t row = 0;
  float p_object = 0;  // 1 - p(no object)
  std::vector<float> classes;
  std::size_t best = 0;
};

std::size_t cells_of(const Tensor& masks) {
  const std::vector<int> shape = *shape_of_rank(masks, 3);
  return static_cast<std::size_t>(shape[1]) * static_cast<std::size_t>(shape[2]);
}

// Softmax over the classes and "no object", which is the last one, wherever the description does not list it.
Query query_at(const Tensor& logits, std::size_t row, const Reading& reading, const Model& model) {
  const auto columns = static_cast<std::size_t>(logits.shape.back());
  const float* in = logits.values.data() + row * columns;
  std::vector<float> p(in, in + columns);
  if (reading.numbers == Numbers::kLogits) {
    softmax(p);
  } else {
    normalise(p);
  }
  Query query{row, 1, {p.begin(), p.begin() + static_cast<std::ptrdiff_t>(model.classes.size())}, 0};
  if (columns > model.classes.size()) query.p_object -= p.back();
  for (std::size_t c = 0; c < query.classes.size(); ++c) {
    if (!is_background(model.classes[c])) continue;
    query.p_object -= query.classes[c];
    query.classes[c] = 0;
  }
  query.best = static_cast<std::size_t>(std::max_element(query.classes.begin(), query.classes.end()) - query.classes.begin());
  return query;
}

bool is_finite(const Query& query) { return std::isfinite(query.p_object); }

// The probability of a mask in each cell.
std::vector<float> mask_of(const Tensor& masks, const Query& query, bool are_probabilities) {
  const std::size_t cells = cells_of(masks);
  const float* in = masks.values.data() + query.row * cells;
  std::vector<float> mask(in, in + cells);
  if (!are_probabilities) std::transform(mask.begin(), mask.end(), mask.begin(), sigmoid);
  return mask;
}

ScoreGrid grid_over_image(const Tensor& masks, const Placement& placement) {
  const std::vector<int> shape = *shape_of_rank(masks, 3);
  return {shape[2], shape[1], placement.scale_x * shape[2] / placement.input_width,
          placement.scale_y * shape[1] / placement.input_height};
}

// p(class) of a cell: what the queries say there, each weighed with its mask, as share of all that is said.
ClassScores scores_of(const std::vector<Query>& queries, const std::vector<std::vector<float>>& masks, const ScoreGrid& grid,
                      const DecodeContext& context) {
  ClassScores scores{{}, grid.width, grid.height, grid.cells_per_px_x, grid.cells_per_px_y, {}};
  std::vector<std::size_t> position = positions_of(context.class_of, scores.classes);
  if (context.likeliest_first) {
    scores.classes = context.class_of;
    std::iota(position.begin(), position.end(), std::size_t{0});
  }
  const std::size_t count = scores.classes.size();
  const std::size_t cells = static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height);
  std::vector<std::vector<float>> shares;  // of each query, per value of a cell
  for (const Query& query : queries) {
    shares.emplace_back(count, 0.0F);
    for (std::size_t c = 0; c < query.classes.size(); ++c) shares.back()[position[c]] += query.classes[c];
  }
  scores.values.assign(cells * count, 0.0F);
  parallel_for(static_cast<std::size_t>(grid.height), [&](std::size_t y) {
    const std::size_t begin = y * static_cast<std::size_t>(grid.width);
    for (std::size_t i = begin; i < begin + static_cast<std::size_t>(grid.width); ++i) {
      float* out = &scores.values[i * count];
      float sum = 0;
      for (std::size_t q = 0; q < queries.size(); ++q) {
        for (std::size_t k = 0; k < count; ++k) out[k] += masks[q][i] * shares[q][k];
      }
      for (std::size_t k = 0; k < count; ++k) sum += out[k];
      for (std::size_t k = 0; k < count && sum > 0; ++k) out[k] /= sum;
    }
  });
  return scores;
}

// Which query each cell belongs to: the one with the largest p(O) x mask.
std::vector<std::size_t> owners_of(const std::vector<Query>& queries, const std::vector<std::vector<float>>& masks,
                                   std::size_t cells) {
  std::vector<std::size_t> owner(cells, queries.size());
  std::vector<float> best(cells, 0.0F);
  for (std::size_t q = 0; q < queries.size(); ++q) {
    for (std::size_t i = 0; i < cells; ++i) {
      const float value = queries[q].p_object * masks[q][i];
      if (!(value > best[i])) continue;
      best[i] = value;
      owner[i] = q;
    }
  }
  return owner;
}

// The cells that a query keeps, as scores; nothing if most of its mask went to others: then it saw what they saw.
std::vector<float> kept_mask(std::size_t q, const std::vector<float>& mask, const std::vector<std::size_t>& owner,
                             float threshold) {
  constexpr double kLeastKept = 0.8;
  std::vector<float> kept(mask.size(), 0.0F);
  std::size_t inside = 0;
  std::size_t own = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] > threshold) ++inside;
    if (owner[i] != q) continue;
    kept[i] = mask[i];
    if (mask[i] > threshold) ++own;
  }
  if (own == 0 || static_cast<double>(own) < kLeastKept * static_cast<double>(inside)) kept.clear();
  return kept;
}

// The smallest rectangle of pixels around the cells above 0, a cell wider.
PixelRect rect_around(const std::vector<float>& mask, const ScoreGrid& grid, const Placement& placement) {
  int left = grid.width;
  int right = -1;
  int top = grid.height;
  int bottom = -1;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (mask[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x)] <= 0) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = y;
    }
  }
  const Box box{(left - 1) / grid.cells_per_px_x, (top - 1) / grid.cells_per_px_y, (right + 2) / grid.cells_per_px_x,
                (bottom + 2) / grid.cells_per_px_y};
  return pixels_in(box, placement.image_width, placement.image_height);
}

std::vector<Instance> instances_of(const std::vector<Query>& queries, const std::vector<std::vector<float>>& masks,
                                   const ScoreGrid& grid, const DecodeContext& context) {
  const Thresholds& thresholds = context.model.thresholds;
  const std::vector<std::size_t> owner = owners_of(queries, masks, masks.empty() ? 0 : masks[0].size());
  std::vector<ClassId> things;
  for (std::size_t c = 0; c < context.class_of.size(); ++c) things.push_back(context.thing_of(c));
  std::vector<Instance> instances;
  for (std::size_t q = 0; q < queries.size(); ++q) {
    const ClassId id = things[queries[q].best];
    if (id == ClassId::kUnknown) continue;
    std::vector<float> mask = kept_mask(q, masks[q], owner, thresholds.mask);
    if (mask.empty()) continue;
    const PixelRect rect = rect_around(mask, grid, context.placement);
    if (rect.width < 1 || rect.height < 1) continue;
    Instance instance{{id, queries[q].p_object, distribution_of(queries[q].classes, things)}, rect.x0, rect.y0, {}};
    instance.mask = draw_mask(rect, grid, {0, 0, grid.width, grid.height, std::move(mask)}, thresholds.mask);
    instances.push_back(std::move(instance));
  }
  std::stable_sort(instances.begin(), instances.end(),
                   [](const Instance& a, const Instance& b) { return a.segment.score > b.segment.score; });
  drop_small(instances, thresholds);
  instances.resize(std::min(instances.size(), static_cast<std::size_t>(thresholds.max_instances)));
  return instances;
}

}  // namespace

Match recognise_queries(const std::vector<Tensor>& outputs, const Model& model) {
  const int classes = static_cast<int>(model.classes.size());
  const bool lists_none = std::any_of(model.classes.begin(), model.classes.end(), is_background);
  if (std::any_of(outputs.begin(), outputs.end(), [](const Tensor& t) { return t.is_whole; })) {
    return {.why_not = "it gives whole numbers, which queries have none of"};
  }
  const auto are_logits = [&](const Tensor& t) {
    const auto shape = t.shape.size() == 4 ? std::nullopt : shape_of_rank(t, 2);
    return shape && (*shape)[0] > 0 && ((*shape)[1] == classes + 1 || (lists_none && (*shape)[1] == classes));
  };
  std::optional<std::size_t> logits = output_named_for("classes", outputs, model, are_logits);
  for (std::size_t i = 0; i < outputs.size() && !logits; ++i) {
    if (are_logits(outputs[i]) && !name_contains(outputs[i], "aux") && !name_contains(outputs[i], "box")) logits = i;
  }
  if (!logits) return {.why_not = fmt::format("no output has queries x {} ({} classes and \"no object\")", classes + 1, classes)};
  const int queries = (*shape_of_rank(outputs[*logits], 2))[0];
  const auto are_masks = [&](const Tensor& t) {
    const auto shape = t.shape.size() >= 3 ? shape_of_rank(t, 3) : std::nullopt;
    return shape && (*shape)[0] == queries && !t.values.empty();
  };
  std::optional<std::size_t> masks = output_named_for("masks", outputs, model, are_masks);
  for (std::size_t i = 0; i < outputs.size() && !masks; ++i) {
    if (i != *logits && are_masks(outputs[i]) && !name_contains(outputs[i], "aux")) masks = i;
  }
  if (!masks) return {.why_not = fmt::format("no output has {} masks, one for each of its queries", queries)};
  Reading reading;
  reading.roles = {*logits, *masks};
  reading.numbers = are_shares(outputs[*logits].values) ? Numbers::kProbabilities : Numbers::kLogits;
  reading.text = fmt::format("{} queries with classes ({}) and masks ({})", queries, name_and_shape(outputs[*logits]),
                             name_and_shape(outputs[*masks]));
  return {.reading = std::move(reading)};
}

Findings decode_queries(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context) {
  const Tensor& logits = outputs[reading.roles[0]];
  const Tensor& masks = outputs[reading.roles[1]];
  const bool are_probabilities = are_shares(masks.values);
  const std::size_t count = masks.values.size() / cells_of(masks);
  std::vector<Query> queries;
  std::vector<std::vector<float>> all_masks;
  for (std::size_t row = 0; row < count; ++row) {
    Query query = query_at(logits, row, reading, context.model);
    if (!is_finite(query)) continue;
    all_masks.push_back(mask_of(masks, query, are_probabilities));
    queries.push_back(std::move(query));
  }
  const ScoreGrid grid = grid_over_image(masks, context.placement);
  Findings findings{.scores = scores_of(queries, all_masks, grid, context)};
  std::vector<Query> objects;
  std::vector<std::vector<float>> object_masks;
  for (std::size_t q = 0; q < queries.size(); ++q) {
    if (!(queries[q].p_object >= context.model.thresholds.score)) continue;
    objects.push_back(queries[q]);
    object_masks.push_back(std::move(all_masks[q]));
  }
  findings.instances = instances_of(objects, object_masks, grid, context);
  return findings;
}

}  // namespace panoptic
