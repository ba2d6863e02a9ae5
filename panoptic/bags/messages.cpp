// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/bags/messages.h"

#include <array>

namespace panoptic {
namespace {

std::string frame_name(std::string_view name) {
  while (name.starts_with('/')) name.remove_prefix(1);
  return std::string(name);
}

MessageHeader take_header(WireReader& reader) {
  if (reader.is_ros1()) reader.take<std::uint32_t>();  // the sequence number
  MessageHeader header;
  header.time_ns = reader.take_time_ns();
  header.frame = frame_name(reader.take_text());
  return header;
}

Vec3d take_vector(WireReader& reader) {
  const auto x = reader.take<double>();
  const auto y = reader.take<double>();
  return {x, y, reader.take<double>()};
}

Eigen::Quaterniond take_quaternion(WireReader& reader) {
  const Vec3d v = take_vector(reader);
  return {reader.take<double>(), v.x(), v.y(), v.z()};
}

void take_pose(WireReader& reader, PoseMessage& pose) {
  pose.position = take_vector(reader);
  pose.rotation = take_quaternion(reader);
}

PoseMessage take_stamped_transform(WireReader& reader) {
  PoseMessage pose;
  pose.header = take_header(reader);
  pose.child = frame_name(reader.take_text());
  take_pose(reader, pose);
  return pose;
}

ImageMessage take_image_head(WireReader& reader) {
  ImageMessage image;
  image.header = take_header(reader);
  image.height = reader.take<std::uint32_t>();
  image.width = reader.take<std::uint32_t>();
  image.encoding = std::string(reader.take_text());
  image.is_big_endian = reader.take<std::uint8_t>() != 0;
  image.row_bytes = reader.take<std::uint32_t>();
  return image;
}

CompressedImageMessage take_compressed_head(WireReader& reader) {
  CompressedImageMessage image;
  image.header = take_header(reader);
  image.format = std::string(reader.take_text());
  return image;
}

constexpr std::string_view kPoseType = "geometry_msgs/PoseStamped";
constexpr std::string_view kPoseWithCovarianceType = "geometry_msgs/PoseWithCovarianceStamped";
constexpr std::string_view kTransformStampedType = "geometry_msgs/TransformStamped";

}  // namespace

bool is_transforms_type(std::string_view type) { return type == "tf2_msgs/TFMessage" || type == "tf/tfMessage"; }

bool is_pose_type(std::string_view type) {
  return type == kOdometryType || type == kPoseType || type == kPoseWithCovarianceType || type == kTransformStampedType;
}

MessageHeader decode_header(MessageBytes bytes, std::string_view serialization) {
  WireReader reader(bytes, serialization);
  return take_header(reader);
}

ImageMessage decode_image_head(MessageBytes bytes, std::string_view serialization) {
  WireReader reader(bytes, serialization);
  return take_image_head(reader);
}

ImageMessage decode_image(MessageBytes bytes, std::string_view serialization) {
  WireReader reader(bytes, serialization);
  ImageMessage image = take_image_head(reader);
  image.data = reader.take_bytes();
  return image;
}

CompressedImageMessage decode_compressed_image_head(MessageBytes bytes, std::string_view serialization) {
  WireReader reader(bytes, serialization);
  return take_compressed_head(reader);
}

CompressedImageMessage decode_compressed_image(MessageBytes bytes, std::string_view serialization) {
  WireReader reader(bytes, serialization);
  CompressedImageMessage image = take_compressed_head(reader);
  image.data = reader.take_bytes();
  return image;
}

CameraInfoMessage decode_camera_info(MessageBytes bytes, std::string_view serialization) {
  constexpr std::size_t kRectificationNumbers = 9;
  WireReader reader(bytes, serialization);
  CameraInfoMessage info;
  info.header = take_header(reader);
  info.height = reader.take<std::uint32_t>();
  info.width = reader.take<std::uint32_t>();
  info.distortion_model = std::string(reader.take_text());
  info.d = reader.take_doubles();
  for (double& number : info.k) number = reader.take<double>();
  reader.skip_doubles(kRectificationNumbers);
  for (double& number : info.p) number = reader.take<double>();
  info.binning_x = reader.take<std::uint32_t>();
  info.binning_y = reader.take<std::uint32_t>();
  info.region.x = reader.take<std::uint32_t>();
  info.region.y = reader.take<std::uint32_t>();
  info.region.height = reader.take<std::uint32_t>();
  info.region.width = reader.take<std::uint32_t>();
  return info;
}

std::vector<PoseMessage> decode_transforms(MessageBytes bytes, std::string_view serialization) {
  constexpr std::size_t kLeastBytes = 8 + 4 + 4 + 7 * sizeof(double);  // stamp, two names, numbers
  WireReader reader(bytes, serialization);
  std::vector<PoseMessage> transforms(reader.take_count(kLeastBytes));
  for (PoseMessage& transform : transforms) transform = take_stamped_transform(reader);
  return transforms;
}

PoseMessage decode_pose(MessageBytes bytes, std::string_view serialization, std::string_view type) {
  WireReader reader(bytes, serialization);
  if (type == kTransformStampedType) return take_stamped_transform(reader);
  PoseMessage pose;
  pose.header = take_header(reader);
  if (type == kOdometryType) pose.child = frame_name(reader.take_text());
  take_pose(reader, pose);
  return pose;
}

float decode_float(MessageBytes bytes, std::string_view serialization) { return WireReader(bytes, serialization).take<float>(); }

}  // namespace panoptic
