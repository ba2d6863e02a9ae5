// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace panoptic::python {
namespace {

constexpr py::ssize_t kMaxSide_px = 1 << 15;
constexpr double kRigid = 0.05;  // the entries of a rotation that was written down carelessly

template <typename T>
bool is_of(const py::array& array) {
  return py::isinstance<py::array_t<T>>(array);  // in the byte order of this machine
}

void require_size(const py::array& array, const char* what) {
  const py::ssize_t height = array.shape(0);
  const py::ssize_t width = array.shape(1);
  if (height < 1 || width < 1) throw Error(fmt::format("{} has no pixels: it is {}", what, text_of(array)));
  if (height > kMaxSide_px || width > kMaxSide_px) {
    throw Error(fmt::format("{} is {}: an image has at most {} rows and columns", what, text_of(array), kMaxSide_px));
  }
}

// The array's own memory. The pixels of a row must follow one another; rows may begin anywhere.
template <typename T>
ImageView<T> pixels_of(const py::array& array, const char* what) {
  require_size(array, what);
  const auto height = static_cast<int>(array.shape(0));
  const auto width = static_cast<int>(array.shape(1));
  const bool dense = (width == 1 || array.strides(1) == py::ssize_t{sizeof(T)}) && (array.ndim() == 2 || array.strides(2) == 1);
  if (!dense) {
    throw Error(
        fmt::format("{} does not lie row by row in memory (a slice, a flipped or a transposed array?): hand over "
                    "numpy.ascontiguousarray({})",
                    what, what));
  }
  try {
    return {static_cast<const T*>(array.data()), width, height, array.strides(0)};
  } catch (const Error& e) {
    throw Error(fmt::format("{}, an {}: hand over numpy.ascontiguousarray({})", what, e.what(), what));
  }
}

// Numbers as doubles, whatever their type. Throws Error.
py::array_t<double> numbers(const py::handle& object, const char* what) {
  const py::array array = array_of(object, what);
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u') throw Error(fmt::format("{} is {}: it must hold numbers", what, text_of(array)));
  return py::array_t<double, py::array::c_style | py::array::forcecast>(array);
}

Eigen::Matrix4d matrix_from(const py::handle& object, const char* what) {
  const py::array_t<double> array = numbers(object, what);
  if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4) {
    throw Error(fmt::format("{} is {}: it must be a 4x4 matrix", what, text_of(array)));
  }
  return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(array.data());
}

void require_valid(const Camera& camera, const char* what) {
  const bool finite =
      std::isfinite(camera.fx) && std::isfinite(camera.fy) && std::isfinite(camera.cx) && std::isfinite(camera.cy);
  if (!finite || camera.fx <= 0 || camera.fy <= 0) {
    throw Error(fmt::format("{} has fx = {}, fy = {}, cx = {}, cy = {}: they are pixels, and fx and fy above zero", what,
                            camera.fx, camera.fy, camera.cx, camera.cy));
  }
}

}  // namespace

std::string text_of(const py::array& array) {
  return fmt::format("{} of shape {}", std::string(py::str(array.dtype())), std::string(py::str(array.attr("shape"))));
}

py::array array_of(const py::handle& object, const char* what) {
  if (py::isinstance<py::array>(object)) return py::reinterpret_borrow<py::array>(object);
  if (object.is_none()) throw Error(fmt::format("{} is None: it must be an array", what));
  try {
    return py::array(py::module_::import("numpy").attr("asarray")(object));
  } catch (py::error_already_set& e) {
    if (!e.matches(PyExc_Exception)) throw;  // Ctrl-C
    throw Error(fmt::format("{} is no array: {}", what, std::string(py::str(e.value()))));
  }
}

