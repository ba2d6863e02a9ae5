# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# `cpack --config build/release/CPackConfig.cmake -B FOLDER`: Debian packages panoptic, libpanoptic-dev and python3-panoptic (docs/packages.md).
set(_packages program dev)
install(FILES ${PROJECT_SOURCE_DIR}/packaging/panoptic.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  RENAME panoptic COMPONENT program)
find_program(PANOPTIC_GZIP gzip)
if(PANOPTIC_GZIP)
  set(_page ${PROJECT_BINARY_DIR}/panoptic.1.gz)
  execute_process(COMMAND ${PANOPTIC_GZIP} -9nc ${PROJECT_SOURCE_DIR}/packaging/panoptic.1 OUTPUT_FILE ${_page} COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${_page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
endif()

# Python looks for Debian's packages here; pip's place is another component, python.
if(TARGET panoptic_python)
  list(APPEND _packages python-deb)
  set(_python lib/python3/dist-packages/panoptic)
  install(TARGETS panoptic_python LIBRARY DESTINATION ${_python} COMPONENT python-deb EXCLUDE_FROM_ALL)
  file(GLOB _python_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/bindings/python/panoptic/*.py ${PROJECT_SOURCE_DIR}/bindings/python/panoptic/*.pyi
    ${PROJECT_SOURCE_DIR}/bindings/python/panoptic/py.typed)
  install(FILES ${_python_files} DESTINATION ${_python} COMPONENT python-deb EXCLUDE_FROM_ALL)
endif()
set(_copyrights program /panoptic dev /libpanoptic-dev python-deb /python3-panoptic)
while(_copyrights)
  list(POP_FRONT _copyrights _component _name)
  install(FILES ${PROJECT_SOURCE_DIR}/packaging/copyright DESTINATION share/doc${_name} COMPONENT ${_component} EXCLUDE_FROM_ALL)
endwhile()

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL ${_packages})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_VENDOR "The PanopticFusion Authors")
set(CPACK_PACKAGE_CONTACT "The PanopticFusion Authors <panoptic@localhost>")
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/packaging/project_config.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
if(OnnxRuntime_FOUND)
  cmake_path(GET OnnxRuntime_LIBRARY PARENT_PATH _folder)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${_folder})
endif()
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME panoptic)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS sweethome3d-furniture)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "Maps posed RGB-D recordings into a labelled 3D map
 Every point of the map knows what it is and which one it is.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libpanoptic-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "panoptic (= ${PROJECT_VERSION}), libeigen3-dev, libtbb-dev, libtomlplusplus-dev, libfmt-dev, nlohmann-json3-dev, \
zlib1g-dev, libtinygltf-dev, libopencv-core-dev, libopencv-imgproc-dev, libopencv-dnn-dev, libpng-dev, libturbojpeg0-dev, libtiff-dev, libopenexr-dev, \
libsqlite3-dev, libzstd-dev, liblz4-dev, libbz2-dev, librecast-dev, liboctomap-dev, libceres-dev, libembree-dev, \
libzip-dev, zipcmp, zipmerge, ziptool, libtinyobjloader-dev, libnanoflann-dev")
if(PANOPTIC_READS_VIDEO)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libavformat-dev, libavcodec-dev, libswscale-dev")
endif()
set(CPACK_COMPONENT_DEV_DESCRIPTION "Headers and static libraries of panoptic
 find_package(panoptic) finds them.")
set(CPACK_DEBIAN_PYTHON-DEB_PACKAGE_NAME python3-panoptic)
set(CPACK_DEBIAN_PYTHON-DEB_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON-DEB_PACKAGE_DEPENDS "panoptic (= ${PROJECT_VERSION}), python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
set(CPACK_DEBIAN_PYTHON-DEB_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/packaging/python3/postinst ${PROJECT_SOURCE_DIR}/packaging/python3/prerm)
set(CPACK_COMPONENT_PYTHON-DEB_DESCRIPTION "Volumetric panoptic mapping from Python
 Frames, masks, meshes and voxels are NumPy arrays.")
include(CPack)
