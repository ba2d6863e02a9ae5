// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A value of a JSON file together with its place, so that whatever is wrong with it is said in the file's own terms:
// "predictions.json: image.width must be a whole number from 1 to 16384".
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/geometry.h"

namespace panoptic {

// Refers to a Json that must outlive it. Every function throws Error unless the value is as asked for.
class JsonValue {
 public:
  JsonValue(const Json& json, std::string file) : json_(&json), file_(std::move(file)) {}

  JsonValue at(std::string_view key) const;                        // a member that must be there
  std::optional<JsonValue> find(std::string_view key) const;       // a member that may be there
  std::vector<JsonValue> elements() const;                         // of an array
  std::vector<std::pair<std::string, JsonValue>> members() const;  // of an object, in the file's order

  std::int64_t integer(std::int64_t min, std::int64_t max) const;
  double number(double min, double max) const;
  Vec3d point() const;  // three numbers: metres, each at most 1,000 km
  std::string text() const;
  bool boolean() const;  // true, false, 1 or 0
  bool is_null() const { return json_->is_null(); }

  [[noreturn]] void wrong(std::string_view expected) const;

 private:
  JsonValue(const Json& json, std::string file, std::string place)
      : json_(&json), file_(std::move(file)), place_(std::move(place)) {}

  const Json* json_;
  std::string file_;
  std::string place_;
};

}  // namespace panoptic