SharedImage<float> depth_image(const py::handle& object, std::optional<double> depth_scale, Lent& lent) {
  const py::array array = array_of(object, "depth");
  if (array.ndim() != 2) throw Error(fmt::format("depth is {}: it must be (height, width)", text_of(array)));
  if (is_of<float>(array)) {
    if (depth_scale) throw Error("depth is float32, which is metres: leave out depth_scale");
    lent.push_back(array);
    return SharedImage<float>(pixels_of<float>(array, "depth"));
  }
  if (!is_of<std::uint16_t>(array)) {
    throw Error(fmt::format(
        "depth is {}: it must be float32 in metres, as depth.astype(numpy.float32), or uint16 with depth_scale", text_of(array)));
  }
  if (!depth_scale || !std::isfinite(*depth_scale) || *depth_scale <= 0) {
    throw Error("depth is uint16: say how many of its units are a metre, for example depth_scale=1000");
  }
  const ImageView<std::uint16_t> raw = pixels_of<std::uint16_t>(array, "depth");
  return SharedImage<float>(in_metres(raw, static_cast<float>(1 / *depth_scale)));
}

SharedImage<float> weight_image(const py::handle& object, Lent& lent) {
  const py::array array = array_of(object, "depth_weight");
  if (array.ndim() != 2 || !is_of<float>(array))
    throw Error(fmt::format("depth_weight is {}: it must be float32 of shape (height, width)", text_of(array)));
  lent.push_back(array);
  return SharedImage<float>(pixels_of<float>(array, "depth_weight"));
}

SharedImage<Rgb> color_image(const py::handle& object, Lent& lent) {
  const py::array array = array_of(object, "color");
  if (array.ndim() != 3 || array.shape(2) != 3 || !is_of<std::uint8_t>(array)) {
    throw Error(fmt::format("color is {}: it must be uint8 of shape (height, width, 3), red first", text_of(array)));
  }
  lent.push_back(array);
  return SharedImage<Rgb>(pixels_of<Rgb>(array, "color"));
}

LentNumbers whole_numbers(const py::handle& object, const char* what) {
  py::array array = array_of(object, what);
  const char kind = array.dtype().kind();
  if (array.ndim() != 2 || (kind != 'i' && kind != 'u')) {
    throw Error(fmt::format("{} is {}: it must hold whole numbers, along two axes (height, width)", what, text_of(array)));
  }
  require_size(array, what);
  const char order = array.dtype().byteorder();
  if (order != '=' && order != '|') array = py::array_t<std::int64_t, py::array::forcecast>(array);
  const WholeNumbers numbers{static_cast<const char*>(array.data()),
                             array.strides(0),
                             array.strides(1),
                             static_cast<int>(array.shape(1)),
                             static_cast<int>(array.shape(0)),
                             static_cast<int>(array.itemsize()),
                             array.dtype().kind() == 'i'};
  return {std::move(array), numbers};
}

py::array_t<std::uint8_t> mask_stack(const py::handle& object, const char* what) {
  py::array array = array_of(object, what);
  if (array.ndim() != 3 || (!is_of<bool>(array) && !is_of<std::uint8_t>(array))) {
    throw Error(fmt::format("{} is {}: they must be bool or uint8 of shape (count, height, width)", what, text_of(array)));
  }
  if (array.shape(1) < 1 || array.shape(2) < 1 || array.shape(1) > kMaxSide_px || array.shape(2) > kMaxSide_px) {
    throw Error(fmt::format("{} are {}: without pixels, or too large", what, text_of(array)));
  }
  return py::array_t<std::uint8_t, py::array::c_style>(is_of<bool>(array) ? array.view("uint8") : array);
}

