// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/io/recordings.h"
#include "tests/fresh_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <fstream>
#include <limits>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"

namespace panoptic::test {
namespace fs = std::filesystem;

Image<std::uint16_t> raw_depth(int i, ImageSize size) {
  Image<std::uint16_t> image(size.width, size.height);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) image(u, v) = static_cast<std::uint16_t>(1000 + 100 * i + 7 * u + 11 * v);
  }
  image(0, 0) = 0;
  image(1, 0) = 65535;
  return image;
}

Image<Rgb> color_image(int i, ImageSize size) {
  Image<Rgb> image(size.width, size.height);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      image(u, v) = {static_cast<std::uint8_t>(40 + 2 * u), static_cast<std::uint8_t>(60 + 2 * v),
                     static_cast<std::uint8_t>(90 + 10 * i)};
    }
  }
  return image;
}

Eigen::Matrix4d pose_matrix(int i) {
  Pose pose = Pose::Identity();
  pose.linear() = (Eigen::AngleAxisd(0.1 * i, Vec3d::UnitY()) * Eigen::AngleAxisd(0.3, Vec3d::UnitX())).toRotationMatrix();
  pose.translation() = Vec3d(0.5 + 0.25 * i, -1.5, 2.0 + i);
  return pose.matrix();
}

Camera depth_camera() { return {kDepthSize.width, kDepthSize.height, 30, 31, 15.5, 11.5}; }
Camera color_camera() { return {kColorSize.width, kColorSize.height, 44, 45, 23.5, 17.5}; }

std::string matrix_text(const Eigen::Matrix4d& matrix, const char* row_end) {
  std::string text;
  for (int row = 0; row < 4; ++row) {
    text += fmt::format("{:.9f} {:.9f} {:.9f} {:.9f}{}", matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3), row_end);
  }
  return text;
}

std::string intrinsic_text(const Camera& camera) {
  return fmt::format("{} 0 {}\n0 {} {}\n0 0 1\n", camera.fx, camera.cx, camera.fy, camera.cy);
}

namespace {

Eigen::Matrix4d intrinsic_matrix(const Camera& camera) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 0) = camera.fx;
  matrix(1, 1) = camera.fy;
  matrix(0, 2) = camera.cx;
  matrix(1, 2) = camera.cy;
  return matrix;
}

}  // namespace

