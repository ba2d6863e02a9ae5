// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/outputs.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/base/piece_writer.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY numbers are copied as they lie in memory");

constexpr std::size_t kVertexBytes = 6 * sizeof(float) + 3 * sizeof(std::uint8_t) + sizeof(std::uint16_t) + sizeof(std::uint32_t);
constexpr std::size_t kShortIdVertexBytes = kVertexBytes - sizeof(std::uint16_t);
constexpr std::size_t kFaceBytes = sizeof(std::uint8_t) + 3 * sizeof(std::int32_t);
constexpr std::uint8_t kCorners = 3;
constexpr std::size_t kMaxHeaderBytes = 16U << 10;
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{16} << 30;
constexpr std::size_t kMaxVertices = std::numeric_limits<std::int32_t>::max();

constexpr std::array<std::string_view, 2> kOpening = {"ply", "format binary_little_endian 1.0"};
constexpr std::string_view kVertexElement = "element vertex ";
constexpr std::array<std::string_view, 10> kVertexProperties = {
    "property float x",  "property float y",   "property float z",     "property float nx",   "property float ny",
    "property float nz", "property uint8 red", "property uint8 green", "property uint8 blue", "property uint16 class_id"};
constexpr std::string_view kIdProperty = "property int32 panoptic_id";
constexpr std::string_view kShortIdProperty = "property uint16 panoptic_id";  // before ids had 32 bits
constexpr std::string_view kFaceElement = "element face ";
constexpr std::array<std::string_view, 2> kClosing = {"property list uchar int vertex_indices", "end_header"};

// The line with the type's name as this program writes it: PLY has two for each whole number, and earlier versions used the
// other. Neither meshio nor Open3D knows ushort, so the names with sizes are written; and Open3D leaves out what is unsigned and
// has 32 bits, so ids are written as signed, of the same bits.
std::string with_sized_type(std::string_view line) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kNames = {
      {{"property uchar ", "uint8"}, {"property ushort ", "uint16"}, {"property uint ", "int32"}}};
  for (const auto& [old, sized] : kNames) {
    if (line.starts_with(old)) return fmt::format("property {} {}", sized, line.substr(old.size()));
  }
  return std::string(line);
}

std::string header_text(const Mesh& mesh) {
  std::string text;
  for (const std::string_view line : kOpening) text += fmt::format("{}\n", line);
  text += "comment PanopticFusion: metres, world axes of the recording\n";
  text += fmt::format("{}{}\n", kVertexElement, mesh.vertices.size());
  for (const std::string_view line : kVertexProperties) text += fmt::format("{}\n", line);
  text += fmt::format("{}\n", kIdProperty);
  text += fmt::format("{}{}\n", kFaceElement, mesh.triangles.size());
  for (const std::string_view line : kClosing) text += fmt::format("{}\n", line);
  return text;
}

void put(const MeshVertex& vertex, PieceWriter& out) {
  for (int i = 0; i < 3; ++i) out.put(vertex.position[i]);
  for (int i = 0; i < 3; ++i) out.put(vertex.normal[i]);
  for (const std::uint8_t channel : {vertex.color.r, vertex.color.g, vertex.color.b}) out.put(channel);
  out.put(number(vertex.class_id));
  out.put(number(vertex.panoptic_id));
}

template <typename T>
const char* take(const char* in, T& value) {
  static_assert(std::is_arithmetic_v<T>);
  std::memcpy(&value, in, sizeof(T));
  return in + sizeof(T);
}

template <typename Id>
MeshVertex vertex_at(const char* in) {
  MeshVertex vertex;
  std::uint16_t class_id = 0;
  Id panoptic_id = 0;
  for (int i = 0; i < 3; ++i) in = take(in, vertex.position[i]);
  for (int i = 0; i < 3; ++i) in = take(in, vertex.normal[i]);
  for (std::uint8_t* channel : {&vertex.color.r, &vertex.color.g, &vertex.color.b}) in = take(in, *channel);
  in = take(in, class_id);
  take(in, panoptic_id);
  vertex.class_id = static_cast<ClassId>(class_id);
  vertex.panoptic_id = static_cast<PanopticId>(panoptic_id);
  return vertex;
}

// Walks through a file from the front; every Error names the file and the line or the byte.
class PlyReader {
 public:
  PlyReader(const std::filesystem::path& path, std::string_view bytes) : name_(path.string()), bytes_(bytes) {}

