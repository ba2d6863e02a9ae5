# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# The three OpenCV libraries that the project uses. Debian ships their headers in small packages (libopencv-dnn-dev ...);
# OpenCV's own CMake package is only in libopencv-dev, which pulls in 200 packages more, so they are looked up here.
find_path(OpenCVParts_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
set(_parts core imgproc dnn)
set(_required OpenCVParts_INCLUDE_DIR)
foreach(part ${_parts})
  find_library(OpenCVParts_${part} opencv_${part})
  list(APPEND _required OpenCVParts_${part})
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVParts REQUIRED_VARS ${_required})
if(OpenCVParts_FOUND)
  foreach(part ${_parts})
    if(NOT TARGET OpenCVParts::${part})
      add_library(OpenCVParts::${part} UNKNOWN IMPORTED)
      set_target_properties(OpenCVParts::${part} PROPERTIES IMPORTED_LOCATION "${OpenCVParts_${part}}"
        INTERFACE_INCLUDE_DIRECTORIES "${OpenCVParts_INCLUDE_DIR}")
    endif()
  endforeach()
endif()
