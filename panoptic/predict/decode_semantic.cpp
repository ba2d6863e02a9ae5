// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "panoptic/parallel.h"
#include "panoptic/predict/decoders.h"
#include "panoptic/predict/output_shapes.h"

namespace panoptic {
namespace {

// e^x for x <= 0, within 3e-6 of the true value relatively. A plain loop over it is vectorised, over std::exp it is not.
inline float exp_nonpositive(float x) {
  constexpr float kLog2E = 1.44269504F;
  constexpr float kRoundToInteger = 12582912.0F;  // 1.5 * 2^23: adding and subtracting it rounds
  constexpr float kLowest = -87.0F;               // below, the result would not be a normal number
  const float t = (x > kLowest ? x : kLowest) * kLog2E;
  const float whole = (t + kRoundToInteger) - kRoundToInteger;
  const float f = t - whole;  // -0.5..0.5
  const float power = 1.0F + f * (0.69314718F + f * (0.24022651F + f * (0.05550411F + f * (0.00961813F + f * 0.00133336F))));
  return power * std::bit_cast<float>((static_cast<std::int32_t>(whole) + 127) << 23);
}

// Class values of a network, one plane per class.
struct Planes {
  std::vector<float> values;
  std::size_t count = 0;
  int width = 0;
  int height = 0;
  bool are_logits = true;
};

// Whether one class leads at all. A cell that prefers none, or holds numbers that are not finite, says nothing.
bool says_something(float highest, float sum, std::size_t count, bool are_logits) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  if (!(highest >= -kLargest && highest <= kLargest && sum > 0 && sum <= kLargest)) return false;
  const auto all = static_cast<float>(count);
  return are_logits ? sum < all : highest * all > sum * 1.0001F;
}

// One row: softmax over the network's classes, or their probabilities as they are, added up where they have the same position.
void decode_row(const Planes& planes, int y, const std::vector<std::size_t>& position, ClassScores& scores) {
  const auto width = static_cast<std::size_t>(scores.width);
  const std::size_t plane = width * static_cast<std::size_t>(scores.height);
  const std::size_t count = scores.classes.size();
  const float* row = planes.values.data() + static_cast<std::size_t>(y) * width;
  std::vector<float> highest(row, row + width);
  for (std::size_t c = 1; c < position.size(); ++c) {
    const float* in = row + c * plane;
    for (std::size_t x = 0; x < width; ++x) highest[x] = in[x] > highest[x] ? in[x] : highest[x];
  }
  std::vector<float> sum(width, 0.0F);
  std::vector<float> added(width * count, 0.0F);
  for (std::size_t c = 0; c < position.size(); ++c) {
    const float* in = row + c * plane;
    float* out = added.data() + position[c] * width;
    if (planes.are_logits) {
      for (std::size_t x = 0; x < width; ++x) {
        const float e = exp_nonpositive(in[x] - highest[x]);
        out[x] += e;
        sum[x] += e;
      }
    } else {
      for (std::size_t x = 0; x < width; ++x) {
        const float p = in[x] > 0 ? in[x] : 0.0F;
        out[x] += p;
        sum[x] += p;
      }
    }
  }
  float* values = scores.values.data() + static_cast<std::size_t>(y) * width * count;
  for (std::size_t x = 0; x < width; ++x) {
    const bool counts = says_something(highest[x], sum[x], position.size(), planes.are_logits);
    for (std::size_t k = 0; k < count; ++k) values[x * count + k] = counts ? added[k * width + x] / sum[x] : 0.0F;
  }
}

// One plane per class, whatever order the network gives its numbers in.
Planes planes_of(Tensor tensor, const Reading& reading) {
  Planes planes{{}, 0, reading.width, reading.height, reading.numbers == Numbers::kLogits};
  const std::size_t cells = static_cast<std::size_t>(reading.width) * static_cast<std::size_t>(reading.height);
  planes.count = tensor.values.size() / cells;
  if (!reading.channels_last || planes.count == 1) {
    planes.values = std::move(tensor.values);
    return planes;
  }
  planes.values = to_planes(tensor.values, planes.count);
  return planes;
}

// A single plane is the probability of the one class, or of the second of two: the rest is the probability of the other.
void add_opposite(Planes& planes) {
  const std::size_t cells = planes.values.size();
  std::vector<float> both(2 * cells, 0.0F);
  std::copy(planes.values.begin(), planes.values.end(), both.begin() + static_cast<std::ptrdiff_t>(cells));
  if (!planes.are_logits) {
    for (std::size_t i = 0; i < cells; ++i) both[i] = 1 - planes.values[i];
  }
  planes.values = std::move(both);
  planes.count = 2;
}

constexpr float kIgnored = 255;  // what many data sets write where there is no class

// Class numbers: each is a class of probability 1.
void decode_numbers(const Tensor& tensor, const std::vector<std::size_t>& position, const DecodeContext& context,
                    ClassScores& scores) {
  const std::size_t count = scores.classes.size();
  for (std::size_t i = 0; i < tensor.values.size(); ++i) {
    const float number = tensor.values[i];
    if (number == kIgnored || number < 0) continue;
    scores.values[i * count + position[class_index(number, context.model)]] = 1;
  }
}

}  // namespace

Findings decode_semantic(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context) {
  ClassScores scores;
  scores.width = reading.width;
  scores.height = reading.height;
  scores.cells_per_px_x = context.placement.scale_x * scores.width / context.placement.input_width;
  scores.cells_per_px_y = context.placement.scale_y * scores.height / context.placement.input_height;
  Tensor& tensor = outputs[reading.roles[0]];
  const std::size_t cells = static_cast<std::size_t>(scores.width) * static_cast<std::size_t>(scores.height);
  const bool has_opposite = reading.numbers != Numbers::kClassNumbers && tensor.values.size() == cells;
  std::vector<ClassId> class_of = context.class_of;
  if (has_opposite && class_of.size() == 1) class_of.insert(class_of.begin(), ClassId::kUnknown);
  std::vector<std::size_t> position = positions_of(class_of, scores.classes);
  if (context.likeliest_first) {
    scores.classes = class_of;
    std::iota(position.begin(), position.end(), std::size_t{0});
  }
  scores.values.resize(cells * scores.classes.size());
  if (reading.numbers == Numbers::kClassNumbers) {
    decode_numbers(tensor, position, context, scores);
    return {.scores = std::move(scores)};
  }
  Planes planes = planes_of(std::move(tensor), reading);
  if (has_opposite) add_opposite(planes);
  parallel_for(static_cast<std::size_t>(scores.height),
               [&](std::size_t y) { decode_row(planes, static_cast<int>(y), position, scores); });
  return {.scores = std::move(scores)};
}

}  // namespace panoptic