void write_text(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

void write_depth(const fs::path& path, const Image<std::uint16_t>& image) {
  fs::create_directories(path.parent_path());
  if (path.extension() == ".png") return write_png(path, image);
  std::string bytes = fmt::format("P5\n# written by a test\n{} {}\n65535\n", image.width(), image.height());
  for (const std::uint16_t value : image.pixels()) {
    bytes += static_cast<char>(value >> 8);
    bytes += static_cast<char>(value & 255);
  }
  write_text(path, bytes);
}

void write_color(const fs::path& path, const Image<Rgb>& image) {
  fs::create_directories(path.parent_path());
  if (path.extension() == ".png") return write_png(path, image);
  write_file(path, encode_jpeg(image, 98));
}

void expect_frame(const ReadResult& result, int i, double depth_scale, int color_tolerance, ImageSize color) {
  ASSERT_TRUE(result.frame) << result.skipped.reason;
  const Frame& frame = *result.frame;
  EXPECT_EQ(check(frame).reason, "");
  EXPECT_LT((frame.world_from_camera.matrix() - pose_matrix(i)).cwiseAbs().maxCoeff(), 1e-5);
  const Image<std::uint16_t> raw = raw_depth(i);
  ASSERT_TRUE(frame.depth.same_size(raw.width(), raw.height()));
  EXPECT_EQ(frame.depth(0, 0), 0);
  EXPECT_EQ(frame.depth(1, 0), 0);
  for (std::size_t k = 2; k < raw.size(); ++k) ASSERT_FLOAT_EQ(frame.depth[k], static_cast<float>(raw[k] / depth_scale)) << k;
  const Image<Rgb> expected = color_image(i, color);
  ASSERT_TRUE(frame.color.same_size(color.width, color.height));
  for (std::size_t k = 0; k < expected.size(); ++k) {
    ASSERT_NEAR(frame.color[k].r, expected[k].r, color_tolerance) << k;
    ASSERT_NEAR(frame.color[k].g, expected[k].g, color_tolerance) << k;
    ASSERT_NEAR(frame.color[k].b, expected[k].b, color_tolerance) << k;
  }
}

std::string error_of(const std::filesystem::path& path, const std::filesystem::path& calibration) {
  try {
    open_recording(path, calibration);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

void write_scannet_export(const fs::path& root, const ScannetLayout& layout) {
  const fs::path base = root / layout.folder;
  for (int i = 0; i < kFrameCount; ++i) {
    const std::string number = std::to_string(layout.numbers.at(static_cast<std::size_t>(i)));
    write_color(base / "color" / (number + ".jpg"), color_image(i));
    write_depth(base / "depth" / (number + ".png"), raw_depth(i));
    write_text(base / layout.poses / (number + ".txt"), matrix_text(pose_matrix(i)));
  }
  if (layout.one_intrinsic) return write_text(base / "intrinsic.txt", matrix_text(intrinsic_matrix(depth_camera())));
  write_text(base / "intrinsic" / "intrinsic_depth.txt", matrix_text(intrinsic_matrix(depth_camera())));
  write_text(base / "intrinsic" / "intrinsic_color.txt", matrix_text(intrinsic_matrix(color_camera())));
  write_text(base / "intrinsic" / "extrinsic_depth.txt", matrix_text(Eigen::Matrix4d::Identity()));
  write_text(base / "intrinsic" / "extrinsic_color.txt", matrix_text(Eigen::Matrix4d::Identity()));
}

void write_scannet_cpp_export(const fs::path& root) {
  for (int i = 0; i < kFrameCount; ++i) {
    const std::string stem = fmt::format("frame-{:06}", i);
    write_color(root / (stem + ".color.jpg"), color_image(i));
    write_depth(root / (stem + ".depth.pgm"), raw_depth(i));
    write_text(root / (stem + ".pose.txt"), matrix_text(pose_matrix(i)));
  }
  std::string info = "m_versionNumber = 4\nm_sensorName = a sensor\n";
  info += fmt::format("m_colorWidth = {}\nm_colorHeight = {}\n", kColorSize.width, kColorSize.height);
  info += fmt::format("m_depthWidth = {}\nm_depthHeight = {}\nm_depthShift = 1000\n", kDepthSize.width, kDepthSize.height);
  const std::string identity = matrix_text(Eigen::Matrix4d::Identity(), " ");
  info += "m_calibrationColorIntrinsic = " + matrix_text(intrinsic_matrix(color_camera()), " ") + "\n";
  info += "m_calibrationColorExtrinsic = " + identity + "\n";
  info += "m_calibrationDepthIntrinsic = " + matrix_text(intrinsic_matrix(depth_camera()), " ") + "\n";
  info += "m_calibrationDepthExtrinsic = " + identity + "\nm_frames.size = 4\n";
  write_text(root / "_info.txt", info);
}

void write_seven_scenes(const fs::path& folder, const std::string& color_suffix) {
  for (int i = 0; i < kFrameCount; ++i) {
    const std::string stem = fmt::format("frame-{:06}", i);
    write_color(folder / fmt::format("{}.color{}", stem, color_suffix), color_image(i));
    write_depth(folder / (stem + ".depth.png"), raw_depth(i));
    write_text(folder / (stem + ".pose.txt"), matrix_text(pose_matrix(i), "\t\n"));
  }
}

namespace {

std::string tum_pose(double time_s, const Eigen::Matrix4d& pose) {
  const Eigen::Quaterniond q(Eigen::Matrix3d(pose.topLeftCorner<3, 3>()));
  return fmt::format("{:.4f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", time_s, pose(0, 3), pose(1, 3), pose(2, 3),
                     q.x(), q.y(), q.z(), q.w());
}

}  // namespace

void write_tum(const fs::path& root) {
  std::string rgb = "# color images\n# timestamp filename\n";
  std::string depth = "# depth maps\n";
  std::string poses = "# ground truth\n";
  for (int i = 0; i < kFrameCount; ++i) {
    const double time_s = 1000 + i;
    const std::string name = fmt::format("{:.4f}.png", time_s);
    write_color(root / "rgb" / name, color_image(i));
    write_depth(root / "depth" / name, raw_depth(i));
    rgb += fmt::format("{:.4f} rgb/{}\n", time_s + 0.012, name);
    depth += fmt::format("{:.4f} depth/{}\n", time_s, name);
    poses += tum_pose(time_s, pose_matrix(i));
  }
  write_text(root / "rgb.txt", rgb);
  write_text(root / "depth.txt", depth);
  write_text(root / "groundtruth.txt", poses);
}

void write_icl(const fs::path& root) {
  const Eigen::Matrix4d flip = Eigen::Vector4d(1, -1, 1, 1).asDiagonal();
  std::string associations;
  std::string poses;
  for (int i = 0; i < kFrameCount; ++i) {
    write_color(root / "rgb" / fmt::format("{}.png", i), color_image(i));
    write_depth(root / "depth" / fmt::format("{}.png", i), raw_depth(i));
    associations += fmt::format("{0} depth/{0}.png {0} rgb/{0}.png\n", i);
    if (i > 0) poses += tum_pose(i, flip * pose_matrix(i) * flip);  // the first frame has no pose
  }
  write_text(root / "associations.txt", associations);
  write_text(root / "livingRoom0.gt.freiburg", poses);
}

void write_replica(const fs::path& root) {
  std::string trajectory;
  for (int i = 0; i < kFrameCount; ++i) {
    write_color(root / "results" / fmt::format("frame{:06}.jpg", i), color_image(i));
    write_depth(root / "results" / fmt::format("depth{:06}.png", i), raw_depth(i));
    trajectory += matrix_text(pose_matrix(i), " ") + "\n";
  }
  write_text(root / "traj.txt", trajectory);
}

void write_plain_folder(const fs::path& root) {
  std::string poses;
  for (int i = 0; i < kFrameCount; ++i) {
    const std::string name = fmt::format("{:05}.png", 3 + i * i);
    write_color(root / "images" / name, color_image(i));
    write_depth(root / "depth" / name, raw_depth(i));
    poses += matrix_text(pose_matrix(i), " ") + "\n";
  }
  write_text(root / "poses.txt", poses);
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
}

std::string zlib(const std::string& bytes) {
  std::string out(::compressBound(bytes.size()), '\0');
  uLongf size = out.size();
  ::compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  out.resize(size);
  return out;
}

namespace {

template <typename T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

void append_matrix(std::string& bytes, const Eigen::Matrix4d& matrix) {
  for (int i = 0; i < 16; ++i) append(bytes, static_cast<float>(matrix(i / 4, i % 4)));
}

std::string color_blob(int i, std::int32_t compression) {
  const Image<Rgb> image = color_image(i);
  if (compression == 0) return {reinterpret_cast<const char*>(image.data()), image.size() * sizeof(Rgb)};
  const fs::path path = fresh_folder("blob") / (compression == 1 ? "color.png" : "color.jpg");
  write_color(path, image);
  return read_file(path);
}

std::string depth_blob(int i, const SensFields& fields) {
  const Image<std::uint16_t> image = raw_depth(i, fields.depth);
  const std::string raw(reinterpret_cast<const char*>(image.data()), image.size() * sizeof(std::uint16_t));
  return fields.depth_compression == 0 ? raw : zlib(raw);
}

}  // namespace

std::string sens_bytes(const SensFields& fields) {
  std::string bytes;
  append(bytes, fields.version);
  append(bytes, fields.name_bytes);
  bytes += "StructureIo";
  append_matrix(bytes, intrinsic_matrix(color_camera()));
  append_matrix(bytes, Eigen::Matrix4d::Identity());
  append_matrix(bytes, intrinsic_matrix(depth_camera()));
  append_matrix(bytes, fields.depth_extrinsic);
  append(bytes, fields.color_compression);
  append(bytes, fields.depth_compression);
  for (const int side : {kColorSize.width, kColorSize.height, fields.depth.width, fields.depth.height}) {
    append(bytes, static_cast<std::uint32_t>(side));
  }
  append(bytes, fields.depth_shift);
  append(bytes, fields.frames);
  for (int i = 0; i < kFrameCount; ++i) {
    const bool odd = i == fields.odd_frame;
    const std::string color = color_blob(i, fields.color_compression);
    const std::string depth = odd && fields.odd_bytes == 0 ? fields.odd_blob : depth_blob(i, fields);
    const Eigen::Matrix4d lost = Eigen::Matrix4d::Constant(-std::numeric_limits<double>::infinity());
    append_matrix(bytes, i == fields.lost_frame ? lost : pose_matrix(i));
    append(bytes, std::uint64_t{100000} * static_cast<std::uint64_t>(i) + 100);
    append(bytes, std::uint64_t{100000} * static_cast<std::uint64_t>(i) + 200);
    append(bytes, static_cast<std::uint64_t>(color.size()));
    append(bytes, odd && fields.odd_bytes != 0 ? fields.odd_bytes : static_cast<std::uint64_t>(depth.size()));
    bytes += color + depth;
  }
  if (!fields.imu_tail) return bytes;
  append(bytes, std::uint64_t{2});
  bytes.append(2 * 128, '\0');
  return bytes;
}

}  // namespace panoptic::test
