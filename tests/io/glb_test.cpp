// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/outputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/mesh.h"
#include "tests/fresh_folder.h"
#include "tests/io/test_room.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;

std::uint32_t uint32_at(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

struct Glb {
  Json json;
  std::string binary;
};

// Follows the format's chunks, so that the test does not rely on the library that wrote them.
Glb parse(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(uint32_at(bytes, 8), bytes.size());
  const std::size_t json_bytes = uint32_at(bytes, kHeaderBytes);
  Glb glb{Json::parse(bytes.substr(kHeaderBytes + kChunkHeaderBytes, json_bytes)), {}};
  const std::size_t second = kHeaderBytes + kChunkHeaderBytes + json_bytes;
  if (second < bytes.size()) glb.binary = bytes.substr(second + kChunkHeaderBytes, uint32_at(bytes, second));
  return glb;
}

Glb written(const std::string& folder, const Mesh& mesh, const std::optional<Vec3d>& up = {}) {
  const auto path = test::fresh_folder(folder) / "scene.glb";
  write_glb(path, mesh, test::room_labels(), up);
  return parse(path);
}

std::size_t offset_of(const Json& json, const Json& accessor, std::size_t stride, std::size_t i) {
  const Json& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
  return view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0}) + i * stride;
}

Vec3f vec3_at(const Glb& glb, const Json& accessor, std::size_t i) {
  Vec3f value;
  std::memcpy(value.data(), glb.binary.data() + offset_of(glb.json, accessor, sizeof(Vec3f), i), sizeof(Vec3f));
  return value;
}

std::uint32_t index_at(const Glb& glb, const Json& accessor, std::size_t i) {
  const std::size_t width = accessor["componentType"] == kUnsignedShort ? 2 : 4;
  std::uint32_t value = 0;
  std::memcpy(&value, glb.binary.data() + offset_of(glb.json, accessor, width, i), width);
  return value;
}

const Json& primitive_of(const Glb& glb, const std::string& node_name) {
  for (const Json& node : glb.json["nodes"]) {
    if (node["name"] == node_name) return glb.json["meshes"][node["mesh"].get<std::size_t>()]["primitives"][0];
  }
  throw Error("no node " + node_name);
}

const Json& accessor_of(const Glb& glb, const Json& index) { return glb.json["accessors"][index.get<std::size_t>()]; }

TEST(Glb, OneNodePerObjectNamedByClassAndId) {
  const Glb glb = written("glb_nodes", test::room(0.5F));
  std::map<std::string, Json> extras;
  for (const Json& node : glb.json["nodes"]) extras[node["name"]] = node["extras"];
  std::set<std::string> names;
  for (const auto& [name, extra] : extras) names.insert(name);
  EXPECT_THAT(names, UnorderedElementsAre("unknown", "wall", "floor", "dining_table_5", "chair_6", "chair_7"));
  EXPECT_EQ(extras["dining_table_5"]["class"], "dining table");
  EXPECT_EQ(extras["dining_table_5"]["class_id"], 4);
  EXPECT_EQ(extras["dining_table_5"]["panoptic_id"], 5);
  EXPECT_EQ(extras["floor"]["class"], "floor");
  EXPECT_EQ(extras["floor"]["panoptic_id"], 2);
  EXPECT_EQ(glb.json["nodes"].size(), glb.json["scenes"][0]["nodes"].size());
}

TEST(Glb, NodeNamesAreUniqueEvenWhereClassNamesAreNot) {
  Mesh mesh = test::room(0.5F);
  const LabelSet labels(
      "clash", {{ClassId{1}, "map", false, {}}, {ClassId{2}, "book shelf", false, {}}, {ClassId{3}, "book_shelf", false, {}}});
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    mesh.vertices[v].class_id = static_cast<ClassId>(1 + 3 * v / mesh.vertices.size());
    mesh.vertices[v].panoptic_id = static_cast<PanopticId>(number(mesh.vertices[v].class_id));
  }
  const auto path = test::fresh_folder("glb_names") / "scene.glb";
  write_glb(path, mesh, labels, Vec3d::UnitZ());
  std::vector<std::string> names;
  const Glb glb = parse(path);
  for (const Json& node : glb.json["nodes"]) names.push_back(node["name"]);
  EXPECT_THAT(names, UnorderedElementsAre("map", "map_2", "book_shelf", "book_shelf_2"));
}

