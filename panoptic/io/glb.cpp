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
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/data/speaker.h"
#include "panoptic/error.h"
#include "panoptic/mesh.h"

namespace panoptic {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// Chunk lengths are 32-bit; the rest is room for the JSON part.
constexpr std::size_t kMaxBufferBytes = std::numeric_limits<std::uint32_t>::max() - (std::size_t{64} << 20);
// 65535 would restart a primitive.
constexpr std::size_t kMaxShortIndexVertices = 65535;

constexpr const char* kRootName = "map";

// The four buffer views, in this order in the one buffer. All vertices of a kind lie together, object after object.
enum View : int { kPositions, kNormals, kColors, kIndices, kViewCount };

// One object's triangles with vertices of its own.
struct Part {
  std::vector<std::uint32_t> vertices;  // of the mesh
  std::vector<Triangle> triangles;      // of positions in `vertices`
};

bool is_usable(const Mesh& mesh, const Triangle& t) {
  const auto finite = [&](std::uint32_t v) { return mesh.vertices[v].position.allFinite(); };
  return t[0] != t[1] && t[1] != t[2] && t[2] != t[0] && finite(t[0]) && finite(t[1]) && finite(t[2]);
}

std::map<PanopticId, Part> split_by_id(const Mesh& mesh) {
  std::map<PanopticId, Part> parts;
  for (const Triangle& t : mesh.triangles) {
    if (!is_usable(mesh, t)) continue;
    const auto id = [&](std::size_t corner) { return mesh.vertices[t[corner]].panoptic_id; };
    parts[id(static_cast<std::size_t>(speaker(id(0), id(1), id(2))))].triangles.push_back(t);
  }
  for (auto& [id, part] : parts) {
    for (const Triangle& t : part.triangles) part.vertices.insert(part.vertices.end(), t.begin(), t.end());
    std::sort(part.vertices.begin(), part.vertices.end());
    part.vertices.erase(std::unique(part.vertices.begin(), part.vertices.end()), part.vertices.end());
    for (Triangle& t : part.triangles) {
      for (std::uint32_t& index : t) {
        const auto found = std::lower_bound(part.vertices.begin(), part.vertices.end(), index);
        index = static_cast<std::uint32_t>(found - part.vertices.begin());
      }
    }
  }
  return parts;
}

// Unit normals; where the mesh has none, those of the triangles around.
std::vector<Vec3f> normals_of(const Mesh& mesh, const Part& part) {
  const auto is_direction = [](const Vec3f& n) { return n.allFinite() && n.norm() > 1e-6F; };
  std::vector<Vec3f> around(part.vertices.size(), Vec3f::Zero());
  for (const Triangle& t : part.triangles) {
    const auto at = [&](std::size_t corner) -> const Vec3f& { return mesh.vertices[part.vertices[t[corner]]].position; };
    const Vec3f normal = (at(1) - at(0)).cross(at(2) - at(0));
    for (const std::uint32_t index : t) around[index] += normal;
  }
  std::vector<Vec3f> normals;
  for (std::size_t i = 0; i < part.vertices.size(); ++i) {
    const Vec3f& given = mesh.vertices[part.vertices[i]].normal;
    Vec3f normal = is_direction(given) ? given : around[i];
    normals.emplace_back(normal.norm() > 0 && normal.allFinite() ? normal.stableNormalized() : Vec3f::UnitY());
  }
  return normals;
}

double linear(std::uint8_t srgb) {
  const double s = srgb / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

std::string node_name(PanopticId id, ClassId class_id, const LabelSet& labels) {
  std::string name(labels.name_of(class_id));
  std::replace(name.begin(), name.end(), ' ', '_');
  const bool is_whole_class = id == PanopticId::kUnknown || (LabelSet::id_of_class(class_id) == id && labels.is_stuff(class_id));
  return is_whole_class ? name : fmt::format("{}_{}", name, number(id));
}

// tinygltf's whole numbers have 31 bits.
tinygltf::Value id_value(PanopticId id) {
  const bool is_short = number(id) <= static_cast<std::uint32_t>(std::numeric_limits<int>::max());
  return is_short ? tinygltf::Value(static_cast<int>(number(id))) : tinygltf::Value(static_cast<double>(number(id)));
}

// Builds the glTF model object by object.
class Scene {
 public:
  Scene(const Mesh& mesh, const LabelSet& labels) : mesh_(mesh), labels_(labels) {}

  void add(PanopticId id, const Part& part) {
    const ClassId class_id = class_of(id, part);
    const std::string name = unique(node_name(id, class_id, labels_));
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.attributes = {{"POSITION", add_positions(part)}, {"NORMAL", add_normals(part)}, {"_COLOR", add_colors(part)}};
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

  // The finished model; the builder is spent.
  tinygltf::Model finish(const std::optional<Vec3d>& up) {
    model_.asset.version = "2.0";
    model_.asset.generator = "PanopticFusion";
    tinygltf::Scene scene;
    scene.name = "map";
    for (std::size_t i = 0; i < model_.nodes.size(); ++i) scene.nodes.push_back(static_cast<int>(i));
    if (up.has_value() && up->norm() > 0 && !model_.nodes.empty()) scene.nodes = {add_root(*up, scene.nodes)};
    model_.scenes.push_back(scene);
    model_.defaultScene = 0;
    if (!model_.nodes.empty()) join_views();
    return std::move(model_);
  }

 private:
  ClassId class_of(PanopticId id, const Part& part) const {
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

  template <typename T>
  void append(View view, const T* values, std::size_t count) {
    std::vector<unsigned char>& bytes = bytes_[view];
    const std::size_t at = bytes.size();
    bytes.resize(at + count * sizeof(T));
    std::memcpy(bytes.data() + at, values, count * sizeof(T));
  }

  int add_accessor(View view, int component, int type, std::size_t count) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.byteOffset = bytes_[view].size();
    accessor.componentType = component;
    accessor.type = type;
    accessor.count = count;
    model_.accessors.push_back(accessor);
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  int add_positions(const Part& part) {
    const int index = add_accessor(kPositions, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, part.vertices.size());
    Vec3f low = Vec3f::Constant(std::numeric_limits<float>::infinity());
    Vec3f high = -low;
    for (const std::uint32_t v : part.vertices) {
      const Vec3f& position = mesh_.vertices[v].position;
      append(kPositions, position.data(), 3);
      low = low.cwiseMin(position);
      high = high.cwiseMax(position);
    }
    model_.accessors.back().minValues.assign(low.begin(), low.end());
    model_.accessors.back().maxValues.assign(high.begin(), high.end());
    return index;
  }

  int add_normals(const Part& part) {
    const int index = add_accessor(kNormals, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, part.vertices.size());
    for (const Vec3f& normal : normals_of(mesh_, part)) append(kNormals, normal.data(), 3);
    return index;
  }

  // Not COLOR_0: viewers would multiply it with the material's colour.
  int add_colors(const Part& part) {
    const int index = add_accessor(kColors, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_VEC4, part.vertices.size());
    model_.accessors.back().normalized = true;
    for (const std::uint32_t v : part.vertices) {
      const Rgb& color = mesh_.vertices[v].color;
      const std::array<std::uint8_t, 4> rgba = {color.r, color.g, color.b, 255};
      append(kColors, rgba.data(), rgba.size());
    }
    return index;
  }

  // 16 bits where they suffice. Never 8: WebGPU and Direct3D have no such indices, and viewers convert them.
  int add_indices(const Part& part) {
    bytes_[kIndices].resize((bytes_[kIndices].size() + 3) / 4 * 4);
    const bool is_short = part.vertices.size() <= kMaxShortIndexVertices;
    const int component = is_short ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    const int index = add_accessor(kIndices, component, TINYGLTF_TYPE_SCALAR, part.triangles.size() * 3);
    for (const Triangle& t : part.triangles) {
      const std::array<std::uint16_t, 3> narrow = {static_cast<std::uint16_t>(t[0]), static_cast<std::uint16_t>(t[1]),
                                                   static_cast<std::uint16_t>(t[2])};
      if (is_short) append(kIndices, narrow.data(), narrow.size());
      if (!is_short) append(kIndices, t.data(), t.size());
    }
    return index;
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

  void join_views() {
    constexpr std::array<std::size_t, kViewCount> kStrides = {sizeof(float) * 3, sizeof(float) * 3, 4, 0};
    tinygltf::Buffer& buffer = model_.buffers.emplace_back();
    for (std::size_t i = 0; i < kViewCount; ++i) {
      tinygltf::BufferView& view = model_.bufferViews.emplace_back();
      view.buffer = 0;
      view.byteOffset = buffer.data.size();
      view.byteLength = bytes_[i].size();
      view.byteStride = kStrides[i];
      view.target = i == kIndices ? TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER : TINYGLTF_TARGET_ARRAY_BUFFER;
      buffer.data.insert(buffer.data.end(), bytes_[i].begin(), bytes_[i].end());
      std::vector<unsigned char>().swap(bytes_[i]);
    }
  }

  const Mesh& mesh_;
  const LabelSet& labels_;
  std::set<std::string> names_{kRootName};
  tinygltf::Model model_;
  std::array<std::vector<unsigned char>, kViewCount> bytes_;
};

}  // namespace

std::string glb_bytes(const Mesh& mesh, const LabelSet& labels, const std::optional<Vec3d>& up) {
  Scene builder(mesh, labels);
  for (const auto& [id, part] : split_by_id(mesh)) builder.add(id, part);
  const tinygltf::Model model = builder.finish(up);
  if (!model.buffers.empty() && model.buffers.front().data.size() > kMaxBufferBytes) {
    throw Error("the mesh takes more than the 4 GB that a .glb file can hold; use larger voxels");
  }
  std::ostringstream stream;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, stream, false, true)) throw Error("the scene cannot be encoded as glTF");
  return stream.str();
}

void write_glb(const std::filesystem::path& path, const Mesh& mesh, const LabelSet& labels, const std::optional<Vec3d>& up) {
  std::string bytes;
  try {
    bytes = glb_bytes(mesh, labels, up);
  } catch (const Error& e) {
    throw Error(fmt::format("cannot write {}: {}", path.string(), e.what()));
  }
  write_file(path, bytes);
}

}  // namespace panoptic
