// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/outputs.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/piece_writer.h"
#include "panoptic/error.h"
#include "panoptic/io/glb_parts.h"
#include "panoptic/mesh.h"

namespace panoptic {
namespace {

// Chunk lengths are 32-bit; the rest is room for the JSON part.
constexpr std::size_t kMaxBufferBytes = std::numeric_limits<std::uint32_t>::max() - (std::size_t{64} << 20);
constexpr std::size_t kFileHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr std::size_t kStandInBytes = 4;  // of the buffer, while the library encodes the rest

constexpr const char* kRootName = "map";

// The four buffer views, in this order in the one buffer. All vertices of a kind lie together, object after object.
enum View : int { kPositions, kNormals, kColors, kIndices, kViewCount };

double linear(std::uint8_t srgb) {
  const double s = srgb / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

// tinygltf's whole numbers have 31 bits.
tinygltf::Value id_value(PanopticId id) {
  const bool is_short = number(id) <= static_cast<std::uint32_t>(std::numeric_limits<int>::max());
  return is_short ? tinygltf::Value(static_cast<int>(number(id))) : tinygltf::Value(static_cast<double>(number(id)));
}

// Builds the glTF model object by object: all but the numbers of vertices and triangles, which would be another copy of the mesh.
class Scene {
 public:
  Scene(const Mesh& mesh, const LabelSet& labels) : mesh_(mesh), labels_(labels) {}

  void add(const GlbPart& part) {
    const PanopticId id = part.id;
    const ClassId class_id = class_of(id, part);
    const std::string name = unique(glb_node_name(id, class_id, labels_));
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.attributes = {
        {"POSITION", add_positions(part)},
        {"NORMAL", add_accessor(kNormals, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, part.vertices.size())},
        {"_COLOR", add_colors(part)}};
    primitive.indices = add_indices(part);
    primitive.material = static_cast<int>(model_.materials.size());
    add_material(name, color_of(id, labels_));
    tinygltf::Mesh mesh;
    mesh.name = name;
    mesh.primitives = {primitive};
    model_.meshes.push_back(mesh);
    tinygltf::Node node;
    node.name = name;
    node.mesh = static_cast<int>(model_.meshes.size()) - 1;
    node.extras = tinygltf::Value(tinygltf::Value::Object{{"class", tinygltf::Value(std::string(labels_.name_of(class_id)))},
                                                          {"class_id", tinygltf::Value(number(class_id))},
                                                          {"panoptic_id", id_value(id)}});
    model_.nodes.push_back(node);
  }

  std::size_t buffer_bytes() const { return std::accumulate(sizes_.begin(), sizes_.end(), std::size_t{0}); }

  // The finished model, whose buffer is a stand-in; the builder is spent.
  tinygltf::Model finish(const std::optional<Vec3d>& up) {
    model_.asset.version = "2.0";
    model_.asset.generator = "PanopticFusion";
    tinygltf::Scene scene;
    scene.name = "map";
    for (std::size_t i = 0; i < model_.nodes.size(); ++i) scene.nodes.push_back(static_cast<int>(i));
    if (up.has_value() && up->norm() > 0 && !model_.nodes.empty()) scene.nodes = {add_root(*up, scene.nodes)};
    model_.scenes.push_back(scene);
    model_.defaultScene = 0;
    if (!model_.nodes.empty()) add_views();
    return std::move(model_);
  }

 private:
  ClassId class_of(PanopticId id, const GlbPart& part) const {
    if (!labels_.is_object(id)) return static_cast<ClassId>(number(id));
    std::map<ClassId, std::size_t> votes;
    for (const std::uint32_t v : part.vertices) {
      if (mesh_.vertices[v].panoptic_id == id) votes[mesh_.vertices[v].class_id]++;
    }
    return std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
  }

  // Programs look nodes up by name: where class names make two equal, the later one gets a number.
  std::string unique(const std::string& name) {
    std::string candidate = name;
    for (int i = 2; !names_.insert(candidate).second; ++i) candidate = fmt::format("{}_{}", name, i);
    return candidate;
  }

  int add_accessor(View view, int component, int type, std::size_t count) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.byteOffset = sizes_[view];
    accessor.componentType = component;
    accessor.type = type;
    accessor.count = count;
    model_.accessors.push_back(accessor);
    sizes_[view] += count * static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(component)) *
                                                     tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type)));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  int add_positions(const GlbPart& part) {
    const int index = add_accessor(kPositions, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, part.vertices.size());
    Vec3f low = Vec3f::Constant(std::numeric_limits<float>::infinity());
    Vec3f high = -low;
    for (const std::uint32_t v : part.vertices) {
      low = low.cwiseMin(mesh_.vertices[v].position);
      high = high.cwiseMax(mesh_.vertices[v].position);
    }
    model_.accessors.back().minValues.assign(low.begin(), low.end());
    model_.accessors.back().maxValues.assign(high.begin(), high.end());
    return index;
  }

  // Not COLOR_0: viewers would multiply it with the material's colour.
  int add_colors(const GlbPart& part) {
    const int index = add_accessor(kColors, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_VEC4, part.vertices.size());
    model_.accessors.back().normalized = true;
    return index;
  }

  int add_indices(const GlbPart& part) {
    sizes_[kIndices] = padded(sizes_[kIndices]);
    const int component = has_short_indices(part) ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    return add_accessor(kIndices, component, TINYGLTF_TYPE_SCALAR, part.triangles.size() * 3);
  }

  void add_material(const std::string& name, const Rgb& color) {
    tinygltf::Material material;
    material.name = name;
    material.pbrMetallicRoughness.baseColorFactor = {linear(color.r), linear(color.g), linear(color.b), 1.0};
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 0.9;
    model_.materials.push_back(material);
  }

  int add_root(const Vec3d& up, const std::vector<int>& children) {
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(up, Vec3d::UnitY());
    tinygltf::Node root;
    root.name = kRootName;
    root.children = children;
    root.rotation = {turn.x(), turn.y(), turn.z(), turn.w()};
    model_.nodes.push_back(root);
    return static_cast<int>(model_.nodes.size()) - 1;
  }

  void add_views() {
    constexpr std::array<std::size_t, kViewCount> kStrides = {sizeof(float) * 3, sizeof(float) * 3, 4, 0};
    model_.buffers.emplace_back().data.resize(kStandInBytes);
    std::size_t begin = 0;
    for (std::size_t i = 0; i < kViewCount; ++i) {
      tinygltf::BufferView& view = model_.bufferViews.emplace_back();
      view.buffer = 0;
      view.byteOffset = begin;
      view.byteLength = sizes_[i];
      view.byteStride = kStrides[i];
      view.target = i == kIndices ? TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER : TINYGLTF_TARGET_ARRAY_BUFFER;
      begin += sizes_[i];
    }
  }

  const Mesh& mesh_;
  const LabelSet& labels_;
  std::set<std::string> names_{kRootName};
  tinygltf::Model model_;
  std::array<std::size_t, kViewCount> sizes_{};  // in bytes
};

