// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/json_value.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "panoptic/error.h"

namespace panoptic {

void JsonValue::wrong(std::string_view expected) const {
  throw Error(fmt::format("{}: {} must be {}", file_, place_.empty() ? "the whole" : place_, expected));
}

std::optional<JsonValue> JsonValue::find(std::string_view key) const {
  if (!json_->is_object()) wrong("an object");
  const auto found = json_->find(key);
  if (found == json_->end()) return std::nullopt;
  return JsonValue(*found, file_, place_.empty() ? std::string(key) : fmt::format("{}.{}", place_, key));
}

JsonValue JsonValue::at(std::string_view key) const {
  std::optional<JsonValue> value = find(key);
  if (!value) wrong(fmt::format("an object with the member \"{}\"", key));
  return *value;
}

std::vector<JsonValue> JsonValue::elements() const {
  if (!json_->is_array()) wrong("an array");
  std::vector<JsonValue> values;
  for (std::size_t i = 0; i < json_->size(); ++i) values.push_back({(*json_)[i], file_, fmt::format("{}[{}]", place_, i)});
  return values;
}

std::vector<std::pair<std::string, JsonValue>> JsonValue::members() const {
  if (!json_->is_object()) wrong("an object");
  std::vector<std::pair<std::string, JsonValue>> values;
  for (const auto& [key, value] : json_->items()) values.emplace_back(key, at(key));
  return values;
}

std::int64_t JsonValue::integer(std::int64_t min, std::int64_t max) const {
  const bool fits = json_->is_number_integer() &&
                    !(json_->is_number_unsigned() &&
                      json_->get<std::uint64_t>() > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()));
  const std::int64_t value = fits ? json_->get<std::int64_t>() : 0;
  if (!fits || value < min || value > max) wrong(fmt::format("a whole number from {} to {}", min, max));
  return value;
}

double JsonValue::number(double min, double max) const {
  const double value = json_->is_number() ? json_->get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (!(value >= min && value <= max)) wrong(fmt::format("a number from {} to {}", min, max));
  return value;
}

Vec3d JsonValue::point() const {
  constexpr double kFarthestPoint_m = 1e6;
  const std::vector<JsonValue> c = elements();
  if (c.size() != 3) wrong("three numbers");
  const auto coordinate = [&](std::size_t axis) { return c[axis].number(-kFarthestPoint_m, kFarthestPoint_m); };
  return {coordinate(0), coordinate(1), coordinate(2)};
}

std::string JsonValue::text() const {
  if (!json_->is_string()) wrong("a string");
  return json_->get<std::string>();
}

bool JsonValue::boolean() const {
  if (json_->is_boolean()) return json_->get<bool>();
  return integer(0, 1) == 1;
}

}  // namespace panoptic
