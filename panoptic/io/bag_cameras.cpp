// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/bag_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "panoptic/bags/messages.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr double kMillimetres = 1000;
constexpr std::uint32_t kMostSide_px = 1 << 16;

struct TopicCamera {
  Camera camera;
  Distortion distortion;
};

CameraInfoMessage info_in(const Bag& bag, const BagMessage& message) {
  const BagTopic& topic = bag.topics()[message.topic];
  try {
    return decode_camera_info(bag.read(message), topic.serialization);
  } catch (const MessageError& e) {
    throw Error(fmt::format("{}: the CameraInfo of {} cannot be read: {}; give the intrinsics with --calibration FILE.toml",
                            bag.name(), topic.name, e.what()));
  }
}

// The first message of a topic. Throws Error if the last one says something else.
CameraInfoMessage info_of(const Bag& bag, std::uint32_t topic) {
  const BagMessage* first = nullptr;
  const BagMessage* last = nullptr;
  for (const BagMessage& message : bag.messages()) {
    if (message.topic != topic) continue;
    if (first == nullptr) first = &message;
    last = &message;
  }
  CameraInfoMessage info = info_in(bag, *first);  // it has one: its role was told by it
  const CameraInfoMessage other = info_in(bag, *last);
  if (info.k == other.k && info.d == other.d && info.width == other.width && info.height == other.height && info.p == other.p)
    return info;
  throw Error(fmt::format("{}: the camera of {} changes in the course of the bag, which cannot be mapped; cut the bag",
                          bag.name(), bag.topics()[topic].name));
}

void require_whole_images(const CameraInfoMessage& info, const std::string& source) {
  const RegionOfInterest& r = info.region;
  const bool is_cut = !(r == RegionOfInterest{}) && !(r == RegionOfInterest{0, 0, info.width, info.height});
  if (!is_cut && info.binning_x <= 1 && info.binning_y <= 1) return;
  throw Error(
      fmt::format("{}: the images are cut or binned (roi, binning), which is not read; give their intrinsics with --calibration "
                  "FILE.toml and another CameraInfo with --topics info=TOPIC",
                  source));
}

TopicCamera camera_of(const Bag& bag, std::uint32_t info_topic, const std::string& images) {
  const std::string source = fmt::format("{}: {}", bag.name(), bag.topics()[info_topic].name);
  const CameraInfoMessage info = info_of(bag, info_topic);
  require_whole_images(info, source);
  const bool is_plain = is_rectified(images) && info.p[0] > 0;
  const auto at = [&](std::size_t k, std::size_t p) { return is_plain ? info.p[p] : info.k[k]; };
  TopicCamera result;
  const bool has_size = info.width > 0 && info.height > 0 && info.width <= kMostSide_px && info.height <= kMostSide_px;
  result.camera = {has_size ? static_cast<int>(info.width) : 0,
                   has_size ? static_cast<int>(info.height) : 0,
                   at(0, 0),
                   at(4, 5),
                   at(2, 2),
                   at(5, 6)};
  const Camera& c = result.camera;
  if (!(c.fx > 0 && c.fy > 0 && std::isfinite(c.fx) && std::isfinite(c.fy) && std::isfinite(c.cx) && std::isfinite(c.cy))) {
    throw Error(
        fmt::format("{}: no focal length (fx {}, fy {}): the camera was not calibrated; give the intrinsics with --calibration "
                    "FILE.toml and leave the topic out of the bag",
                    source, c.fx, c.fy));
  }
  const bool is_straight = is_rectified(images) || std::all_of(info.d.begin(), info.d.end(), [](double d) { return d == 0; });
  if (!is_straight) result.distortion = to_distortion(info.distortion_model, info.d, source + ": ");
  return result;
}

