# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# OctoMap's libraries. Its own package file names no targets that survive an install elsewhere.
find_path(OctoMap_INCLUDE_DIR octomap/OcTree.h)
find_library(OctoMap_LIBRARY octomap)
find_library(OctoMath_LIBRARY octomath)
mark_as_advanced(OctoMap_INCLUDE_DIR OctoMap_LIBRARY OctoMath_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OctoMapParts REQUIRED_VARS OctoMap_LIBRARY OctoMath_LIBRARY OctoMap_INCLUDE_DIR)
if(OctoMapParts_FOUND AND NOT TARGET OctoMapParts::octomap)
  add_library(OctoMapParts::octomath UNKNOWN IMPORTED)
  set_target_properties(OctoMapParts::octomath PROPERTIES IMPORTED_LOCATION "${OctoMath_LIBRARY}")
  add_library(OctoMapParts::octomap UNKNOWN IMPORTED)
  set_target_properties(OctoMapParts::octomap PROPERTIES IMPORTED_LOCATION "${OctoMap_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${OctoMap_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES OctoMapParts::octomath)
endif()