  Mesh read() {
    for (const std::string_view line : kOpening) expect(line);
    const std::size_t vertex_count = expect_count(kVertexElement);
    for (const std::string_view line : kVertexProperties) expect(line);
    expect_id();
    const std::size_t face_count = expect_count(kFaceElement);
    for (const std::string_view line : kClosing) expect(line);
    check_size(vertex_count, face_count);
    Mesh mesh;
    mesh.vertices.reserve(vertex_count);
    for (std::size_t i = 0; i < vertex_count; ++i) mesh.vertices.push_back(vertex(i));
    mesh.triangles.reserve(face_count);
    for (std::size_t i = 0; i < face_count; ++i) mesh.triangles.push_back(face(i, vertex_count));
    return mesh;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fmt::format("{}: {}; only mesh.ply files as this program writes them can be read", name_, what));
  }

  std::string_view next_line() {
    std::string_view line;
    do {
      const std::size_t end = bytes_.substr(0, kMaxHeaderBytes).find('\n', at_);
      if (end == std::string_view::npos) fail(fmt::format("the header ends after line {} without end_header", line_number_));
      line = bytes_.substr(at_, end - at_);
      at_ = end + 1;
      ++line_number_;
    } while (line.starts_with("comment"));
    return line;
  }

  void expect(std::string_view wanted) {
    if (with_sized_type(next_line()) != wanted) fail(fmt::format("line {} is not '{}'", line_number_, wanted));
  }

  void expect_id() {
    const std::string line = with_sized_type(next_line());
    if (line == kShortIdProperty) {
      vertex_bytes_ = kShortIdVertexBytes;
    } else if (line != kIdProperty) {
      fail(fmt::format("line {} is not '{}'", line_number_, kIdProperty));
    }
  }

  std::size_t expect_count(std::string_view prefix) {
    const std::string_view line = next_line();
    std::size_t count = 0;
    const char* end = line.data() + line.size();
    if (line.starts_with(prefix)) {
      const auto [stop, error] = std::from_chars(line.data() + prefix.size(), end, count);
      if (error == std::errc() && stop == end && count <= kMaxVertices * 2) return count;
    }
    fail(fmt::format("line {} is not '{}' and a count", line_number_, prefix));
  }

  // Before memory is taken. No overflow: counts are below 2^32.
  void check_size(std::size_t vertex_count, std::size_t face_count) const {
    const std::size_t expected = vertex_count * vertex_bytes_ + face_count * kFaceBytes;
    const std::size_t present = bytes_.size() - at_;
    if (expected != present) {
      fail(fmt::format("{} bytes follow the header, {} vertices and {} faces take {}", present, vertex_count, face_count,
                       expected));
    }
  }

  MeshVertex vertex(std::size_t i) {
    const char* in = bytes_.data() + at_;
    MeshVertex vertex = vertex_bytes_ == kVertexBytes ? vertex_at<std::uint32_t>(in) : vertex_at<std::uint16_t>(in);
    if (!vertex.position.allFinite() || !vertex.normal.allFinite()) fail(fmt::format("vertex {} is not finite", i));
    at_ += vertex_bytes_;
    return vertex;
  }

  std::array<std::uint32_t, 3> face(std::size_t i, std::size_t vertex_count) {
    std::uint8_t corners = 0;
    const char* in = take(bytes_.data() + at_, corners);
    if (corners != kCorners) fail(fmt::format("face {} has {} corners, not 3", i, corners));
    std::array<std::uint32_t, 3> face{};
    for (std::uint32_t& index : face) {
      in = take(in, index);
      if (index >= vertex_count) fail(fmt::format("face {} names vertex {} of {}", i, index, vertex_count));
    }
    at_ += kFaceBytes;
    return face;
  }

  std::string name_;
  std::string_view bytes_;
  std::size_t at_ = 0;
  std::size_t vertex_bytes_ = kVertexBytes;
  int line_number_ = 0;
};

}  // namespace

void write_ply(const std::filesystem::path& path, const Mesh& mesh) {
  if (mesh.vertices.size() > kMaxVertices) {
    throw Error(fmt::format("cannot write {}: {} vertices, more than PLY faces can name; use larger voxels", path.string(),
                            mesh.vertices.size()));
  }
  PartialFile file(path);
  PieceWriter out([&](std::string_view piece) { file.append(piece); });
  out.put_bytes(header_text(mesh));
  for (const MeshVertex& vertex : mesh.vertices) put(vertex, out);
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    out.put(kCorners);
    for (const std::uint32_t index : triangle) out.put(index);
  }
  out.finish();
  file.commit();
}

Mesh read_ply(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kMaxFileBytes);
  return PlyReader(path, bytes).read();
}

}  // namespace panoptic
