// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/scan_ply.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/ply_header.h"

namespace panoptic {
namespace {

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{4} << 30;
constexpr std::size_t kMaxVertices = std::numeric_limits<std::int32_t>::max();
constexpr std::uint8_t kCorners = 3;
constexpr std::uint8_t kOpaque = 255;

struct VertexLayout {
  std::array<const PlyProperty*, 3> position{};
  std::array<const PlyProperty*, 3> color{};  // nullptr: none
};

class ScanPlyReader {
 public:
  ScanPlyReader(std::string name, std::string_view bytes, ScanTruth& scan)
      : name_(std::move(name)), bytes_(bytes), header_(parse_ply_header(bytes, name_)), scan_(scan), at_(header_.bytes) {}

  void read() {
    scan_.positions.clear();
    scan_.colors.clear();
    scan_.triangles.clear();
    bool has_vertices = false;
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex" && !has_vertices) {
        read_vertices(element);
        has_vertices = true;
      } else if (element.name == "face" && has_vertices) {
        read_faces(element);
      } else {
        skip(element);
      }
    }
    if (!has_vertices) fail("the PLY has no vertices");
    if (at_ != bytes_.size()) fail(fmt::format("{} bytes follow what the PLY header announces", bytes_.size() - at_));
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw Error(fmt::format("{}: {}", name_, what)); }

  const char* take(std::size_t count) {
    if (count > bytes_.size() - at_) fail(fmt::format("the PLY is cut off at byte {}", at_));
    const char* here = bytes_.data() + at_;
    at_ += count;
    return here;
  }

  VertexLayout layout_of(const PlyElement& element) const {
    constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
    constexpr std::array<std::string_view, 3> kChannels = {"red", "green", "blue"};
    if (element.has_list()) fail("the PLY's vertices hold lists");
    if (element.count > kMaxVertices) fail(fmt::format("{} vertices, more than faces can name", element.count));
    VertexLayout layout;
    for (std::size_t i = 0; i < 3; ++i) {
      layout.position[i] = element.find(kAxes[i]);
      layout.color[i] = element.find(kChannels[i]);
      if (layout.position[i] == nullptr) fail(fmt::format("the PLY's vertices have no '{}'", kAxes[i]));
      if (layout.color[i] != nullptr && layout.color[i]->type != PlyType::kUint8) layout.color[i] = nullptr;
    }
    return layout;
  }

  void read_vertices(const PlyElement& element) {
    const VertexLayout layout = layout_of(element);
    scan_.positions.resize(element.count);
    scan_.colors.resize(element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      const char* record = take(element.record_bytes);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const PlyProperty& p = *layout.position[axis];
        scan_.positions[i][static_cast<Eigen::Index>(axis)] = static_cast<float>(ply_number(p.type, record + p.offset));
      }
      if (!scan_.positions[i].allFinite()) fail(fmt::format("vertex {} is not finite", i));
      Rgb& color = scan_.colors[i];
      const std::array<std::uint8_t*, 3> channels = {&color.r, &color.g, &color.b};
      for (std::size_t c = 0; c < 3; ++c) {
        if (layout.color[c] != nullptr) std::memcpy(channels[c], record + layout.color[c]->offset, 1);
      }
    }
  }

  void read_faces(const PlyElement& element) {
    scan_.triangles.reserve(scan_.triangles.size() + element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      bool has_corners = false;
      for (const PlyProperty& p : element.properties) {
        if (p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index")) {
          scan_.triangles.push_back(corners(p, i));
          has_corners = true;
        } else {
          skip(p);
        }
      }
      if (!has_corners) fail("the PLY's faces have no vertex_indices");
    }
  }

  std::array<std::uint32_t, 3> corners(const PlyProperty& list, std::size_t face) {
    const double count = ply_number(list.count_type, take(bytes_of(list.count_type)));
    if (count != kCorners) fail(fmt::format("face {} has {} corners, not 3", face, count));
    std::array<std::uint32_t, 3> triangle{};
    for (std::uint32_t& corner : triangle) {
      const double index = ply_number(list.type, take(bytes_of(list.type)));
      const bool usable = index >= 0 && index < static_cast<double>(scan_.positions.size()) && index == std::floor(index);
      if (!usable) fail(fmt::format("face {} names vertex {} of {}", face, index, scan_.positions.size()));
      corner = static_cast<std::uint32_t>(index);
    }
    return triangle;
  }

  void skip(const PlyProperty& p) {
    if (!p.is_list) {
      take(bytes_of(p.type));
      return;
    }
    const double count = ply_number(p.count_type, take(bytes_of(p.count_type)));
    if (count < 0) fail(fmt::format("a list of {} numbers ends at byte {}", count, at_));
    take(static_cast<std::size_t>(count) * bytes_of(p.type));
  }

  void skip(const PlyElement& element) {
    if (!element.has_list()) {
      take(element.count * element.record_bytes);
      return;
    }
    for (std::size_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& p : element.properties) skip(p);
    }
  }

  std::string name_;
  std::string_view bytes_;
  PlyHeader header_;
  ScanTruth& scan_;
  std::size_t at_ = 0;
};

template <typename T>
char* put(char* out, T value) {
  std::memcpy(out, &value, sizeof(T));
  return out + sizeof(T);
}

}  // namespace

void write_scan_ply(const std::filesystem::path& path, const ScanTruth& scan) {
  constexpr std::size_t kVertexBytes = 3 * sizeof(float) + 4;
  constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(std::int32_t);
  if (scan.positions.size() > kMaxVertices) {
    throw Error(fmt::format("cannot write {}: {} vertices, more than PLY faces can name", path.string(), scan.positions.size()));
  }
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nelement face {}\n"
      "property list uchar int vertex_indices\nend_header\n",
      scan.positions.size(), scan.triangles.size());
  const std::size_t header_bytes = bytes.size();
  bytes.resize(header_bytes + scan.positions.size() * kVertexBytes + scan.triangles.size() * kFaceBytes);
  char* out = bytes.data() + header_bytes;
  for (std::size_t i = 0; i < scan.positions.size(); ++i) {
    const Rgb color = scan.colors.empty() ? Rgb{} : scan.colors[i];
    for (int axis = 0; axis < 3; ++axis) out = put(out, scan.positions[i][axis]);
    for (const std::uint8_t channel : {color.r, color.g, color.b, kOpaque}) out = put(out, channel);
  }
  for (const std::array<std::uint32_t, 3>& triangle : scan.triangles) {
    out = put(out, kCorners);
    for (const std::uint32_t index : triangle) out = put(out, index);
  }
  write_file(path, bytes);
}

void read_scan_ply(const std::filesystem::path& path, ScanTruth& scan) {
  const std::string bytes = read_file(path, kMaxFileBytes);
  ScanPlyReader(path.string(), bytes, scan).read();
}

}  // namespace panoptic
