# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# `cmake --install build/release --prefix X`: the program, the public headers, the static libraries, the configurations,
# and find_package(panoptic COMPONENTS core simulation evaluation). The install can be moved as a whole.
include(CMakePackageConfigHelpers)

set(_package ${CMAKE_INSTALL_LIBDIR}/cmake/panoptic)
set(_targets_core core base data bags map io predict fusion crf objects meshing tracking mapfile analysis planning mapping)
set(_targets_simulation simulation sim)
set(_targets_evaluation evaluation eval)
set(PANOPTIC_COMPONENTS core)
foreach(_component simulation evaluation)
  if(TARGET panoptic_${_component})
    list(APPEND PANOPTIC_COMPONENTS ${_component})
  endif()
endforeach()
foreach(_component ${PANOPTIC_COMPONENTS})
  list(TRANSFORM _targets_${_component} PREPEND panoptic_)
  install(TARGETS ${_targets_${_component}} EXPORT panoptic_${_component} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
  install(EXPORT panoptic_${_component} NAMESPACE panoptic:: DESTINATION ${_package} COMPONENT dev)
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/panoptic DESTINATION include COMPONENT dev)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs DESTINATION ${CMAKE_INSTALL_DATADIR}/panoptic COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
if(TARGET panoptic)
  set_target_properties(panoptic PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}/panoptic")
  install(TARGETS panoptic RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endif()

# An ONNX Runtime that scripts/setup fetched belongs to nobody else on the machine: it is installed with us, and the package
# names the copy. One of the system is looked up again where the package is used.
set(PANOPTIC_ONNXRUNTIME_COPY "")
if(OnnxRuntime_FOUND)
  cmake_path(IS_PREFIX PROJECT_SOURCE_DIR "${OnnxRuntime_LIBRARY}" NORMALIZE _is_ours)
  if(_is_ours)
    file(REAL_PATH "${OnnxRuntime_LIBRARY}" _library)
    install(FILES ${_library} DESTINATION ${CMAKE_INSTALL_LIBDIR}/panoptic RENAME libonnxruntime.so.1 COMPONENT program)
    set(PANOPTIC_ONNXRUNTIME_COPY ${CMAKE_INSTALL_LIBDIR}/panoptic/libonnxruntime.so.1)
  endif()
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/panopticConfig.cmake.in ${PROJECT_BINARY_DIR}/panopticConfig.cmake
  INSTALL_DESTINATION ${_package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/panopticConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/panopticConfig.cmake ${PROJECT_BINARY_DIR}/panopticConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/FindOpenCVParts.cmake ${PROJECT_SOURCE_DIR}/cmake/FindOnnxRuntime.cmake
  ${PROJECT_SOURCE_DIR}/cmake/FindTurboJPEG.cmake ${PROJECT_SOURCE_DIR}/cmake/FindLZ4.cmake ${PROJECT_SOURCE_DIR}/cmake/FindRecast.cmake
  ${PROJECT_SOURCE_DIR}/cmake/FindOctoMapParts.cmake ${PROJECT_SOURCE_DIR}/cmake/FindCeresParts.cmake
  ${PROJECT_SOURCE_DIR}/cmake/FindFFmpegParts.cmake DESTINATION ${_package} COMPONENT dev)
