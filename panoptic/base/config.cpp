// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/config.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <type_traits>

#include "panoptic/base/files.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::uintmax_t kMaxTomlBytes = 4 << 20;
constexpr int kMaxDots = 256;

// toml++ bounds the depth of values but not of dotted keys, and takes a nested table apart recursively: a.a.a.a... with a
// million parts would overflow the stack. True for such a text.
bool nests_too_deep(std::string_view text) {
  int dots = 0;
  char previous = '\n';
  for (const char c : text) {
    if (c == '\n' || c == '=' || c == ',' || c == '{' || c == '}') dots = 0;
    if (c == '.' && previous != '.' && ++dots > kMaxDots) return true;
    if (c != ' ' && c != '\t') previous = c;
  }
  return false;
}

// A text, as messages call it.
struct Source {
  std::string_view name;
  bool has_lines = true;  // false for a setting, which is no file
};

std::string place(const Source& source, const toml::source_region& at) {
  return source.has_lines && at.begin.line != 0 ? fmt::format("{}:{}", source.name, at.begin.line) : std::string(source.name);
}
std::string place(const Source& source, const toml::node& node) { return place(source, node.source()); }

class Reader {
 public:
  explicit Reader(const Source& source) : source_(source) {}

  void table(const toml::table& table, const Fields& fields) const {
    walk(table, "", fields);
    for (const Field& field : fields) {
      if (field.allowed.required && !table.at_path(field.key)) {
        throw Error(fmt::format("{}: the key '{}' is missing ({})", place(source_, table), field.key, field.help));
      }
    }
  }

 private:
  void walk(const toml::table& table, const std::string& prefix, const Fields& fields) const {
    for (const auto& item : table) {
      const toml::node& node = item.second;
      const std::string key = prefix + std::string(item.first.str());
      const auto field = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.key == key; });
      if (field != fields.end()) {
        std::visit([&](auto value) { read(node, *field, value); }, field->value);
      } else if (node.is_table() && is_group(key, fields)) {
        walk(*node.as_table(), key + ".", fields);
      } else {
        throw Error(fmt::format("{}: unknown key '{}'; known here: {}", place(source_, node), key, siblings(prefix, fields)));
      }
    }
  }

  static bool is_group(const std::string& key, const Fields& fields) {
    return std::any_of(fields.begin(), fields.end(), [&](const Field& f) { return f.key.starts_with(key + "."); });
  }

  static std::string siblings(const std::string& prefix, const Fields& fields) {
    std::vector<std::string> names;
    for (const Field& field : fields) {
      if (!field.key.starts_with(prefix)) continue;
      const std::string rest = field.key.substr(prefix.size());
      names.push_back(rest.substr(0, rest.find('.')));
    }
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return fmt::format("{}", fmt::join(names, ", "));
  }

  [[noreturn]] void wrong(const toml::node& node, const Field& field, std::string_view expected) const {
    throw Error(fmt::format("{}: '{}' must be {}", place(source_, node), field.key, expected));
  }

  double number(const toml::node& node, const Field& field) const {
    const auto value = node.value<double>();
    if (!value || node.is_boolean()) wrong(node, field, "a number");
    const auto& [min, max, choices, required] = field.allowed;
    if (!std::isfinite(*value) || *value < min || *value > max) {
      wrong(node, field, fmt::format("between {} and {}, not {}", min, max, *value));
    }
    return *value;
  }

  std::string text(const toml::node& node, const Field& field) const {
    const auto value = node.value<std::string>();
    if (!value) wrong(node, field, "a string");
    const auto& choices = field.allowed.choices;
    if (!choices.empty() && std::find(choices.begin(), choices.end(), *value) == choices.end()) {
      wrong(node, field, fmt::format("one of {}, not \"{}\"", fmt::join(choices, ", "), *value));
    }
    return *value;
  }

  void read(const toml::node& node, const Field& field, bool* value) const {
    if (!node.is_boolean()) wrong(node, field, "true or false");
    *value = *node.value<bool>();
  }
  void read(const toml::node& node, const Field& field, int* value) const {
    if (!node.is_integer()) wrong(node, field, "a whole number");
    const double wide = number(node, field);
    if (std::abs(wide) > std::numeric_limits<int>::max()) wrong(node, field, "a 32-bit whole number");
    *value = static_cast<int>(wide);
  }
  void read(const toml::node& node, const Field& field, float* value) const {
    const double wide = number(node, field);
    if (std::abs(wide) > std::numeric_limits<float>::max()) wrong(node, field, "a number that fits 32 bits");
    *value = static_cast<float>(wide);
  }
  void read(const toml::node& node, const Field& field, double* value) const { *value = number(node, field); }
  void read(const toml::node& node, const Field& field, std::optional<double>* value) const { *value = number(node, field); }
  void read(const toml::node& node, const Field& field, std::string* value) const { *value = text(node, field); }
  void read(const toml::node& node, const Field& field, std::vector<double>* value) const {
    value->clear();
    for (const toml::node& element : array(node, field)) value->push_back(number(element, field));
  }
  void read(const toml::node& node, const Field& field, std::vector<std::string>* value) const {
    value->clear();
    if (node.is_string()) {  // a list of one
      value->push_back(text(node, field));
      return;
    }
    for (const toml::node& element : array(node, field)) value->push_back(text(element, field));
  }
  void read(const toml::node& node, const Field& field, std::map<std::string, std::string>* value) const {
    if (!node.is_table()) wrong(node, field, "a table of strings");
    value->clear();
    for (const auto& [name, element] : *node.as_table()) (*value)[std::string(name.str())] = text(element, field);
  }
  void read(const toml::node& node, const Field& field, std::map<std::string, std::map<std::string, std::string>>* value) const {
    if (!node.is_table()) wrong(node, field, "a table of tables of strings");
    value->clear();
    for (const auto& [name, element] : *node.as_table()) read(element, field, &(*value)[std::string(name.str())]);
  }
  void read(const toml::node& node, const Field& field, const AppendTable& append) const {
    for (const toml::node& element : array(node, field)) {
      if (!element.is_table()) wrong(element, field, "an array of tables");
      table(*element.as_table(), append());
    }
  }

  const toml::array& array(const toml::node& node, const Field& field) const {
    if (!node.is_array()) wrong(node, field, "an array");
    return *node.as_array();
  }

  Source source_;
};

