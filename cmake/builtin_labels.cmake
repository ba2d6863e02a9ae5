# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# Writes ${CMAKE_CURRENT_BINARY_DIR}/builtin_labels.cpp from configs/labels/*.toml.
file(GLOB _label_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/configs/labels/*.toml)
set(_entries "")
set(_names "")
foreach(_file ${_label_files})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${_file})
  get_filename_component(_name ${_file} NAME_WE)
  file(READ ${_file} _text)
  string(APPEND _entries "    {\"${_name}\", R\"toml(${_text})toml\"},\n")
  list(APPEND _names ${_name})
endforeach()
string(REPLACE ";" ", " _names "${_names}")
file(CONFIGURE OUTPUT builtin_labels.cpp @ONLY CONTENT [==[
#include "panoptic/data/builtin_labels.h"

namespace panoptic {
namespace {

struct Entry {
  std::string_view name;
  std::string_view text;
};

constexpr Entry kEntries[] = {
@_entries@};

}  // namespace

std::optional<std::string_view> builtin_label_set(std::string_view name) {
  for (const Entry& entry : kEntries) {
    if (entry.name == name) return entry.text;
  }
  return std::nullopt;
}

std::string builtin_label_set_names() { return "@_names@"; }

}  // namespace panoptic
]==])
