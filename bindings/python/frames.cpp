// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/frames.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "bindings/python/arrays.h"

namespace panoptic::python {
namespace {

void require(const py::object& object, const char* what) {
  if (object.is_none()) throw Error(fmt::format("{} is missing: a frame has depth, color, K and pose", what));
}

Camera color_camera(const FrameArrays& arrays, const Camera& depth_camera, const ImageView<Rgb>& color) {
  if (!arrays.color_k.is_none()) return camera_from(arrays.color_k, "color_K", color.width(), color.height());
  if (!color.same_size(depth_camera.width, depth_camera.height)) {
    throw Error(fmt::format("color has {}x{} pixels and depth {}x{}: give color_K, and color_from_depth if the cameras are apart",
                            color.width(), color.height(), depth_camera.width, depth_camera.height));
  }
  return depth_camera;
}

std::shared_ptr<Frame> make_frame(const py::object& depth, const py::object& color, const py::object& k, const py::object& pose,
                                  const py::object& color_k, const py::object& color_from_depth, const py::object& depth_scale,
                                  const py::object& depth_weight, const py::object& index, const py::object& time_s) {
  const FrameArrays arrays{depth, color, k, pose, color_k, color_from_depth, depth_scale, index, time_s, depth_weight};
  const auto made = std::make_shared<LentFrame>(arrays);
  return {made, &made->frame};
}

// The same images, seen from elsewhere.
std::shared_ptr<Frame> with_pose(const std::shared_ptr<Frame>& frame, const py::object& pose) {
  auto moved = std::make_shared<std::pair<std::shared_ptr<Frame>, Frame>>(frame, *frame);
  moved->second.world_from_camera = pose_from(pose, "pose");
  return {moved, &moved->second};
}

Camera make_camera(int width, int height, double fx, double fy, double cx, double cy) { return {width, height, fx, fy, cx, cy}; }

}  // namespace

LentFrame::LentFrame(const FrameArrays& arrays) {
  require(arrays.depth, "depth");
  require(arrays.color, "color");
  require(arrays.k, "K");
  require(arrays.pose, "pose");
  frame.index = whole_from(arrays.index, "index").value_or(0);
  frame.time_s = number_from(arrays.time_s, "time_s").value_or(0);
  if (!std::isfinite(frame.time_s)) throw Error("time_s is not finite");
  frame.world_from_camera = pose_from(arrays.pose, "pose");
  if (!arrays.color_from_depth.is_none()) frame.color_from_depth = pose_from(arrays.color_from_depth, "color_from_depth");
  frame.depth = depth_image(arrays.depth, number_from(arrays.depth_scale, "depth_scale"), lent);
  if (!arrays.depth_weight.is_none()) frame.depth_weight = weight_image(arrays.depth_weight, lent);
  frame.color = color_image(arrays.color, lent);
  frame.depth_camera = camera_from(arrays.k, "K", frame.depth.width(), frame.depth.height());
  frame.color_camera = color_camera(arrays, frame.depth_camera, frame.color);
}

void bind_frames(py::module_& m) {
  py::class_<Camera>(m, "Camera", R"(A pinhole camera without distortion. Pixels; pixel centres lie at whole numbers:
u = fx * X / Z + cx, v = fy * Y / Z + cy, with x to the right, y down and z forward.)")
      .def(py::init(&make_camera), py::arg("width"), py::arg("height"), py::arg("fx"), py::arg("fy"), py::arg("cx"),
           py::arg("cy"))
      .def_readonly("width", &Camera::width)
      .def_readonly("height", &Camera::height)
      .def_readonly("fx", &Camera::fx)
      .def_readonly("fy", &Camera::fy)
      .def_readonly("cx", &Camera::cx)
      .def_readonly("cy", &Camera::cy)
      .def_property_readonly(
          "K", [](const Camera& c) { return matrix_of(c); }, "(3, 3) float64, pixels.")
      .def(
          "__eq__", [](const Camera& a, const Camera& b) { return a == b; }, py::is_operator())
      .def("__repr__", [](const Camera& c) {
        return fmt::format("Camera({}, {}, fx={}, fy={}, cx={}, cy={})", c.width, c.height, c.fx, c.fy, c.cx, c.cy);
      });

  py::class_<Frame, std::shared_ptr<Frame>>(m, "Frame", R"(One posed RGB-D frame.

depth: (H, W) float32, metres along the viewing direction, 0 = no reading; or uint16 with depth_scale, raw / depth_scale = metres.
color: (h, w, 3) uint8, red first. K: (3, 3) or a Camera, pixels. pose: (4, 4) world_from_camera, metres, camera axes x right,
y down, z forward. color_K and color_from_depth: of a colour camera that is not the depth camera. depth_weight: (H, W) float32 in (0, 1],
what each reading counts beside others of its depth. The frame reads the arrays' memory where it lies: leave them as they are while you use
it.)")
      .def(py::init(&make_frame), py::kw_only(), py::arg("depth"), py::arg("color"), py::arg("K"), py::arg("pose"),
           py::arg("color_K") = py::none(), py::arg("color_from_depth") = py::none(), py::arg("depth_scale") = py::none(),
           py::arg("depth_weight") = py::none(), py::arg("index") = 0, py::arg("time_s") = 0.0)
      .def("with_pose", &with_pose, py::arg("pose"), "The same images and cameras with another pose, (4, 4) world_from_camera.")
      .def_readonly("index", &Frame::index)
      .def_readonly("time_s", &Frame::time_s)
      .def_readonly("depth_camera", &Frame::depth_camera)
      .def_readonly("color_camera", &Frame::color_camera)
      .def_property_readonly(
          "depth", [](const py::object& self) { return image_view<float>(self.cast<const Frame&>().depth, self); },
          "(H, W) float32, metres, 0 = no reading; a view.")
      .def_property_readonly(
          "depth_weight",
          [](const py::object& self) {
            const ImageView<float>& weight = self.cast<const Frame&>().depth_weight;
            return weight.empty() ? py::object(py::none()) : py::object(image_view(weight, self));
          },
          "(H, W) float32 in (0, 1]: what each reading counts; a view. None: all count 1.")
      .def_property_readonly(
          "color", [](const py::object& self) { return image_view(self.cast<const Frame&>().color, self); },
          "(h, w, 3) uint8, red first; a view.")
      .def_property_readonly(
          "pose", [](const Frame& f) { return matrix_of(f.world_from_camera); },
          "(4, 4) float64, world_from_camera of the depth camera, metres.")
      .def_property_readonly(
          "color_from_depth", [](const Frame& f) { return matrix_of(f.color_from_depth); }, "(4, 4) float64, metres.")
      .def("__repr__", [](const Frame& f) {
        return fmt::format("<Frame {} at {:.3f} s, depth {}x{}, colour {}x{}>", f.index, f.time_s, f.depth.width(),
                           f.depth.height(), f.color.width(), f.color.height());
      });
}

}  // namespace panoptic::python
