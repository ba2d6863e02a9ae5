// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Between NumPy and the library: the only place that looks at the type, shape and strides of an array.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "bindings/python/bind.h"
#include "bindings/python/pixels.h"
#include "panoptic/geometry.h"
#include "panoptic/image.h"

namespace panoptic::python {

// The array behind an object that numpy.asarray takes: itself, a tensor's memory, or a copy of a list. `what` names it in
// messages. Throws Error.
py::array array_of(const py::handle& object, const char* what);
// "float64 of shape (480, 640)"
std::string text_of(const py::array& array);

// Arrays whose memory something reads.
using Lent = std::vector<py::object>;

// f32 metres, or u16 that `depth_scale` divides to metres; (height, width). Metres are read where they lie, as long as `lent`
// lives. Throws Error.
SharedImage<float> depth_image(const py::handle& object, std::optional<double> depth_scale, Lent& lent);
// f32 (height, width), read where it lies. Throws Error.
SharedImage<float> weight_image(const py::handle& object, Lent& lent);
// u8 (height, width, 3), red first; read where it lies. Throws Error.
SharedImage<Rgb> color_image(const py::handle& object, Lent& lent);

// An image of whole numbers of any type, read where it lies as long as the array is kept.
struct LentNumbers {
  py::array array;
  WholeNumbers numbers;
};
LentNumbers whole_numbers(const py::handle& object, const char* what);  // throws Error

// bool or u8 as bytes, (count, height, width), one row after another. Throws Error.
py::array_t<std::uint8_t> mask_stack(const py::handle& object, const char* what);

// A 4x4 matrix that is a rigid transform, or nearly. Throws Error.
Pose pose_from(const py::handle& object, const char* what);
// fx, fy, cx and cy of a 3x3 matrix, or a Camera, for images of this size. Throws Error.
Camera camera_from(const py::handle& object, const char* what, int width, int height);
// One number; none for None. Throws Error.
std::optional<double> number_from(const py::handle& object, const char* what);
// A whole number; none for None. Throws Error.
std::optional<std::int64_t> whole_from(const py::handle& object, const char* what);
// Numbers one after the other, (N,). Throws Error.
std::vector<double> times_from(const py::handle& object, const char* what);
// Three finite numbers. Throws Error.
Vec3d point_from(const py::handle& object, const char* what);
// One point (3,) or several (N, 3), of finite numbers. Throws Error.
struct Points {
  std::vector<Vec3d> at;
  bool is_single = false;
};
Points points_from(const py::handle& object, const char* what);

py::array matrix_of(const Pose& pose);
py::array matrix_of(const Camera& camera);
py::array vector_of(const Vec3d& vector);

// Poses one after the other, (N, 4, 4).
template <typename Poses>
py::array matrices_of(const Poses& poses) {
  py::array_t<double> matrices({static_cast<py::ssize_t>(poses.size()), py::ssize_t{4}, py::ssize_t{4}});
  double* out = matrices.mutable_data();
  for (const auto& pose : poses) {
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(out);
    matrix = pose.world_from_camera.matrix();
    out += matrix.size();
  }
  return matrices;
}

template <typename Poses>
py::array times_of(const Poses& poses) {
  py::array_t<double> times(static_cast<py::ssize_t>(poses.size()));
  std::transform(poses.begin(), poses.end(), times.mutable_data(), [](const auto& pose) { return pose.time_s; });
  return times;
}

// Vectors of two or three numbers as (N, 2) or (N, 3).
template <typename T, int kNumbers>
py::array rows_of(const std::vector<Eigen::Matrix<T, kNumbers, 1>>& vectors) {
  py::array_t<T> array({static_cast<py::ssize_t>(vectors.size()), py::ssize_t{kNumbers}});
  T* out = array.mutable_data();
  for (const auto& vector : vectors) out = std::copy_n(vector.data(), kNumbers, out);
  return array;
}

// An array that reads memory of `owner` and keeps it alive. It cannot be written to.
template <typename T>
py::array view(const T* data, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides, const py::handle& owner) {
  py::array array(py::dtype::of<T>(), std::move(shape), std::move(strides), data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

template <typename T>
py::array image_view(const ImageView<T>& image, const py::handle& owner) {
  const T* first = image.empty() ? nullptr : image.row(0);
  return view(first, {image.height(), image.width()}, {image.row_bytes(), py::ssize_t{sizeof(T)}}, owner);
}
inline py::array image_view(const ImageView<Rgb>& image, const py::handle& owner) {
  const auto* first = image.empty() ? nullptr : &image.row(0)->r;
  return view(first, {image.height(), image.width(), 3}, {image.row_bytes(), py::ssize_t{sizeof(Rgb)}, 1}, owner);
}

}  // namespace panoptic::python