TEST(Glb, MaterialsCarryTheObjectsColorInLinearLight) {
  const Glb glb = written("glb_materials", test::room(0.5F));
  const Json& material = glb.json["materials"][primitive_of(glb, "wall")["material"].get<std::size_t>()];
  const Json& factor = material["pbrMetallicRoughness"]["baseColorFactor"];
  EXPECT_NEAR(factor[0].get<double>(), 0.4233, 1e-3);  // sRGB 174
  EXPECT_NEAR(factor[1].get<double>(), 0.5711, 1e-3);  // 199
  EXPECT_NEAR(factor[2].get<double>(), 0.8070, 1e-3);  // 232
  std::set<std::string> colors;
  for (const Json& m : glb.json["materials"]) colors.insert(m["pbrMetallicRoughness"]["baseColorFactor"].dump());
  EXPECT_EQ(colors.size(), 6U);
}

TEST(Glb, GeometryIsThatOfTheMesh) {
  const Mesh room = test::room(0.25F);
  const Glb glb = written("glb_geometry", room);
  for (const ObjectShape& shape : object_shapes(room)) {
    const std::map<int, std::string> names = {{1, "wall"}, {2, "floor"}, {5, "dining_table_5"}, {6, "chair_6"}, {7, "chair_7"}};
    const std::string& name = names.at(number(shape.id));
    const Json& primitive = primitive_of(glb, name);
    const Json& positions = accessor_of(glb, primitive["attributes"]["POSITION"]);
    const Json& indices = accessor_of(glb, primitive["indices"]);
    double area = 0;
    for (std::size_t i = 0; i < indices["count"].get<std::size_t>(); i += 3) {
      std::array<Vec3f, 3> corner;
      for (std::size_t k = 0; k < 3; ++k) corner[k] = vec3_at(glb, positions, index_at(glb, indices, i + k));
      area += 0.5 * (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm();
    }
    EXPECT_NEAR(area, shape.area_m2, 1e-4) << name;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(positions["min"][static_cast<std::size_t>(axis)].get<float>(), static_cast<float>(shape.min_m[axis])) << name;
      EXPECT_EQ(positions["max"][static_cast<std::size_t>(axis)].get<float>(), static_cast<float>(shape.max_m[axis])) << name;
    }
  }
}

TEST(Glb, NormalsAreUnitEvenWhereTheMeshHasNone) {
  Mesh mesh;
  test::add_sheet(mesh, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, test::paint({1, 2, 3}, 3, 6), 0.5F);
  mesh.vertices[0].normal = Vec3f::Zero();
  mesh.vertices[1].normal = Vec3f::Constant(std::numeric_limits<float>::quiet_NaN());
  mesh.vertices[2].normal = {0, 0, 5};
  const Glb glb = written("glb_normals", mesh);
  const Json& normals = accessor_of(glb, primitive_of(glb, "chair_6")["attributes"]["NORMAL"]);
  for (std::size_t i = 0; i < normals["count"].get<std::size_t>(); ++i) {
    EXPECT_TRUE(vec3_at(glb, normals, i).isApprox(Vec3f::UnitZ(), 1e-6F)) << i;
  }
}

TEST(Glb, IndicesAreOnlyAsWideAsNeeded) {
  Mesh mesh;
  test::add_sheet(mesh, {0, 0, 0}, {2.54F, 0, 0}, {0, 2.54F, 0}, test::paint({1, 2, 3}, 3, 6), 0.01F);  // 255 x 255 vertices
  test::add_sheet(mesh, {0, 0, 1}, {2.56F, 0, 0}, {0, 2.56F, 0}, test::paint({1, 2, 3}, 3, 7), 0.01F);
  const Glb glb = written("glb_indices", mesh);
  EXPECT_EQ(accessor_of(glb, primitive_of(glb, "chair_6")["indices"])["componentType"], kUnsignedShort);
  EXPECT_EQ(accessor_of(glb, primitive_of(glb, "chair_7")["indices"])["componentType"], kUnsignedInt);
}

TEST(Glb, UpBecomesPlusY) {
  const Glb glb = written("glb_up", test::room(0.5F), Vec3d(0, -2, 0));
  ASSERT_EQ(glb.json["scenes"][0]["nodes"].size(), 1U);
  const Json& root = glb.json["nodes"][glb.json["scenes"][0]["nodes"][0].get<std::size_t>()];
  EXPECT_EQ(root["name"], "map");
  EXPECT_EQ(root["children"].size(), 6U);
  const auto r = root["rotation"].get<std::array<double, 4>>();
  const Vec3d up = Eigen::Quaterniond(r[3], r[0], r[1], r[2]) * Vec3d(0, -1, 0);
  EXPECT_TRUE(up.isApprox(Vec3d::UnitY(), 1e-9)) << up.transpose();
}

