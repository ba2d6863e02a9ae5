// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "panoptic/base/config.h"
#include "panoptic/base/files.h"
#include "panoptic/data/builtin_labels.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr int kMaxClassId = 999;

struct ClassText {
  int id = 0;
  std::string name;
  bool thing = true;
  std::vector<double> color{128, 128, 128};
  double max_size_m = 0;
  bool support = false;
  bool mobile = false;
};

LabelClass to_class(const ClassText& text, const std::string& source) {
  if (text.color.size() != 3) throw Error(fmt::format("{}: class '{}': color must be [red, green, blue]", source, text.name));
  const auto channel = [&](std::size_t i) { return static_cast<std::uint8_t>(std::clamp(text.color[i], 0.0, 255.0)); };
  return {static_cast<ClassId>(text.id),
          text.name,
          text.thing,
          {channel(0), channel(1), channel(2)},
          text.max_size_m,
          text.support,
          text.mobile};
}

Rgb from_hsv(double hue, double saturation, double value) {
  const auto channel = [&](double n) {
    const double k = std::fmod(n + hue * 6, 6.0);
    const double c = value - value * saturation * std::max(0.0, std::min({k, 4 - k, 1.0}));
    return static_cast<std::uint8_t>(std::lround(c * 255));
  };
  return {channel(5), channel(3), channel(1)};
}

}  // namespace

LabelSet::LabelSet(std::string name, std::vector<LabelClass> classes) : name_(std::move(name)), classes_(std::move(classes)) {
  std::sort(classes_.begin(), classes_.end(), [](const LabelClass& a, const LabelClass& b) { return a.id < b.id; });
  for (std::size_t i = 0; i < classes_.size(); ++i) {
    const LabelClass& c = classes_[i];
    if (number(c.id) < 1 || number(c.id) > kMaxClassId) {
      throw Error(
          fmt::format("label set '{}': class '{}' has id {}; ids must be 1..{}", name_, c.name, number(c.id), kMaxClassId));
    }
    if (i > 0 && classes_[i - 1].id == c.id) {
      throw Error(
          fmt::format("label set '{}': classes '{}' and '{}' share id {}", name_, classes_[i - 1].name, c.name, number(c.id)));
    }
    if (c.name.empty() || find(c.name) != &c) {
      throw Error(fmt::format("label set '{}': the name '{}' of class {} is empty or used twice", name_, c.name, number(c.id)));
    }
  }
  if (!classes_.empty()) first_thing_ = static_cast<std::uint16_t>(number(classes_.back().id) + 1);
}

const LabelClass* LabelSet::find(ClassId id) const {
  const auto found =
      std::lower_bound(classes_.begin(), classes_.end(), id, [](const LabelClass& c, ClassId i) { return c.id < i; });
  return found != classes_.end() && found->id == id ? &*found : nullptr;
}

const LabelClass* LabelSet::find(std::string_view name) const {
  const auto found = std::find_if(classes_.begin(), classes_.end(), [&](const LabelClass& c) { return c.name == name; });
  return found != classes_.end() ? &*found : nullptr;
}

bool LabelSet::is_thing(ClassId id) const {
  const LabelClass* c = find(id);
  return c != nullptr && c->is_thing;
}

bool LabelSet::is_support(ClassId id) const {
  const LabelClass* c = find(id);
  return c != nullptr && c->is_support;
}

bool LabelSet::is_mobile(ClassId id) const {
  const LabelClass* c = find(id);
  return c != nullptr && c->is_mobile;
}

bool LabelSet::is_stuff(ClassId id) const {
  const LabelClass* c = find(id);
  return c != nullptr && !c->is_thing;
}

std::string_view LabelSet::name_of(ClassId id) const {
  const LabelClass* c = find(id);
  return c != nullptr ? std::string_view(c->name) : "unknown";
}

LabelSet load_label_set(const std::string& name_or_path) {
  std::string name;
  std::vector<ClassText> classes;
  const auto append_class = [&]() -> Fields {
    ClassText& c = classes.emplace_back();
    return {{"id", &c.id, "the class number", {.min = 1, .max = kMaxClassId, .choices = {}, .required = true}},
            {"name", &c.name, "the class name", required()},
            {"thing", &c.thing, "true: countable objects; false: stuff such as walls", {}},
            {"color", &c.color, "red, green, blue in pictures", in_range(0, 255)},
            {"max_size_m", &c.max_size_m, "nothing of this class is longer; 0 = no limit", in_range(0, 1000)},
            {"support", &c.support, "true: has a level top that other things stand on", {}},
            {"mobile", &c.mobile, "true: moves by itself (people, animals) and is kept out of the map", {}}};
  };
  const Fields fields = {{"name", &name, "the name of the label set", required()},
                         {"class", AppendTable(append_class), "a class", required()}};
  if (const auto text = builtin_label_set(name_or_path)) {
    read_toml_text(*text, "built-in label set " + name_or_path, fields);
  } else if (is_there(name_or_path)) {
    read_toml_file(name_or_path, fields);
  } else {
    throw Error(fmt::format("there is no label set '{}': name a built-in one ({}) or a TOML file", name_or_path,
                            builtin_label_set_names()));
  }
  std::vector<LabelClass> converted;
  for (const ClassText& c : classes) converted.push_back(to_class(c, name_or_path));
  try {
    return {name, std::move(converted)};
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", name_or_path, e.what()));
  }
}

Rgb color_of(PanopticId id, const LabelSet& labels) {
  if (id == PanopticId::kUnknown) return {70, 70, 70};
  if (!labels.is_object(id)) {
    const LabelClass* stuff = labels.find(static_cast<ClassId>(number(id)));
    return stuff != nullptr ? stuff->color : Rgb{70, 70, 70};
  }
  constexpr double kGoldenRatio = 0.6180339887498949;  // successive hues land far apart
  const std::uint32_t k = number(id) - labels.first_thing();
  const double hue = std::fmod(k * kGoldenRatio, 1.0);
  return from_hsv(hue, 0.55 + 0.15 * (k % 4), 0.95 - 0.12 * (k % 3));
}

}  // namespace panoptic