// The recorder of Intel's SDK states the unit of depth in metres in a topic of its own.
std::optional<double> realsense_unit_m(const Bag& bag, const std::string& depth) {
  const std::size_t sensor_end = depth.find('/', depth.find("/sensor_") + 1);
  const std::string name = depth.substr(0, sensor_end) + "/option/Depth_Units/value";
  for (const BagMessage& message : bag.messages()) {
    const BagTopic& topic = bag.topics()[message.topic];
    if (topic.name != name) continue;
    try {
      const float unit_m = decode_float(bag.read(message), topic.serialization);
      if (unit_m > 0 && std::isfinite(unit_m)) return unit_m;
    } catch (const MessageError& e) {
      throw Error(fmt::format("{}: {}: {}", bag.name(), topic.name, e.what()));
    }
  }
  return std::nullopt;
}

bool is_float(const RoledTopic& depth) { return depth.note.starts_with("32FC1"); }

// Where the colour camera is. Throws Error if the frames differ and nothing connects them.
void place_color(const Bag& bag, const RoledTopic& depth, const RoledTopic& color, const TransformTree& tree,
                 Calibration& calibration) {
  const std::string& name = bag.topics()[color.topic].name;
  if (is_realsense_topic(name) && name.find("Color") != std::string::npos) {
    throw Error(
        fmt::format("{}: in a recording of Intel's tools depth and colour are of two cameras, and how they lie is not read; give "
                    "[color_from_depth] with --calibration FILE.toml, or record aligned depth",
                    bag.name()));
  }
  if (depth.frame == color.frame) return;
  const auto fixed = tree.fixed(color.frame, depth.frame);
  if (!fixed) {
    throw Error(
        fmt::format("{}: depth images are of the frame '{}', colour images of '{}', and no fixed transform connects them; record "
                    "/tf_static, or give [color_from_depth] with --calibration FILE.toml",
                    bag.name(), depth.frame, color.frame));
  }
  calibration.color_from_depth = rigid(*fixed);
}

}  // namespace

Calibration calibration_of(const Bag& bag, const std::vector<RoledTopic>& roles, const BagRoles& chosen,
                           const TransformTree& tree, bool is_given, std::vector<std::string>& assumed) {
  const RoledTopic& depth = roles[chosen.depth];
  const RoledTopic& color = roles[chosen.color];
  const std::string& depth_name = bag.topics()[depth.topic].name;
  Calibration calibration;
  calibration.depth_scale = is_float(depth) ? 1 : kMillimetres;
  if (is_realsense_topic(depth_name)) {
    if (const auto unit_m = realsense_unit_m(bag, depth_name)) calibration.depth_scale = std::round(1e6 / *unit_m) / 1e6;
  }
  if (chosen.depth_info) {
    const TopicCamera camera = camera_of(bag, *chosen.depth_info, depth_name);
    calibration.depth = camera.camera;
    calibration.depth_distortion = camera.distortion;
  } else if (!is_given) {
    const std::string infos = names_of(bag, roles, {BagRole::kInfo});
    throw Error(fmt::format("{}: no CameraInfo beside the depth images {}; {}--calibration FILE.toml gives the intrinsics",
                            bag.name(), depth_name,
                            infos.empty() ? "" : fmt::format("choose with --topics info=TOPIC: {}; or ", infos)));
  }
  if (chosen.color_info) {
    const TopicCamera camera = camera_of(bag, *chosen.color_info, bag.topics()[color.topic].name);
    calibration.color = camera.camera;
    calibration.color_distortion = camera.distortion;
  } else if (depth.frame == color.frame) {
    calibration.color_is_assumed = true;
  } else if (!is_given) {
    throw Error(fmt::format(
        "{}: no CameraInfo beside the colour images {}, which are of another frame than depth; --calibration FILE.toml "
        "gives [color] and [color_from_depth]",
        bag.name(), bag.topics()[color.topic].name));
  }
  try {
    place_color(bag, depth, color, tree, calibration);
  } catch (const Error& e) {
    if (!is_given) throw;
    assumed.push_back(fmt::format("{} (taken from the calibration file)", e.what()));
  }
  return calibration;
}

}  // namespace panoptic
