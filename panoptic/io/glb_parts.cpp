// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/glb_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>

#include "panoptic/data/speaker.h"

namespace panoptic {
namespace {

constexpr std::size_t kMaxShortIndexVertices = 65535;

using Triangle = std::array<std::uint32_t, 3>;

bool is_usable(const Mesh& mesh, const Triangle& t) {
  const auto finite = [&](std::uint32_t v) { return mesh.vertices[v].position.allFinite(); };
  return t[0] != t[1] && t[1] != t[2] && t[2] != t[0] && finite(t[0]) && finite(t[1]) && finite(t[2]);
}

// The place of each vertex of the mesh among those of a part.
class Places {
 public:
  explicit Places(const Mesh& mesh) : place_(mesh.vertices.size()) {}

  void look_at(const GlbPart& part) {
    for (std::size_t i = 0; i < part.vertices.size(); ++i) place_[part.vertices[i]] = static_cast<std::uint32_t>(i);
  }
  // REQUIRES a vertex of the part that was looked at last.
  std::uint32_t operator[](std::uint32_t vertex) const { return place_[vertex]; }

 private:
  std::vector<std::uint32_t> place_;
};

bool is_direction(const Vec3f& n) { return n.allFinite() && n.norm() > 1e-6F; }

// By vertex of the part: the normals of the triangles around, added up. Nothing if the mesh has all the part's normals itself.
std::vector<Vec3f> normals_around(const Mesh& mesh, const GlbPart& part, const Places& places) {
  const auto given = [&](std::uint32_t v) { return is_direction(mesh.vertices[v].normal); };
  if (std::all_of(part.vertices.begin(), part.vertices.end(), given)) return {};
  std::vector<Vec3f> around(part.vertices.size(), Vec3f::Zero());
  for (const std::uint32_t i : part.triangles) {
    const Triangle& t = mesh.triangles[i];
    const auto at = [&](std::size_t corner) -> const Vec3f& { return mesh.vertices[t[corner]].position; };
    const Vec3f normal = (at(1) - at(0)).cross(at(2) - at(0));
    for (const std::uint32_t v : t) around[places[v]] += normal;
  }
  return around;
}

Vec3f unit(const Vec3f& normal) {
  return normal.norm() > 0 && normal.allFinite() ? Vec3f(normal.stableNormalized()) : Vec3f(Vec3f::UnitY());
}

// Writes what the buffer views hold, one after the other.
class BufferWriter {
 public:
  BufferWriter(const Mesh& mesh, const std::vector<GlbPart>& parts, PieceWriter& out)
      : mesh_(mesh), parts_(parts), places_(mesh), out_(out) {}

  void write() {
    for (const GlbPart& part : parts_) {
      for (const std::uint32_t v : part.vertices) put(mesh_.vertices[v].position);
    }
    for (const GlbPart& part : parts_) put_normals(part);
    for (const GlbPart& part : parts_) {
      for (const std::uint32_t v : part.vertices) {
        const Rgb& color = mesh_.vertices[v].color;
        out_.put(std::array<std::uint8_t, 4>{color.r, color.g, color.b, 255});
      }
    }
    std::size_t written = 0;  // of indices, in bytes
    for (const GlbPart& part : parts_) {
      pad(written);
      put_indices(part);
      written = padded(written) + part.triangles.size() * 3 * (has_short_indices(part) ? 2 : 4);
    }
    pad(written);
  }

 private:
  void put(const Vec3f& v) { out_.put(std::array<float, 3>{v.x(), v.y(), v.z()}); }

  void pad(std::size_t written) {
    for (std::size_t i = written; i < padded(written); ++i) out_.put('\0');
  }

  // Unit normals; where the mesh has none, those of the triangles around.
  void put_normals(const GlbPart& part) {
    places_.look_at(part);
    const std::vector<Vec3f> around = normals_around(mesh_, part, places_);
    for (const std::uint32_t v : part.vertices) {
      const Vec3f& given = mesh_.vertices[v].normal;
      put(unit(is_direction(given) ? given : around[places_[v]]));
    }
  }

  // 16 bits where they suffice.
  void put_indices(const GlbPart& part) {
    places_.look_at(part);
    const bool is_short = has_short_indices(part);
    for (const std::uint32_t i : part.triangles) {
      for (const std::uint32_t v : mesh_.triangles[i]) {
        is_short ? out_.put(static_cast<std::uint16_t>(places_[v])) : out_.put(places_[v]);
      }
    }
  }

  const Mesh& mesh_;
  const std::vector<GlbPart>& parts_;
  Places places_;
  PieceWriter& out_;
};

}  // namespace

std::vector<GlbPart> split_by_id(const Mesh& mesh) {
  std::map<PanopticId, GlbPart> by_id;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    if (!is_usable(mesh, t)) continue;
    const auto id = [&](std::size_t corner) { return mesh.vertices[t[corner]].panoptic_id; };
    by_id[id(static_cast<std::size_t>(speaker(id(0), id(1), id(2))))].triangles.push_back(i);
  }
  std::vector<GlbPart> parts;
  std::vector<std::uint32_t> last_part(mesh.vertices.size(), 0);  // by vertex: the newest that has it, counted from 1
  for (auto& [id, part] : by_id) {
    parts.push_back({id, {}, std::move(part.triangles)});
    for (const std::uint32_t i : parts.back().triangles) {
      for (const std::uint32_t v : mesh.triangles[i]) {
        if (std::exchange(last_part[v], static_cast<std::uint32_t>(parts.size())) == parts.size()) continue;
        parts.back().vertices.push_back(v);
      }
    }
    std::sort(parts.back().vertices.begin(), parts.back().vertices.end());
  }
  return parts;
}

std::string glb_node_name(PanopticId id, ClassId class_id, const LabelSet& labels) {
  std::string name(labels.name_of(class_id));
  std::replace(name.begin(), name.end(), ' ', '_');
  const bool is_whole_class = id == PanopticId::kUnknown || (LabelSet::id_of_class(class_id) == id && labels.is_stuff(class_id));
  return is_whole_class ? name : fmt::format("{}_{}", name, number(id));
}

bool has_short_indices(const GlbPart& part) { return part.vertices.size() <= kMaxShortIndexVertices; }

void put_buffer(const Mesh& mesh, const std::vector<GlbPart>& parts, PieceWriter& out) { BufferWriter(mesh, parts, out).write(); }

}  // namespace panoptic
