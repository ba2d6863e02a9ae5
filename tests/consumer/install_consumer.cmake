# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# cmake -DBUILD=... -DSOURCE=... -DWORK=... -P install_consumer.cmake
# Installs the build into a fresh prefix, moves the prefix, builds the consumer against it and runs what came out.
function(must)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed: ${ARGN}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
must(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first)
file(RENAME ${WORK}/first ${WORK}/prefix)
foreach(file include/panoptic/panoptic.h include/panoptic/map/voxel_map.h share/panoptic/configs/labels/indoor.toml)
  if(NOT EXISTS ${WORK}/prefix/${file})
    message(FATAL_ERROR "${file} was not installed")
  endif()
endforeach()

if(LAUNCHER)
  set(launcher -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
endif()
must(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=${WORK}/prefix ${launcher})
must(${CMAKE_COMMAND} --build ${WORK}/build)
must(${WORK}/build/consumer)
must(${WORK}/prefix/bin/panoptic --version)

# Nothing of the build or of the sources may be left in what others include.
file(GLOB_RECURSE configs ${WORK}/prefix/*.cmake)
foreach(config ${configs})
  file(READ ${config} text)
  foreach(path ${BUILD} panoptic_flags)
    string(FIND "${text}" "${path}" found)
    if(NOT found EQUAL -1)
      message(FATAL_ERROR "${config} names ${path}")
    endif()
  endforeach()
endforeach()
