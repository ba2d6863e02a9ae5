// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/data/label_json.h"

#include <fmt/format.h>

#include <cstdint>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::int64_t kMostClass = 999;
constexpr double kMostSize_m = 1000;

}  // namespace

Json color_json(const Rgb& color) { return {color.r, color.g, color.b}; }

Rgb color_in(const JsonValue& value) {
  const std::vector<JsonValue> c = value.elements();
  if (c.size() != 3) value.wrong("[red, green, blue]");
  const auto channel = [&](std::size_t i) { return static_cast<std::uint8_t>(c[i].integer(0, 255)); };
  return {channel(0), channel(1), channel(2)};
}

Json classes_json(const LabelSet& labels) {
  Json classes = Json::array();
  for (const LabelClass& c : labels.classes()) {
    classes.push_back({{"id", number(c.id)}, {"name", c.name}, {"is_thing", c.is_thing}, {"color", color_json(c.color)}});
  }
  return classes;
}

std::vector<LabelClass> classes_in(const JsonValue& list) {
  std::vector<LabelClass> classes;
  for (const JsonValue& entry : list.elements()) {
    LabelClass c;
    c.id = static_cast<ClassId>(entry.at("id").integer(1, kMostClass));
    c.name = entry.at("name").text();
    c.is_thing = entry.at("is_thing").boolean();
    c.color = color_in(entry.at("color"));
    if (const auto size = entry.find("max_size_m")) c.max_size_m = size->number(0, kMostSize_m);
    if (const auto support = entry.find("is_support")) c.is_support = support->boolean();
    if (const auto mobile = entry.find("is_mobile")) c.is_mobile = mobile->boolean();
    classes.push_back(std::move(c));
  }
  return classes;
}

LabelSet label_set_of(std::string name, std::vector<LabelClass> classes, const JsonValue& place) {
  try {
    return {std::move(name), std::move(classes)};
  } catch (const Error& e) {
    place.wrong(fmt::format("classes that go together: {}", e.what()));
  }
}

}  // namespace panoptic
