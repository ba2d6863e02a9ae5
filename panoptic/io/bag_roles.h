// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Which topic of a bag is what.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/bag.h"
#include "panoptic/bags/bag.h"

namespace panoptic {

enum class BagRole { kNone, kDepth, kColor, kGrey, kInfo, kPose, kTransforms };

// A topic by its type and its first message.
struct RoledTopic {
  std::uint32_t topic = 0;
  BagRole role = BagRole::kNone;
  std::string frame;  // of its first message
  std::string note;   // the encoding; or why it has no role
};

std::vector<RoledTopic> roles_of(const Bag& bag);  // one for each topic, in their order

std::string_view role_name(BagRole role);

struct BagRoles {
  std::uint32_t depth = 0;
  std::uint32_t color = 0;
  std::optional<std::uint32_t> depth_info;
  std::optional<std::uint32_t> color_info;
  std::optional<std::uint32_t> pose;  // nothing: no topic was asked for
  std::vector<std::string> assumed;
};

// Throws Error, with the topics that there are, for a role without a topic or with several. Missing CameraInfo is left to the
// caller.
BagRoles choose(const Bag& bag, const std::vector<RoledTopic>& roles, const BagChoice& choice);

// "/a (sensor_msgs/Image, 16UC1), /b ...": the topics of some roles, for messages.
std::string names_of(const Bag& bag, const std::vector<RoledTopic>& roles, const std::vector<BagRole>& wanted);

// True for a topic of Intel's own recorder, which names no frames: /device_0/sensor_1/Color_0/image/data.
bool is_realsense_topic(const std::string& name);
// The images are rectified: their camera is that of the projection matrix, and has no distortion.
bool is_rectified(const std::string& name);

}  // namespace panoptic
