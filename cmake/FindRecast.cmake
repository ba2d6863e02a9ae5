# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# Recast and Detour with its crowd, for whose Debian package CMake has no module.
find_path(Recast_INCLUDE_DIR Recast.h PATH_SUFFIXES recastnavigation recast)
find_library(Recast_LIBRARY Recast)
find_library(Detour_LIBRARY Detour)
find_library(DetourCrowd_LIBRARY DetourCrowd)
mark_as_advanced(Recast_INCLUDE_DIR Recast_LIBRARY Detour_LIBRARY DetourCrowd_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Recast REQUIRED_VARS Recast_LIBRARY Detour_LIBRARY DetourCrowd_LIBRARY
  Recast_INCLUDE_DIR)
if(Recast_FOUND AND NOT TARGET Recast::Recast)
  add_library(Recast::Recast UNKNOWN IMPORTED)
  set_target_properties(Recast::Recast PROPERTIES IMPORTED_LOCATION "${Recast_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Recast_INCLUDE_DIR}")
  add_library(Recast::Detour UNKNOWN IMPORTED)
  set_target_properties(Recast::Detour PROPERTIES IMPORTED_LOCATION "${Detour_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Recast_INCLUDE_DIR}")
  add_library(Recast::DetourCrowd UNKNOWN IMPORTED)
  set_target_properties(Recast::DetourCrowd PROPERTIES IMPORTED_LOCATION "${DetourCrowd_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Recast_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES Recast::Detour)
endif()
