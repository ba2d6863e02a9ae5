// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/image_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "panoptic/base/error.h"
#include "panoptic/base/files.h"
#include "panoptic/base/image_header.h"

namespace panoptic {
namespace {

constexpr std::uintmax_t kMaxFileBytes = 256U << 20;
constexpr std::size_t kMaxPixels = 64U << 20;

cv::Mat decode(std::span<const std::uint8_t> bytes, std::string_view name, int flags) {
  cv::Mat decoded;
  try {
    if (bytes.size() <= kMaxFileBytes && is_acceptable_image(bytes, kMaxPixels)) {
      decoded = cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<std::uint8_t*>(bytes.data())), flags);
    }
  } catch (const cv::Exception&) {
    decoded.release();  // a hostile header: the same to the user as any other unreadable image
  }
  if (decoded.empty() || decoded.total() > kMaxPixels) {
    throw Error(fmt::format("{}: not a readable image of at most {} pixels; it may be cut off", name, kMaxPixels));
  }
  return decoded;
}

template <typename T>
Image<T> to_image(const cv::Mat& mat) {
  Image<T> image(mat.cols, mat.rows);
  for (int v = 0; v < mat.rows; ++v) std::copy_n(mat.ptr<T>(v), mat.cols, image.row(v));
  return image;
}

std::span<const std::uint8_t> as_bytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

void write_mat(const std::filesystem::path& path, const cv::Mat& mat) {
  std::vector<std::uint8_t> bytes;
  if (mat.empty() || !cv::imencode(".png", mat, bytes))
    throw Error(fmt::format("{}: the image cannot be encoded as PNG", path.string()));
  write_file(path, bytes);
}

cv::Mat to_bgr(const Image<Rgb>& image) {
  cv::Mat bgr(image.height(), image.width(), CV_8UC3);
  for (int v = 0; v < image.height(); ++v) {
    std::uint8_t* out = bgr.ptr(v);
    for (int u = 0; u < image.width(); ++u) {
      const Rgb c = image(u, v);
      out[3 * u] = c.b;
      out[3 * u + 1] = c.g;
      out[3 * u + 2] = c.r;
    }
  }
  return bgr;
}

std::vector<std::uint8_t> encode(const char* suffix, const cv::Mat& mat, const std::vector<int>& parameters = {}) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(suffix, mat, bytes, parameters)) throw Error(fmt::format("an image cannot be encoded as {}", suffix));
  return bytes;
}

}  // namespace

Image<Rgb> decode_rgb(std::span<const std::uint8_t> bytes, std::string_view name) {
  const cv::Mat bgr = decode(bytes, name, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  Image<Rgb> image(bgr.cols, bgr.rows);
  for (int v = 0; v < bgr.rows; ++v) {
    const std::uint8_t* in = bgr.ptr(v);
    Rgb* out = image.row(v);
    for (int u = 0; u < bgr.cols; ++u) out[u] = {in[3 * u + 2], in[3 * u + 1], in[3 * u]};
  }
  return image;
}

Image<std::uint16_t> decode_gray16(std::span<const std::uint8_t> bytes, std::string_view name) {
  cv::Mat mat = decode(bytes, name, cv::IMREAD_UNCHANGED);
  if (mat.channels() != 1 || (mat.depth() != CV_16U && mat.depth() != CV_8U)) {
    throw Error(fmt::format("{}: expected one channel of 16 or 8 bits, found {} channels", name, mat.channels()));
  }
  if (mat.depth() == CV_8U) mat.convertTo(mat, CV_16U);
  return to_image<std::uint16_t>(mat);
}

Image<Rgb> read_rgb(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kMaxFileBytes);
  return decode_rgb(as_bytes(bytes), path.string());
}

Image<std::uint16_t> read_gray16(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kMaxFileBytes);
  return decode_gray16(as_bytes(bytes), path.string());
}

Image<float> read_gray_float(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kMaxFileBytes);
  const cv::Mat mat = decode(as_bytes(bytes), path.string(), cv::IMREAD_UNCHANGED);
  if (mat.type() != CV_32FC1) throw Error(fmt::format("{}: expected one channel of 32-bit floats", path.string()));
  return to_image<float>(mat);
}

std::vector<std::uint8_t> encode_jpeg(const Image<Rgb>& image, int quality) {
  return encode(".jpg", to_bgr(image), {cv::IMWRITE_JPEG_QUALITY, quality});
}

std::vector<std::uint8_t> encode_png(const Image<std::uint8_t>& image) {
  return encode(".png", cv::Mat(image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())));
}

std::vector<std::uint8_t> encode_png(const Image<std::uint16_t>& image) {
  return encode(".png", cv::Mat(image.height(), image.width(), CV_16UC1, const_cast<std::uint16_t*>(image.data())));
}

std::vector<std::uint8_t> encode_png(const Image<Rgb>& color, const Image<std::uint8_t>& alpha) {
  PANOPTIC_ASSERT(alpha.same_size(color.width(), color.height()));
  cv::Mat bgra(color.height(), color.width(), CV_8UC4);
  for (int v = 0; v < color.height(); ++v) {
    auto* out = bgra.ptr<cv::Vec4b>(v);
    for (int u = 0; u < color.width(); ++u) {
      const Rgb c = color(u, v);
      out[u] = {c.b, c.g, c.r, alpha(u, v)};
    }
  }
  return encode(".png", bgra);
}

void write_png(const std::filesystem::path& path, const Image<Rgb>& image) { write_mat(path, to_bgr(image)); }

void write_png(const std::filesystem::path& path, const Image<std::uint16_t>& image) {
  write_mat(path, cv::Mat(image.height(), image.width(), CV_16UC1, const_cast<std::uint16_t*>(image.data())));
}

}  // namespace panoptic
