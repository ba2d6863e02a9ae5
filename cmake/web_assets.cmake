# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# panoptic_web_assets(<folder>): the files of the built page, compiled in as they are and gzipped. Writes
# ${CMAKE_CURRENT_BINARY_DIR}/web_assets.cpp, the definition of apps/viewer/assets.h; an empty table where there is no such folder.
function(panoptic_web_assets folder)
  set(_types_html "text/html; charset=utf-8")
  set(_types_js "text/javascript; charset=utf-8")
  set(_types_mjs "text/javascript; charset=utf-8")
  set(_types_css "text/css; charset=utf-8")
  set(_types_json "application/json")
  set(_types_svg "image/svg+xml")
  set(_types_txt "text/plain; charset=utf-8")
  set(_types_wasm "application/wasm")
  set(_types_png "image/png")
  set(_types_jpg "image/jpeg")
  set(_types_ico "image/x-icon")
  set(_types_woff2 "font/woff2")
  set(_compressed html js mjs css json svg txt wasm)
  file(GLOB_RECURSE _files CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/*)
  set(_incbins "")
  set(_entries "")
  set(_inputs "")
  set(_number 0)
  foreach(_file ${_files})
    string(REGEX MATCH "[^.]*$" _extension ${_file})
    if(NOT DEFINED _types_${_extension})
      continue()  # source maps and the like are not for browsers
    endif()
    math(EXPR _number "${_number} + 1")
    set(_path "/${_file}")
    if(_file STREQUAL "index.html")
      set(_path "/")
    endif()
    string(APPEND _incbins "PANOPTIC_INCBIN(kPlain${_number}, \"${folder}/${_file}\")\n")
    list(APPEND _inputs ${folder}/${_file})
    set(_gzipped "{}")
    if(_extension IN_LIST _compressed)
      set(_output ${CMAKE_CURRENT_BINARY_DIR}/web_assets/${_number}.gz)
      file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/web_assets)
      add_custom_command(OUTPUT ${_output} COMMAND gzip -9nc ${folder}/${_file} > ${_output} DEPENDS ${folder}/${_file} VERBATIM)
      string(APPEND _incbins "PANOPTIC_INCBIN(kGzipped${_number}, \"${_output}\")\n")
      list(APPEND _inputs ${_output})
      set(_gzipped "between(kGzipped${_number}, kGzipped${_number}End)")
    endif()
    string(APPEND _entries
      "    {\"${_path}\", \"${_types_${_extension}}\", between(kPlain${_number}, kPlain${_number}End), ${_gzipped}},\n")
  endforeach()
  if(_number EQUAL 0)
    message(STATUS "the viewer's page is not built (${folder}): scripts/setup builds it; the program works without")
  endif()
  file(CONFIGURE OUTPUT web_assets.cpp @ONLY CONTENT [==[
#include "apps/viewer/assets.h"

#include <cstddef>
#include <vector>

#define PANOPTIC_INCBIN(name, file)                                                                   \
  asm(".pushsection .rodata\n.global panoptic_" #name "\n.global panoptic_" #name "End\npanoptic_" #name \
      ":\n.incbin \"" file "\"\npanoptic_" #name "End:\n.byte 0\n.popsection\n");                      \
  extern "C" const char name[] asm("panoptic_" #name);                                                \
  extern "C" const char name##End[] asm("panoptic_" #name "End");

@_incbins@
namespace panoptic {
namespace {

[[maybe_unused]] std::string_view between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

std::span<const WebAsset> web_assets() {
  static const std::vector<WebAsset> kAssets = {
@_entries@  };
  return kAssets;
}

}  // namespace panoptic
]==])
  if(_inputs)
    set_source_files_properties(${CMAKE_CURRENT_BINARY_DIR}/web_assets.cpp PROPERTIES OBJECT_DEPENDS "${_inputs}")
  endif()
endfunction()
