# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# cmake -DBUILD=... -DSOURCE=... -DWORK=... -P install_consumer.cmake
# Installs the build into a fresh prefix, moves the prefix, builds the consumers against it and runs what came out.
function(must)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed: ${ARGN}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
must(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first)
file(RENAME ${WORK}/first ${WORK}/prefix)
foreach(file include/panoptic/panoptic.h include/panoptic/voxel_map.h share/panoptic/configs/labels/indoor.toml)
  if(NOT EXISTS ${WORK}/prefix/${file})
    message(FATAL_ERROR "${file} was not installed")
  endif()
endforeach()
file(GLOB internal LIST_DIRECTORIES true ${WORK}/prefix/include/panoptic/*)
list(FILTER internal EXCLUDE REGEX "\\.h$")
if(internal)
  message(FATAL_ERROR "internal headers were installed: ${internal}")
endif()

set(build ${CMAKE_COMMAND} -S ${SOURCE} -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=${WORK}/prefix)
if(LAUNCHER)
  list(APPEND build -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
endif()

# The core alone, where nothing that the other parts need can be found.
foreach(package embree libzip tinyobjloader)
  list(APPEND without -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
must(${build} -B ${WORK}/core -DHEADERS=${WORK}/prefix/include/panoptic ${without})
must(${CMAKE_COMMAND} --build ${WORK}/core)
must(${WORK}/core/consumer)
execute_process(COMMAND ldd ${WORK}/core/consumer OUTPUT_VARIABLE libraries COMMAND_ERROR_IS_FATAL ANY)
message(STATUS "the consumer of panoptic::core needs\n${libraries}")
if(libraries MATCHES "lib(embree|zip|cpp-httplib|tinyobjloader|meshoptimizer)[^a-z]")
  message(FATAL_ERROR "panoptic::core needs lib${CMAKE_MATCH_1}")
endif()

if(EXISTS ${WORK}/prefix/lib/libpanoptic_sim.a)
  must(${build} -B ${WORK}/whole -DWHOLE=ON)
  must(${CMAKE_COMMAND} --build ${WORK}/whole)
  must(${WORK}/whole/consumer)
endif()
if(EXISTS ${WORK}/prefix/bin/panoptic)
  must(${WORK}/prefix/bin/panoptic --version)
endif()

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