Pose pose_from(const py::handle& object, const char* what) {
  const Eigen::Matrix4d matrix = matrix_from(object, what);
  if (!matrix.allFinite()) throw Error(fmt::format("{} is not finite: the tracker was lost there, so leave the frame out", what));
  if ((matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > 1e-6) {
    throw Error(fmt::format("{} must have the last row 0 0 0 1: is it transposed?", what));
  }
  Pose pose(matrix);
  if (is_rigid(pose)) return pose;
  if (!is_rigid(pose, kRigid)) throw Error(fmt::format("{} is not a rigid transform: its rotation part is no rotation", what));
  return rigid(matrix);
}

Camera camera_from(const py::handle& object, const char* what, int width, int height) {
  Camera camera;
  if (py::isinstance<Camera>(object)) {
    camera = object.cast<Camera>();
    if (camera.width != width || camera.height != height) {
      throw Error(
          fmt::format("{} is of images of {}x{}, and the image has {}x{}", what, camera.width, camera.height, width, height));
    }
  } else {
    const py::array_t<double> array = numbers(object, what);
    if (array.ndim() != 2 || array.shape(0) != 3 || array.shape(1) != 3) {
      throw Error(fmt::format("{} is {}: it must be a 3x3 matrix of pixels, or a Camera", what, text_of(array)));
    }
    const double* k = array.data();
    if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
      throw Error(fmt::format("{} must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]: is it transposed, or does it have skew?", what));
    }
    camera = {width, height, k[0], k[4], k[2], k[5]};
  }
  require_valid(camera, what);
  return camera;
}

std::optional<double> number_from(const py::handle& object, const char* what) {
  if (object.is_none()) return std::nullopt;
  const double number = PyFloat_AsDouble(object.ptr());
  if (PyErr_Occurred() == nullptr) return number;
  PyErr_Clear();
  throw Error(fmt::format("{} is {}: it must be a number", what, std::string(py::repr(object))));
}

std::optional<std::int64_t> whole_from(const py::handle& object, const char* what) {
  if (object.is_none()) return std::nullopt;
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(object.ptr()));
  const std::int64_t number = index ? PyLong_AsLongLong(index.ptr()) : -1;
  if (PyErr_Occurred() == nullptr) return number;
  PyErr_Clear();
  throw Error(fmt::format("{} is {}: it must be a whole number", what, std::string(py::repr(object))));
}

std::vector<double> times_from(const py::handle& object, const char* what) {
  const py::array_t<double> array = numbers(object, what);
  if (array.ndim() != 1) throw Error(fmt::format("the times of {} are {}: they must be (N,)", what, text_of(array)));
  return {array.data(), array.data() + array.size()};
}

Vec3d point_from(const py::handle& object, const char* what) {
  const py::array_t<double> array = numbers(object, what);
  if (array.ndim() != 1 || array.shape(0) != 3)
    throw Error(fmt::format("{} is {}: it must be x, y, z in metres", what, text_of(array)));
  const Vec3d point(array.data()[0], array.data()[1], array.data()[2]);
  if (!point.allFinite()) throw Error(fmt::format("{} is not finite", what));
  return point;
}

Points points_from(const py::handle& object, const char* what) {
  const py::array_t<double> array = numbers(object, what);
  const bool is_single = array.ndim() == 1 && array.shape(0) == 3;
  if (!is_single && (array.ndim() != 2 || array.shape(1) != 3)) {
    throw Error(fmt::format("{} are {}: they must be (N, 3), or one point (3,), in metres", what, text_of(array)));
  }
  Points points{{}, is_single};
  const double* at = array.data();
  for (py::ssize_t i = 0; i < array.size(); i += 3) {
    points.at.emplace_back(at[i], at[i + 1], at[i + 2]);
    if (!points.at.back().allFinite()) throw Error(fmt::format("{}: point {} is not finite", what, i / 3));
  }
  return points;
}

py::array matrix_of(const Pose& pose) {
  py::array_t<double> array({4, 4});
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(array.mutable_data()) = pose.matrix();
  return array;
}

py::array matrix_of(const Camera& camera) {
  py::array_t<double> array({3, 3});
  const double k[] = {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  std::copy(std::begin(k), std::end(k), array.mutable_data());
  return array;
}

py::array vector_of(const Vec3d& vector) {
  py::array_t<double> array(3);
  std::copy_n(vector.data(), 3, array.mutable_data());
  return array;
}

}  // namespace panoptic::python
