// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/output_shapes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "panoptic/base/text.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::size_t kMostListed = 14;  // of a YOLO with three strides

}  // namespace

std::string name_and_shape(const Tensor& tensor) {
  const std::string shape = tensor.shape.empty() ? "one number" : fmt::format("{}", fmt::join(tensor.shape, " x "));
  return tensor.name.empty() ? shape : fmt::format("'{}' {}", tensor.name, shape);
}

std::string outputs_text(const std::vector<Tensor>& outputs) {
  if (outputs.empty()) return "nothing";
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < outputs.size() && i < kMostListed; ++i) parts.push_back(name_and_shape(outputs[i]));
  if (outputs.size() > kMostListed) parts.push_back(fmt::format("{} more", outputs.size() - kMostListed));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::optional<std::vector<int>> shape_of_rank(const Tensor& tensor, std::size_t rank) {
  std::vector<int> shape = tensor.shape;
  if (shape.size() == rank + 1 && shape.front() == 1) shape.erase(shape.begin());
  if (shape.size() != rank) return std::nullopt;
  return shape;
}

bool name_contains(const Tensor& tensor, std::string_view part) {
  return lower_case(tensor.name).find(part) != std::string::npos;
}

bool is_named(const Tensor& tensor, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), lower_case(tensor.name)) != names.end();
}

std::optional<std::size_t> output_named_for(std::string_view role, const std::vector<Tensor>& outputs, const Model& model,
                                            const std::function<bool(const Tensor&)>& fits) {
  const auto entry = model.outputs.find(std::string(role));
  if (entry == model.outputs.end()) return std::nullopt;
  const auto found = std::find_if(outputs.begin(), outputs.end(), [&](const Tensor& t) { return t.name == entry->second; });
  if (found == outputs.end()) {
    throw Error(fmt::format("{}: [outputs] {} = \"{}\": the network has no output of that name; it gives {}", model.path.string(),
                            role, entry->second, outputs_text(outputs)));
  }
  if (!fits(*found)) {
    throw Error(
        fmt::format("{}: [outputs] {} = \"{}\": this output does not have the shape or the type of {}; the network gives {}",
                    model.path.string(), role, entry->second, role, outputs_text(outputs)));
  }
  return static_cast<std::size_t>(found - outputs.begin());
}

std::string output_setting(std::string_view key, std::initializer_list<std::string_view> choices, const Model& model) {
  const auto entry = model.outputs.find(std::string(key));
  if (entry == model.outputs.end()) return "";
  if (std::find(choices.begin(), choices.end(), entry->second) != choices.end()) return entry->second;
  throw Error(fmt::format("{}: [outputs] {} = \"{}\": use one of: {}", model.path.string(), key, entry->second,
                          fmt::join(choices, ", ")));
}

bool are_shares(std::span<const float> values) {
  constexpr float kRounding = 1e-3F;
  return !values.empty() &&
         std::all_of(values.begin(), values.end(), [](float v) { return v >= -kRounding && v <= 1 + kRounding; });
}

bool are_whole(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return v >= 0 && v == std::floor(v) && v < 1e6F; });
}

std::size_t count_not_finite(std::span<const float> values) {
  constexpr std::uint32_t kInfinity = 0x7F800000;
  constexpr std::uint32_t kMagnitude = 0x7FFFFFFF;
  std::uint32_t count = 0;
  for (const float value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    count += (bits & kMagnitude) > kInfinity || bits == kInfinity ? 1U : 0U;
  }
  return count;
}

std::vector<float> to_planes(const std::vector<float>& values, std::size_t channels) {
  const std::size_t cells = values.size() / channels;
  std::vector<float> planes(values.size());
  for (std::size_t i = 0; i < cells; ++i) {
    for (std::size_t c = 0; c < channels; ++c) planes[c * cells + i] = values[i * channels + c];
  }
  return planes;
}

void normalise(std::span<float> shares) {
  const float sum = std::accumulate(shares.begin(), shares.end(), 0.0F);
  for (float& value : shares) value /= sum;
}

void softmax(std::span<float> logits) {
  const float highest = *std::max_element(logits.begin(), logits.end());
  for (float& value : logits) value = std::exp(value - highest);
  normalise(logits);
}

float sigmoid(float x) { return 1.0F / (1.0F + std::exp(-x)); }

void require_probability(float score, const Model& model) {
  if (are_shares({&score, 1})) return;
  throw Error(
      fmt::format("{}: the network gives {} as the score of a detection, which is no probability: are its outputs what "
                  "they are taken for? [outputs] can name them (docs/networks.md)",
                  model.path.string(), score));
}

std::size_t class_index(float number, const Model& model) {
  const bool is_whole = number == std::floor(number);
  if (is_whole && number >= 0 && number < static_cast<float>(model.classes.size())) return static_cast<std::size_t>(number);
  throw Error(fmt::format("{}: the network gives the class number {}, but its description has {} classes, numbered from 0",
                          model.path.string(), number, model.classes.size()));
}

}  // namespace panoptic
