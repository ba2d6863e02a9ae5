// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The questions of recognisers about a network's outputs: shapes, names and ranges.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "panoptic/predict/model.h"
#include "panoptic/predict/network.h"

namespace panoptic {

// "'boxes' 100 x 4, 'labels' 100"; "nothing" without outputs.
std::string outputs_text(const std::vector<Tensor>& outputs);
std::string name_and_shape(const Tensor& tensor);

// The shape without its first dimension where that is 1 and there are more dimensions than `rank`; nothing if the rank is then
// another one.
std::optional<std::vector<int>> shape_of_rank(const Tensor& tensor, std::size_t rank);

// Whether the name, in whatever case, is one of these or contains it.
bool is_named(const Tensor& tensor, std::initializer_list<std::string_view> names);
bool name_contains(const Tensor& tensor, std::string_view part);

// The output that the description's table [outputs] names for a role. Throws Error if the network has none of that name, or it
// does not fit the role.
std::optional<std::size_t> output_named_for(std::string_view role, const std::vector<Tensor>& outputs, const Model& model,
                                            const std::function<bool(const Tensor&)>& fits);
// Another entry of that table; empty if there is none. Throws Error if it is not one of the choices.
std::string output_setting(std::string_view key, std::initializer_list<std::string_view> choices, const Model& model);

// Whether all numbers lie in [0, 1] within rounding of 16-bit floats; false without numbers.
bool are_shares(std::span<const float> values);
// Whether all numbers are whole, and at least 0.
bool are_whole(std::span<const float> values);
// Numbers that are not finite: NaN and plus infinity. Minus infinity is the logit of what cannot be.
std::size_t count_not_finite(std::span<const float> values);

// Keeps those for which the condition holds, unless it holds for none.
template <typename T, typename Condition>
void prefer(std::vector<T>& candidates, Condition condition) {
  std::vector<T> better;
  std::copy_if(candidates.begin(), candidates.end(), std::back_inserter(better), condition);
  if (!better.empty()) candidates = std::move(better);
}

// Values of cells whose channels are last, one plane for each channel.
std::vector<float> to_planes(const std::vector<float>& values, std::size_t channels);

float sigmoid(float x);
// Divides by the sum.
void normalise(std::span<float> shares);
void softmax(std::span<float> logits);

// Throws Error naming the model if a detection's score is no probability.
void require_probability(float score, const Model& model);

// The position of a class that a network names by its number. Throws Error naming the model if there is no such class.
std::size_t class_index(float number, const Model& model);

}  // namespace panoptic
