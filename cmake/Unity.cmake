# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# With PANOPTIC_UNITY several sources are compiled as one, so that what they include is parsed once: a third of the time for a
# whole build. After a change to one source its batch is compiled, which is why the preset dev does without.
option(PANOPTIC_UNITY "compile several sources as one (needs Python)" OFF)
if(PANOPTIC_UNITY)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/unity_batches.py)
  # GCC takes a batch's sources for headers and asks why their types are local.
  target_compile_options(panoptic_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()

# panoptic_batches(<result> <name> <sources>): what a target is to compile; the batches' own files are in a folder <name>.
function(panoptic_batches result name)
  set(sources ${ARGN})
  if(PANOPTIC_UNITY)
    list(FILTER sources INCLUDE REGEX "\\.cpp$")
    execute_process(COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/cmake/unity_batches.py ${PROJECT_SOURCE_DIR}
      ${CMAKE_CURRENT_BINARY_DIR}/unity_${name} ${sources} OUTPUT_VARIABLE lines OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    string(REPLACE "\n" ";" sources "${lines}")
  endif()
  set(${result} ${sources} PARENT_SCOPE)
endfunction()