// The JSON part of the model, whose buffer has so many bytes instead of its stand-in's.
std::string json_text(const tinygltf::Model& model, std::size_t buffer_bytes) {
  std::ostringstream stream;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, stream, false, true)) throw Error("the scene cannot be encoded as glTF");
  const std::string glb = stream.str();
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + kFileHeaderBytes, sizeof(length));
  std::string json = glb.substr(kFileHeaderBytes + kChunkHeaderBytes, length);
  json.erase(json.find_last_not_of(' ') + 1);  // the format's padding
  const std::string stand_in = fmt::format(R"("buffers":[{{"byteLength":{}}}])", kStandInBytes);
  if (const std::size_t at = json.find(stand_in); at != std::string::npos) {
    json.replace(at, stand_in.size(), fmt::format(R"("buffers":[{{"byteLength":{}}}])", buffer_bytes));
  }
  return json.append(padded(json.size()) - json.size(), ' ');
}

void put_chunk_header(std::size_t bytes, std::string_view type, PieceWriter& out) {
  out.put(static_cast<std::uint32_t>(bytes));
  out.put_bytes(type);
}

// Throws Error, before anything is put, if the scene is larger than the format allows.
void put_glb(const Mesh& mesh, const LabelSet& labels, const std::optional<Vec3d>& up, PieceWriter& out) {
  const std::vector<GlbPart> parts = split_by_id(mesh);
  Scene scene(mesh, labels);
  for (const GlbPart& part : parts) scene.add(part);
  const std::size_t buffer_bytes = scene.buffer_bytes();
  if (buffer_bytes > kMaxBufferBytes) {
    throw Error("the mesh takes more than the 4 GB that a .glb file can hold; use larger voxels");
  }
  const std::string json = json_text(scene.finish(up), buffer_bytes);
  const std::size_t binary_bytes = buffer_bytes > 0 ? kChunkHeaderBytes + padded(buffer_bytes) : 0;
  out.put_bytes("glTF");
  out.put(std::uint32_t{2});  // the version
  out.put(static_cast<std::uint32_t>(kFileHeaderBytes + kChunkHeaderBytes + json.size() + binary_bytes));
  put_chunk_header(json.size(), "JSON", out);
  out.put_bytes(json);
  if (binary_bytes > 0) {
    put_chunk_header(padded(buffer_bytes), {"BIN\0", 4}, out);
    put_buffer(mesh, parts, out);
  }
  out.finish();
}

}  // namespace

std::string glb_bytes(const Mesh& mesh, const LabelSet& labels, const std::optional<Vec3d>& up) {
  std::string bytes;
  PieceWriter out([&](std::string_view piece) { bytes.append(piece); });
  put_glb(mesh, labels, up, out);
  return bytes;
}

void write_glb(const std::filesystem::path& path, const Mesh& mesh, const LabelSet& labels, const std::optional<Vec3d>& up) {
  PartialFile file(path);
  PieceWriter out([&](std::string_view piece) { file.append(piece); });
  try {
    put_glb(mesh, labels, up, out);
  } catch (const FileError&) {
    throw;
  } catch (const Error& e) {
    throw Error(fmt::format("cannot write {}: {}", path.string(), e.what()));
  }
  file.commit();
}

}  // namespace panoptic