TEST(Glb, TrianglesThatCannotBeDrawnAreLeftOut) {
  Mesh mesh;
  test::add_sheet(mesh, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, test::paint({1, 2, 3}, 3, 6), 1);
  mesh.vertices.push_back(mesh.vertices[0]);
  mesh.vertices.back().position.x() = std::numeric_limits<float>::infinity();
  mesh.triangles.push_back({0, 1, 4});
  mesh.triangles.push_back({0, 1, 1});
  const Glb glb = written("glb_left_out", mesh);
  const Json& primitive = primitive_of(glb, "chair_6");
  EXPECT_EQ(accessor_of(glb, primitive["indices"])["count"], 6);
  EXPECT_EQ(accessor_of(glb, primitive["attributes"]["POSITION"])["count"], 4);
}

TEST(Glb, AnUnwritableFolderIsAnError) {
  const auto path = test::fresh_folder("glb_unwritable") / "absent" / "scene.glb";
  EXPECT_THROW(write_glb(path, test::room(0.5F), test::room_labels()), Error);
}

// Runs the Khronos validator: exit code and what it printed.
std::pair<int, std::string> validate(const std::filesystem::path& path) {
  const std::string script = test::source_folder().string() + "/tools/gltf_validator/validate.mjs";
  const std::string command = "node '" + script + "' '" + path.string() + "' 2>&1";
  FILE* pipe = popen(command.c_str(), "r");  // NOLINT(cert-env33-c): a fixed command
  if (pipe == nullptr) return {127, "no shell"};
  std::string output;
  std::array<char, 4096> part{};
  while (const std::size_t got = std::fread(part.data(), 1, part.size(), pipe)) output.append(part.data(), got);
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 1, output};
}

class GlbValidator : public ::testing::Test {
 protected:
  void SetUp() override {
    static const auto kTried = validate("/dev/null");
    const auto& [code, output] = kTried;
    if (code == 127) GTEST_SKIP() << "node is not installed, so the Khronos validator did not run";
    if (code == 3) GTEST_SKIP() << "the Khronos validator did not run: " << output;
  }

  static void expect_valid(const std::string& folder, const Mesh& mesh, const std::optional<Vec3d>& up) {
    const auto path = test::fresh_folder(folder) / "scene.glb";
    write_glb(path, mesh, test::room_labels(), up);
    const auto [code, output] = validate(path);
    EXPECT_EQ(code, 0) << output;
    EXPECT_THAT(output, HasSubstr("0 errors, 0 warnings"));
  }
};

TEST_F(GlbValidator, FindsNothingInARoom) { expect_valid("glb_valid_room", test::room(0.05F), Vec3d(0, -1, 0)); }

TEST_F(GlbValidator, FindsNothingInAnEmptyScene) { expect_valid("glb_valid_empty", {}, Vec3d(0, -1, 0)); }

TEST_F(GlbValidator, FindsNothingWhereNormalsAndTrianglesAreBroken) {
  Mesh mesh = test::room(0.1F);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 7) mesh.vertices[i].normal = Vec3f::Zero();
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 101)
    mesh.vertices[i].position.x() = std::numeric_limits<float>::quiet_NaN();
  expect_valid("glb_valid_broken", mesh, {});
}

TEST_F(GlbValidator, FindsNothingInWideIndices) {
  Mesh mesh;
  test::add_sheet(mesh, {0, 0, 0}, {3, 0, 0}, {0, 3, 0}, test::paint({1, 2, 3}, 3, 6), 0.01F);
  test::add_box(mesh, {0, 0, 1}, {1, 1, 2}, test::paint({1, 2, 3}, 3, 65534), 1);
  expect_valid("glb_valid_wide", mesh, {});
}

TEST_F(GlbValidator, WouldSayIfSomethingWereWrong) {
  const auto path = test::fresh_folder("glb_invalid") / "scene.glb";
  write_glb(path, test::room(0.5F), test::room_labels());
  std::string bytes = read_file(path);
  const std::size_t at = bytes.find("\"min\":[") + 7;
  bytes[at] = '9';
  write_file(path, bytes);
  EXPECT_EQ(validate(path).first, 1);
}

}  // namespace
}  // namespace panoptic