// A basic string on one line, right for values and for keys.
std::string quoted(const std::string& text) {
  constexpr unsigned char kSpace = 0x20;
  constexpr unsigned char kDelete = 0x7F;
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (byte < kSpace || byte == kDelete) {
      result += fmt::format("\\u{:04X}", byte);
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string key_text(const std::string& key) {
  const bool bare = !key.empty() &&
                    std::all_of(key.begin(), key.end(), [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; });
  return bare ? key : quoted(key);
}

// The shortest digits that read back as the same number; always recognisable as a TOML float.
template <typename T>
std::string float_text(T value) {
  std::string digits = fmt::format("{}", value);
  if (digits.find_first_of(".en") == std::string::npos) digits += ".0";
  return digits;
}

std::string map_text(const std::map<std::string, std::string>& map) {
  std::vector<std::string> items;
  for (const auto& [key, value] : map) items.push_back(fmt::format("{} = {}", key_text(key), quoted(value)));
  return items.empty() ? "{}" : fmt::format("{{ {} }}", fmt::join(items, ", "));
}

struct ToText {
  std::string operator()(const bool* v) const { return *v ? "true" : "false"; }
  std::string operator()(const int* v) const { return fmt::format("{}", *v); }
  std::string operator()(const float* v) const { return float_text(*v); }
  std::string operator()(const double* v) const { return float_text(*v); }
  std::string operator()(const std::string* v) const { return quoted(*v); }
  std::string operator()(const std::optional<double>* v) const { return v->has_value() ? float_text(**v) : ""; }
  std::string operator()(const std::vector<double>* v) const {
    std::vector<std::string> items;
    std::transform(v->begin(), v->end(), std::back_inserter(items), float_text<double>);
    return fmt::format("[{}]", fmt::join(items, ", "));
  }
  std::string operator()(const std::vector<std::string>* v) const {
    std::vector<std::string> items;
    std::transform(v->begin(), v->end(), std::back_inserter(items), quoted);
    return fmt::format("[{}]", fmt::join(items, ", "));
  }
  std::string operator()(const std::map<std::string, std::string>* v) const { return map_text(*v); }
  std::string operator()(const std::map<std::string, std::map<std::string, std::string>>* v) const {
    std::vector<std::string> items;
    for (const auto& [key, value] : *v) items.push_back(fmt::format("{} = {}", key_text(key), map_text(value)));
    return items.empty() ? "{}" : fmt::format("{{ {} }}", fmt::join(items, ", "));
  }
  std::string operator()(const AppendTable&) const { return ""; }
};

std::string value_text(const Field& field) { return std::visit(ToText{}, field.value); }

std::string allowed_text(const Allowed& allowed) {
  if (!allowed.choices.empty()) return fmt::format(" [{}]", fmt::join(allowed.choices, "|"));
  if (std::isfinite(allowed.min) || std::isfinite(allowed.max)) return fmt::format(" [{} to {}]", allowed.min, allowed.max);
  return "";
}

toml::table parsed(std::string_view text, const Source& source) {
  if (nests_too_deep(text)) throw Error(fmt::format("{}: keys are nested deeper than {} tables", source.name, kMaxDots));
  try {
    return toml::parse(text, source.name);
  } catch (const toml::parse_error& e) {
    throw Error(fmt::format("{}: not valid TOML: {}", place(source, e.source()), e.description()));
  }
}

void read_toml(std::string_view text, const Source& source, const Fields& fields) {
  Reader(source).table(parsed(text, source), fields);
}

}  // namespace

void append_group(Fields& fields, std::string_view group, Fields nested) {
  for (Field& field : nested) {
    field.key = fmt::format("{}.{}", group, field.key);
    fields.push_back(std::move(field));
  }
}

void read_toml_text(std::string_view text, std::string_view source_name, const Fields& fields) {
  read_toml(text, {source_name}, fields);
}

std::optional<double> number_in_toml(std::string_view text, std::string_view source_name, std::string_view key) {
  return parsed(text, {source_name}).at_path(key).value<double>();
}

void read_toml_file(const std::filesystem::path& path, const Fields& fields) {
  read_toml_text(read_file(path, kMaxTomlBytes), path.string(), fields);
}

void set_field(const Fields& fields, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos || equals == 0) {
    throw Error(fmt::format("option {}: expected key=value, for example map.voxel_size_m=0.02", assignment));
  }
  if (assignment.find('\n') != std::string_view::npos) throw Error(fmt::format("option {}: expected one line", assignment));
  const std::string_view key = assignment.substr(0, equals);
  const std::string_view value = assignment.substr(equals + 1);
  const auto field = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.key == key; });
  // A bare word is text; a list of text may also be one, or be written as a list.
  const bool is_text = field != fields.end() && std::holds_alternative<std::string*>(field->value) && !value.starts_with('"');
  const bool is_word = field != fields.end() && std::holds_alternative<std::vector<std::string>*>(field->value) &&
                       !value.empty() && value.find_first_of("[\"'") != 0;
  const std::string source = fmt::format("option {}", assignment);
  Fields settable = fields;
  for (Field& f : settable) f.allowed.required = false;
  const std::string text = fmt::format("{} = {}", key, is_text || is_word ? quoted(std::string(value)) : std::string(value));
  read_toml(text, {source, false}, settable);
}

std::string to_toml(const Fields& fields) {
  std::vector<std::string> groups = {""};  // keys outside any table come first, or they would land in the table before them
  std::map<std::string, std::string> lines;
  for (const Field& field : fields) {
    const std::string value = value_text(field);
    if (value.empty()) continue;
    const std::size_t dot = field.key.rfind('.');
    const std::string group = dot == std::string::npos ? "" : field.key.substr(0, dot);
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
    lines[group] += fmt::format("# {}{}\n{} = {}\n", field.help, allowed_text(field.allowed),
                                dot == std::string::npos ? field.key : field.key.substr(dot + 1), value);
  }
  std::string text = lines[""];
  for (const std::string& group : groups) {
    if (!group.empty()) text += fmt::format("\n[{}]\n{}", group, lines[group]);
  }
  return text;
}

std::string describe(const Fields& fields) {
  std::string text;
  for (const Field& field : fields) {
    text += fmt::format("  {} = {}{}\n      {}\n", field.key, value_text(field), allowed_text(field.allowed), field.help);
  }
  return text;
}

}  // namespace panoptic
