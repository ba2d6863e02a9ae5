# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# panoptic_builtin_texts(<header> <function> <files>): files of configs/ compiled in, so that the program needs none at run time.
# Writes ${CMAKE_CURRENT_BINARY_DIR}/<name of the header>.cpp, which defines what the header declares:
#   std::optional<std::string_view> <function>(std::string_view name);   // the text of <name>.toml
#   std::string <function>_names();                                      // "indoor, scannet20"
function(panoptic_builtin_texts header function)
  set(_entries "")
  set(_names "")
  foreach(_file ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${_file})
    get_filename_component(_name ${_file} NAME_WE)
    file(READ ${_file} _text)
    string(APPEND _entries "    {\"${_name}\", R\"toml(${_text})toml\"},\n")
    list(APPEND _names ${_name})
  endforeach()
  string(REPLACE ";" ", " _names "${_names}")
  get_filename_component(_output ${header} NAME_WE)
  file(CONFIGURE OUTPUT ${_output}.cpp @ONLY CONTENT [==[
#include "@header@"

namespace panoptic {
namespace {

struct Entry {
  std::string_view name;
  std::string_view text;
};

constexpr Entry kEntries[] = {
@_entries@};

}  // namespace

std::optional<std::string_view> @function@(std::string_view name) {
  for (const Entry& entry : kEntries) {
    if (entry.name == name) return entry.text;
  }
  return std::nullopt;
}

std::string @function@_names() { return "@_names@"; }

}  // namespace panoptic
]==])
endfunction()
