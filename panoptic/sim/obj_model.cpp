// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/obj_model.h"

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::size_t kMaxTriangles = 400'000;
constexpr std::size_t kMaxLine = 32'768;  // cutting a polygon into triangles takes time that grows with its square
constexpr float kMaxCoordinate = 1e7F;
constexpr std::uint32_t kNone = 0xFFFFFFFFU;

using Triangle = std::array<std::uint32_t, 3>;

// Vertices of an OBJ are pairs of a position and a texture coordinate; ours are one thing. The pairs of one position form a
// linked list.
class VertexMerger {
 public:
  VertexMerger(const tinyobj::attrib_t& attributes, const std::string& name, SceneModel& model)
      : attributes_(attributes), name_(name), model_(model), first_(attributes.vertices.size() / 3, kNone) {}

  std::uint32_t vertex(const tinyobj::index_t& index) {
    const auto position = static_cast<std::size_t>(index.vertex_index);
    if (index.vertex_index < 0 || position >= first_.size())
      throw Error(
          fmt::format("{}: a face refers to vertex {} of {}", name_, index.vertex_index + std::int64_t{1}, first_.size()));
    std::uint32_t* link = &first_[position];
    while (*link != kNone) {
      if (texcoord_of_[*link] == index.texcoord_index) return *link;
      link = &next_[*link];
    }
    const auto added = static_cast<std::uint32_t>(model_.positions.size());
    *link = added;  // before next_ grows, which moves what link may point to
    next_.push_back(kNone);
    texcoord_of_.push_back(index.texcoord_index);
    model_.positions.push_back(position_at(position));
    model_.uvs.push_back(uv_at(index.texcoord_index));
    return added;
  }

 private:
  Vec3f position_at(std::size_t i) const {
    Vec3f p(attributes_.vertices[3 * i], attributes_.vertices[3 * i + 1], attributes_.vertices[3 * i + 2]);
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > kMaxCoordinate)
      throw Error(fmt::format("{}: vertex {} is not a finite position within {:g}", name_, i + 1, kMaxCoordinate));
    return p;
  }

  // OBJ counts v from the bottom, images from the top.
  Eigen::Vector2f uv_at(int texcoord) const {
    if (texcoord < 0) return Eigen::Vector2f::Zero();
    const auto i = static_cast<std::size_t>(texcoord);
    if (2 * i + 1 >= attributes_.texcoords.size())
      throw Error(
          fmt::format("{}: a face refers to texture coordinate {} of {}", name_, i + 1, attributes_.texcoords.size() / 2));
    Eigen::Vector2f uv(attributes_.texcoords[2 * i], 1 - attributes_.texcoords[2 * i + 1]);
    if (!uv.allFinite() || uv.cwiseAbs().maxCoeff() > kMaxCoordinate)
      throw Error(fmt::format("{}: texture coordinate {} is not a finite number within {:g}", name_, i + 1, kMaxCoordinate));
    return uv;
  }

  const tinyobj::attrib_t& attributes_;
  const std::string& name_;
  SceneModel& model_;
  std::vector<std::uint32_t> first_;  // per position of the file, the first vertex made of it
  std::vector<std::uint32_t> next_;   // per vertex
  std::vector<int> texcoord_of_;      // per vertex
};

Rgb to_rgb(const tinyobj::real_t* diffuse) {
  const auto byte = [](float value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * 255.0F)); };
  const auto finite = [](float value) { return std::isfinite(value) ? value : 0.0F; };
  return {byte(finite(diffuse[0])), byte(finite(diffuse[1])), byte(finite(diffuse[2]))};
}

ObjMaterial to_material(const tinyobj::material_t& material) {
  return {to_rgb(material.diffuse), std::isfinite(material.dissolve) ? material.dissolve : 1.0F, material.diffuse_texname};
}

std::uint32_t index_in(std::vector<ObjMaterial>& materials, const ObjMaterial& wanted) {
  const auto found = std::find(materials.begin(), materials.end(), wanted);
  if (found == materials.end()) materials.push_back(wanted);
  return static_cast<std::uint32_t>(std::distance(materials.begin(), std::find(materials.begin(), materials.end(), wanted)));
}

void check_lines(const std::string& text, const std::string& name) {
  for (std::size_t start = 0, line = 1; start < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    if (end - start > kMaxLine) throw Error(fmt::format("{}:{}: a line of {} characters", name, line, end - start));
    start = end + 1;
  }
}

}  // namespace

std::string material_library(const std::string& obj_text) {
  constexpr std::string_view keyword = "mtllib ";
  for (std::size_t at = obj_text.find(keyword); at != std::string::npos; at = obj_text.find(keyword, at + 1)) {
    if (at > 0 && obj_text[at - 1] != '\n') continue;
    const std::size_t end = std::min(obj_text.find_first_of("\r\n", at), obj_text.size());
    return obj_text.substr(at + keyword.size(), end - at - keyword.size());
  }
  return "";
}

ObjModel parse_obj(const std::string& obj_text, const std::string& mtl_text, const std::string& name) {
  check_lines(obj_text, name);
  tinyobj::ObjReaderConfig config;
  config.vertex_color = false;
  tinyobj::ObjReader reader;
  if (!reader.ParseFromString(obj_text, mtl_text, config))
    throw Error(fmt::format("{}: not a valid OBJ: {}", name, reader.Error()));

  ObjModel result;
  std::vector<std::uint32_t> material_index;
  for (const tinyobj::material_t& material : reader.GetMaterials())
    material_index.push_back(index_in(result.materials, to_material(material)));
  VertexMerger merger(reader.GetAttrib(), name, result.model);
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    const std::vector<tinyobj::index_t>& indices = shape.mesh.indices;
    for (std::size_t face = 0; 3 * face + 2 < indices.size(); ++face) {
      if (result.model.triangles.size() == kMaxTriangles)
        throw Error(fmt::format("{}: more than {} triangles", name, kMaxTriangles));
      Triangle triangle{};
      for (std::size_t corner = 0; corner < 3; ++corner) triangle[corner] = merger.vertex(indices[3 * face + corner]);
      const int material = face < shape.mesh.material_ids.size() ? shape.mesh.material_ids[face] : -1;
      const bool known = material >= 0 && static_cast<std::size_t>(material) < material_index.size();
      result.model.triangles.push_back(triangle);
      result.model.material_of.push_back(known ? material_index[static_cast<std::size_t>(material)] : kNone);
    }
  }
  if (result.model.triangles.empty()) throw Error(fmt::format("{}: holds no faces", name));
  for (std::uint32_t& material : result.model.material_of) {
    if (material == kNone) material = index_in(result.materials, ObjMaterial{});
  }
  return result;
}

}  // namespace panoptic
