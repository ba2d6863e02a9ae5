# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# Ceres and the log that its headers use. Its own package file looks for every library that Ceres was built with, for ten seconds.
find_path(Ceres_INCLUDE_DIR ceres/manifold.h)
find_library(Ceres_LIBRARY ceres)
find_library(Glog_LIBRARY glog)
mark_as_advanced(Ceres_INCLUDE_DIR Ceres_LIBRARY Glog_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(CeresParts REQUIRED_VARS Ceres_LIBRARY Glog_LIBRARY Ceres_INCLUDE_DIR)
if(CeresParts_FOUND AND NOT TARGET CeresParts::ceres)
  add_library(CeresParts::glog UNKNOWN IMPORTED)
  set_target_properties(CeresParts::glog PROPERTIES IMPORTED_LOCATION "${Glog_LIBRARY}")
  add_library(CeresParts::ceres UNKNOWN IMPORTED)
  set_target_properties(CeresParts::ceres PROPERTIES IMPORTED_LOCATION "${Ceres_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Ceres_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES CeresParts::glog)
endif()
