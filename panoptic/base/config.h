// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One list of fields per struct gives TOML in and out, `--set key=value`, ranges and help. Every TOML file of the project
// (options, label sets, model descriptions, calibrations) is read through here, so an unknown key, a wrong type or a value
// out of range is always an Error that names the file, the line and what would be right.
//
//   struct TrackerOptions { float iou_threshold = 0.25F; };
//   Fields fields(TrackerOptions& o) { return {{"iou_threshold", &o.iou_threshold, "Eq. 4: ...", in_range(0, 1)}}; }
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace panoptic {

struct Field;
using Fields = std::vector<Field>;

// Reads an array of tables ([[class]]): called once per table, appends an element and returns its fields.
using AppendTable = std::function<Fields()>;

struct Allowed {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices;  // for strings; empty = any
  bool required = false;             // the key must be in the file
};

inline Allowed in_range(double min, double max) { return {min, max, {}, false}; }
inline Allowed one_of(std::vector<std::string> choices) { return {.choices = std::move(choices)}; }
inline Allowed required() { return {.required = true}; }

struct Field {
  using Value = std::variant<bool*, int*, float*, double*, std::string*, std::optional<double>*, std::vector<double>*,
                             std::vector<std::string>*, std::map<std::string, std::string>*,
                             std::map<std::string, std::map<std::string, std::string>>*, AppendTable>;

  std::string key;  // dotted path within the file: "tracker.iou_threshold"
  Value value;
  std::string help;  // one sentence
  Allowed allowed;
};

// The fields of a nested struct under "group.".
void append_group(Fields& fields, std::string_view group, Fields nested);

// Reads into the fields; keys that the file lacks keep their value. Throws Error as described above.
void read_toml_file(const std::filesystem::path& path, const Fields& fields);
void read_toml_text(std::string_view text, std::string_view source_name, const Fields& fields);
// The number at a dotted key, if there is one, whatever else the text holds. Throws Error: not TOML.
std::optional<double> number_in_toml(std::string_view text, std::string_view source_name, std::string_view key);

// Sets one field from "tracker.iou_threshold=0.3" (a bare word is taken as a string). Throws Error.
void set_field(const Fields& fields, std::string_view assignment);

// TOML text that read_toml_text takes back to the same values. Arrays of tables are not written.
std::string to_toml(const Fields& fields);

// Two lines per field: key, default and allowed values; then the help.
std::string describe(const Fields& fields);

}  // namespace panoptic
