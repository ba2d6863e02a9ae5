# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(ZLIB REQUIRED)
# base/ alone: images, the map file, bags
find_package(SQLite3 3.37 REQUIRED)
find_package(zstd REQUIRED)
find_package(LZ4 REQUIRED)
find_package(BZip2 REQUIRED)
find_package(PNG REQUIRED)
find_package(TurboJPEG REQUIRED)
find_package(TIFF 4.5 REQUIRED)
find_package(OpenEXR 3.1 REQUIRED)  # of which OpenEXRCore alone is linked: it needs zlib and nothing else
find_package(OpenCVParts REQUIRED)
find_package(TinyGLTF REQUIRED)
if(PANOPTIC_PARALLEL STREQUAL "tbb")
  find_package(TBB REQUIRED)
endif()
# io/ alone: the videos of phones. Without it, a recording with a video says how to extract the images.
find_package(FFmpegParts QUIET)
option(PANOPTIC_VIDEO "read videos (FFmpeg's libraries)" ${FFmpegParts_FOUND})
if(PANOPTIC_VIDEO AND NOT FFmpegParts_FOUND)
  message(FATAL_ERROR "PANOPTIC_VIDEO needs libavformat-dev, libavcodec-dev and libswscale-dev")
endif()
# tracking/ alone: the pose graph
find_package(CeresParts REQUIRED)
# planning/ alone: the navigation mesh, the octree
find_package(Recast REQUIRED)
find_package(OctoMapParts REQUIRED)
# sim/ alone: rays, the furniture's archive and its models
if(PANOPTIC_SIM)
  find_package(embree 3 REQUIRED)
  find_package(libzip REQUIRED)  # its package refers to the tools zipcmp, zipmerge and ziptool
  find_package(tinyobjloader REQUIRED)
endif()
# eval/ alone: headers only, without a package of its own
if(PANOPTIC_EVAL)
  find_path(NANOFLANN_INCLUDE_DIR nanoflann.hpp REQUIRED)
endif()
# apps/ alone
if(PANOPTIC_APPS)
  find_package(CLI11 REQUIRED)
endif()
if(PANOPTIC_VIEWER)
  # The headers must see the options that the library was built with, which only its pkg-config file tells.
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(CppHttplib REQUIRED IMPORTED_TARGET cpp-httplib)
  find_package(meshoptimizer REQUIRED)
endif()
# bindings/python alone. Of several Pythons the first that has NumPy.
set(PANOPTIC_PYTHON_FOUND FALSE)
if(PANOPTIC_SANITIZE)
  # The interpreter is made without a sanitizer, so that the runtime has to be loaded before it: clang's address sanitizer has one.
  execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=libclang_rt.asan-${CMAKE_SYSTEM_PROCESSOR}.so
    OUTPUT_VARIABLE PANOPTIC_PYTHON_RUNTIME ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT PANOPTIC_PYTHON_SANITIZED OR NOT PANOPTIC_SANITIZE MATCHES "address" OR NOT EXISTS "${PANOPTIC_PYTHON_RUNTIME}")
    set(PANOPTIC_PYTHON OFF)
  endif()
endif()
if(PANOPTIC_PYTHON AND PANOPTIC_SIM AND PANOPTIC_EVAL)
  foreach(candidate ${Python_EXECUTABLE} python3 /usr/bin/python3)
    execute_process(COMMAND ${candidate} -c "import numpy, sys; print(sys.executable)" OUTPUT_VARIABLE executable ERROR_QUIET
      OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE result)
    if(result EQUAL 0)
      set(Python_EXECUTABLE ${executable})
      break()
    endif()
  endforeach()
  find_package(Python 3.11 QUIET COMPONENTS Interpreter Development.Module NumPy)
  find_package(pybind11 2.10 QUIET CONFIG)
  if(Python_FOUND AND pybind11_FOUND)
    set(PANOPTIC_PYTHON_FOUND TRUE)
  else()
    message(STATUS "The Python module is not built: it needs python3-dev, python3-numpy and python3-pybind11. scripts/setup installs them.")
  endif()
endif()
find_package(OnnxRuntime)
if(NOT OnnxRuntime_FOUND)
  message(STATUS "ONNX Runtime not found: networks run on OpenCV DNN alone (slower). scripts/setup fetches it, or set OnnxRuntime_ROOT.")
endif()
