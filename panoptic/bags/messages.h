// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The messages that recordings are made of. All throw MessageError for bytes that are no such message.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/bags/wire_reader.h"
#include "panoptic/geometry.h"

namespace panoptic {

using MessageBytes = std::span<const std::uint8_t>;

constexpr std::string_view kImageType = "sensor_msgs/Image";
constexpr std::string_view kCompressedImageType = "sensor_msgs/CompressedImage";
constexpr std::string_view kCameraInfoType = "sensor_msgs/CameraInfo";
constexpr std::string_view kOdometryType = "nav_msgs/Odometry";

// tf2_msgs/TFMessage, and tf/tfMessage of old bags.
bool is_transforms_type(std::string_view type);
// Odometry, PoseStamped, PoseWithCovarianceStamped, TransformStamped.
bool is_pose_type(std::string_view type);

struct MessageHeader {
  std::int64_t time_ns = 0;
  std::string frame;  // without a slash in front
};

// The beginning of all messages that have a header; what follows need not be there.
MessageHeader decode_header(MessageBytes bytes, std::string_view serialization);

// `data` lies in the bytes that were decoded.
struct ImageMessage {
  MessageHeader header;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::string encoding;
  bool is_big_endian = false;
  std::uint32_t row_bytes = 0;
  MessageBytes data;
};
ImageMessage decode_image(MessageBytes bytes, std::string_view serialization);
// The same without `data`, of the first bytes of a message.
ImageMessage decode_image_head(MessageBytes bytes, std::string_view serialization);

struct CompressedImageMessage {
  MessageHeader header;
  std::string format;
  MessageBytes data;
};
CompressedImageMessage decode_compressed_image(MessageBytes bytes, std::string_view serialization);
CompressedImageMessage decode_compressed_image_head(MessageBytes bytes, std::string_view serialization);

struct RegionOfInterest {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t width = 0;  // 0: all
  std::uint32_t height = 0;
  bool operator==(const RegionOfInterest&) const = default;
};

struct CameraInfoMessage {
  MessageHeader header;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};   // of the images as they were taken
  std::array<double, 12> p{};  // of the rectified images
  std::uint32_t binning_x = 0;
  std::uint32_t binning_y = 0;
  RegionOfInterest region;
};
CameraInfoMessage decode_camera_info(MessageBytes bytes, std::string_view serialization);

// The pose of the frame `child` in the frame header.frame.
struct PoseMessage {
  MessageHeader header;
  std::string child;  // empty: the message does not say
  Vec3d position = Vec3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};
std::vector<PoseMessage> decode_transforms(MessageBytes bytes, std::string_view serialization);
PoseMessage decode_pose(MessageBytes bytes, std::string_view serialization, std::string_view type);

float decode_float(MessageBytes bytes, std::string_view serialization);  // std_msgs/Float32

}  // namespace panoptic
