# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# The libraries of FFmpeg that read videos, for which CMake has no module.
find_path(FFmpegParts_INCLUDE_DIR libavformat/avformat.h)
set(_libraries avformat avcodec swscale avutil)
set(_variables)
foreach(_library ${_libraries})
  find_library(FFmpegParts_${_library} ${_library})
  list(APPEND _variables FFmpegParts_${_library})
endforeach()
find_path(FFmpegParts_SCALE_INCLUDE_DIR libswscale/swscale.h)
find_path(FFmpegParts_CODEC_INCLUDE_DIR libavcodec/avcodec.h)
mark_as_advanced(FFmpegParts_INCLUDE_DIR FFmpegParts_SCALE_INCLUDE_DIR FFmpegParts_CODEC_INCLUDE_DIR ${_variables})
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(FFmpegParts REQUIRED_VARS ${_variables} FFmpegParts_INCLUDE_DIR FFmpegParts_SCALE_INCLUDE_DIR
  FFmpegParts_CODEC_INCLUDE_DIR)
if(FFmpegParts_FOUND AND NOT TARGET FFmpegParts::video)
  add_library(FFmpegParts::video INTERFACE IMPORTED)
  set_target_properties(FFmpegParts::video PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${FFmpegParts_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${FFmpegParts_avformat};${FFmpegParts_avcodec};${FFmpegParts_swscale};${FFmpegParts_avutil}")
endif()
