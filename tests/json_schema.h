// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The part of JSON Schema that the project's own schemas use. An unknown keyword is an error, so that none is passed over.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <string_view>

#include "panoptic/base/json.h"

namespace panoptic::test {

class JsonSchema {
 public:
  explicit JsonSchema(Json schema) : root_(std::move(schema)) {}

  // The first thing that does not fit, with its place; empty if all fits.
  std::string complaint(const Json& value) const { return complaint(root_, value, "$"); }

 private:
  // `type`: the name of one, or a list of them.
  static bool has_type(const Json& value, const Json& type) {
    if (!type.is_array()) return is_of_type(value, type.get<std::string>());
    return std::any_of(type.begin(), type.end(), [&](const Json& t) { return is_of_type(value, t.get<std::string>()); });
  }

  static bool is_of_type(const Json& value, const std::string& type) {
    if (type == "null") return value.is_null();
    if (type == "boolean") return value.is_boolean();
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "integer") return value.is_number_integer();
    return type == "number" && value.is_number();
  }

  static std::string unknown_keyword(const Json& schema) {
    static const std::set<std::string> kKnown = {
        "$schema", "$defs",    "$ref",     "title",   "description", "type", "properties", "required", "additionalProperties",
        "items",   "minItems", "maxItems", "minimum", "maximum",     "enum"};
    for (const auto& [key, value] : schema.items()) {
      if (!kKnown.contains(key)) return key;
    }
    return {};
  }

  std::string complaint(const Json& schema, const Json& value, const std::string& at) const {
    if (schema.contains("$ref")) {
      const std::string pointer = schema["$ref"].get<std::string>().substr(1);
      return complaint(root_.at(Json::json_pointer(pointer)), value, at);
    }
    if (const std::string key = unknown_keyword(schema); !key.empty())
      return "the schema's keyword " + key + " is not known here";
    if (schema.contains("type") && !has_type(value, schema["type"]))
      return fmt::format("{} is no {}", at,
                         schema["type"].is_string() ? schema["type"].get<std::string>() : schema["type"].dump());
    const bool is_listed =
        !schema.contains("enum") || std::find(schema["enum"].begin(), schema["enum"].end(), value) != schema["enum"].end();
    if (!is_listed) return at + " is none of " + schema["enum"].dump();
    if (schema.contains("minimum") && value.get<double>() < schema["minimum"].get<double>()) return at + " is too small";
    if (schema.contains("maximum") && value.get<double>() > schema["maximum"].get<double>()) return at + " is too large";
    if (schema.contains("minItems") && value.size() < schema["minItems"].get<std::size_t>()) return at + " has too few items";
    if (schema.contains("maxItems") && value.size() > schema["maxItems"].get<std::size_t>()) return at + " has too many items";
    return value.is_object() ? members_complaint(schema, value, at) : items_complaint(schema, value, at);
  }

  std::string items_complaint(const Json& schema, const Json& value, const std::string& at) const {
    if (!value.is_array() || !schema.contains("items")) return {};
    for (std::size_t i = 0; i < value.size(); ++i) {
      std::string found = complaint(schema["items"], value[i], fmt::format("{}[{}]", at, i));
      if (!found.empty()) return found;
    }
    return {};
  }

  std::string members_complaint(const Json& schema, const Json& value, const std::string& at) const {
    if (schema.contains("required")) {
      for (const Json& key : schema["required"]) {
        if (!value.contains(key.get<std::string>())) return fmt::format("{} has no {}", at, key.get<std::string>());
      }
    }
    for (const auto& [key, member] : value.items()) {
      const std::string place = at + "." + key;
      const bool known = schema.contains("properties") && schema["properties"].contains(key);
      const Json rest = schema.contains("additionalProperties") ? schema["additionalProperties"] : Json(true);
      if (!known && rest == false) return place + " is not in the schema";
      if (!known && !rest.is_object()) continue;
      std::string found = complaint(known ? schema["properties"][key] : rest, member, place);
      if (!found.empty()) return found;
    }
    return {};
  }

  Json root_;
};

}  // namespace panoptic::test
