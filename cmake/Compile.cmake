# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# Flags of every target of the project, as one interface target that is never exported.
add_library(panoptic_flags INTERFACE)

# The map must be the same bit for bit on every CPU and with every preset: no fused multiply-add, no fast-math.
# The other three let GCC vectorise the integration kernels and change no result there.
target_compile_options(panoptic_flags INTERFACE
  -Wall -Wextra -Wno-missing-field-initializers -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual
  -ffp-contract=off -fno-math-errno -fno-trapping-math -fno-signed-zeros)
if(PANOPTIC_WERROR)
  target_compile_options(panoptic_flags INTERFACE -Werror)
endif()
if(PANOPTIC_ASSERTIONS)
  target_compile_definitions(panoptic_flags INTERFACE PANOPTIC_ASSERTIONS)
endif()
if(PANOPTIC_SANITIZE)
  target_compile_options(panoptic_flags INTERFACE -fsanitize=${PANOPTIC_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(panoptic_flags INTERFACE -fsanitize=${PANOPTIC_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND PANOPTIC_SANITIZE MATCHES "address")
    target_compile_definitions(panoptic_flags INTERFACE __SANITIZE_ADDRESS__)  # as GCC says it
  endif()
endif()
if(PANOPTIC_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "PANOPTIC_FUZZ needs clang: cmake --preset fuzz")
  endif()
  target_compile_options(panoptic_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(PANOPTIC_TIDY)
  find_program(CLANG_TIDY clang-tidy REQUIRED)
  set(CMAKE_CXX_CLANG_TIDY ${CLANG_TIDY} --warnings-as-errors=*)
endif()
if(NOT CMAKE_CONFIGURATION_TYPES AND NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
