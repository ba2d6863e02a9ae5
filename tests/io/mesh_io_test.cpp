// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/outputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <string>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "tests/fresh_folder.h"
#include "tests/io/test_room.h"

namespace panoptic {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::size_t kVertexBytes = 33;
constexpr std::size_t kFaceBytes = 13;

Mesh one_triangle() {
  Mesh mesh;
  for (int i = 0; i < 3; ++i) {
    const auto f = static_cast<float>(i);
    mesh.vertices.push_back({{f, f + 0.25F, -f},
                             {0, 0, -1},
                             {1, 2, 250},
                             static_cast<ClassId>(3),
                             static_cast<PanopticId>(4'000'000'000U + static_cast<std::uint32_t>(i))});
  }
  mesh.triangles.push_back({0, 1, 2});
  return mesh;
}

std::string bytes_of(const Mesh& mesh, const std::filesystem::path& folder) {
  write_ply(folder / "mesh.ply", mesh);
  return read_file(folder / "mesh.ply");
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// The one line that reading these bytes ends with.
std::string why_refused(const std::filesystem::path& folder, const std::string& bytes) {
  std::ofstream(folder / "bad.ply", std::ios::binary) << bytes;
  try {
    read_ply(folder / "bad.ply");
  } catch (const Error& error) {
    return error.what();
  }
  return "not refused";
}

TEST(MeshIo, WritesTheDocumentedHeaderAndRecords) {
  const std::string bytes = bytes_of(one_triangle(), test::fresh_folder("mesh_io_header"));
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment PanopticFusion: metres, world axes of the recording\nelement vertex 3\n"
      "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property uint8 red\nproperty uint8 green\nproperty uint8 blue\nproperty uint16 class_id\nproperty int32 panoptic_id\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  ASSERT_EQ(bytes.substr(0, header.size()), header);
  ASSERT_EQ(bytes.size(), header.size() + 3 * kVertexBytes + kFaceBytes);
  const char* second = bytes.data() + header.size() + kVertexBytes;
  float y = 0;
  std::memcpy(&y, second + 4, sizeof(y));
  EXPECT_EQ(y, 1.25F);
  EXPECT_EQ(static_cast<std::uint8_t>(second[26]), 250);
  std::uint32_t panoptic_id = 0;
  std::memcpy(&panoptic_id, second + 29, sizeof(panoptic_id));
  EXPECT_EQ(panoptic_id, 4'000'000'001U);
  EXPECT_EQ(bytes.substr(bytes.size() - kFaceBytes), std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", kFaceBytes));
}

TEST(MeshIo, ReadsBackWhatItWrote) {
  const auto folder = test::fresh_folder("mesh_io_round_trip");
  const Mesh room = test::room(0.2F);
  write_ply(folder / "mesh.ply", room);
  const Mesh read = read_ply(folder / "mesh.ply");
  ASSERT_EQ(read.vertices.size(), room.vertices.size());
  EXPECT_EQ(read.triangles, room.triangles);
  for (std::size_t i = 0; i < room.vertices.size(); ++i) {
    ASSERT_EQ(read.vertices[i].position, room.vertices[i].position);
    ASSERT_EQ(read.vertices[i].normal, room.vertices[i].normal);
    ASSERT_EQ(read.vertices[i].color, room.vertices[i].color);
    ASSERT_EQ(read.vertices[i].class_id, room.vertices[i].class_id);
    ASSERT_EQ(read.vertices[i].panoptic_id, room.vertices[i].panoptic_id);
  }
}

// Ids had 16 bits once.
TEST(MeshIo, ReadsMeshesWithShortIds) {
  const auto folder = test::fresh_folder("mesh_io_short_ids");
  Mesh mesh = one_triangle();
  for (std::size_t i = 0; i < 3; ++i) mesh.vertices[i].panoptic_id = PanopticId{65'000 + static_cast<std::uint32_t>(i)};
  const std::string bytes = bytes_of(mesh, folder);
  const std::size_t records = bytes.find("end_header\n") + 11;
  std::string old =
      replaced(replaced(bytes.substr(0, records), "int32 panoptic_id", "ushort panoptic_id"), "uint8 red", "uchar red");
  for (std::size_t i = 0; i < 3; ++i) old += bytes.substr(records + i * kVertexBytes, kVertexBytes - 2);
  old += bytes.substr(records + 3 * kVertexBytes);
  std::ofstream(folder / "old.ply", std::ios::binary) << old;
  const Mesh read = read_ply(folder / "old.ply");
  EXPECT_EQ(read.triangles, mesh.triangles);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.vertices[i].position, mesh.vertices[i].position);
    EXPECT_EQ(read.vertices[i].panoptic_id, mesh.vertices[i].panoptic_id);
  }
  EXPECT_THAT(why_refused(folder, old + "xx"), HasSubstr("bytes follow the header"));
  EXPECT_THAT(why_refused(folder, replaced(bytes, "int32 panoptic_id", "float panoptic_id")),
              HasSubstr("line 15 is not 'property int32 panoptic_id'"));
}

TEST(MeshIo, ReadsIdsThatAreCalledUnsigned) {
  const auto folder = test::fresh_folder("mesh_io_unsigned");
  const Mesh mesh = one_triangle();
  const std::string bytes = bytes_of(mesh, folder);
  std::ofstream(folder / "old.ply", std::ios::binary) << replaced(bytes, "int32 panoptic_id", "uint panoptic_id");
  const Mesh read = read_ply(folder / "old.ply");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(read.vertices[i].panoptic_id, mesh.vertices[i].panoptic_id);
}

TEST(MeshIo, AnEmptyMeshIsAFileToo) {
  const auto folder = test::fresh_folder("mesh_io_empty");
  write_ply(folder / "mesh.ply", {});
  const Mesh read = read_ply(folder / "mesh.ply");
  EXPECT_TRUE(read.vertices.empty());
  EXPECT_TRUE(read.triangles.empty());
}

TEST(MeshIo, NamesTheFolderThatCannotBeWritten) {
  const auto folder = test::fresh_folder("mesh_io_unwritable") / "absent";
  try {
    write_ply(folder / "mesh.ply", one_triangle());
    FAIL() << "written into a folder that does not exist";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr((folder / "mesh.ply").string()));
  }
}

TEST(MeshIo, EveryTruncationIsRefused) {
  const auto folder = test::fresh_folder("mesh_io_truncated");
  const std::string bytes = bytes_of(one_triangle(), folder);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    ASSERT_THAT(why_refused(folder, bytes.substr(0, length)), HasSubstr("bad.ply")) << length;
  }
}

TEST(MeshIo, RefusesBytesAfterTheLastFace) {
  const auto folder = test::fresh_folder("mesh_io_longer");
  EXPECT_THAT(why_refused(folder, bytes_of(one_triangle(), folder) + "x"), HasSubstr("bytes follow the header"));
}

TEST(MeshIo, RefusesLyingCountsBeforeTakingMemory) {
  const auto folder = test::fresh_folder("mesh_io_counts");
  const std::string bytes = bytes_of(one_triangle(), folder);
  EXPECT_THAT(why_refused(folder, replaced(bytes, "vertex 3\n", "vertex 4000000000\n")), HasSubstr("4000000000 vertices"));
  for (const char* count : {"99999999999999999999", "18446744073709551615", "-1", "", "3 ", "0x3"}) {
    EXPECT_THAT(why_refused(folder, replaced(bytes, "vertex 3\n", "vertex " + std::string(count) + "\n")), HasSubstr("line 4"))
        << count;
  }
  EXPECT_THAT(why_refused(folder, replaced(bytes, "face 1\n", "face 1000000\n")), HasSubstr("1000000 faces"));
}

TEST(MeshIo, RefusesOtherLayoutsWithTheLine) {
  const auto folder = test::fresh_folder("mesh_io_layout");
  const std::string bytes = bytes_of(one_triangle(), folder);
  EXPECT_THAT(why_refused(folder, replaced(bytes, "binary_little_endian", "ascii")),
              AllOf(HasSubstr("bad.ply"), HasSubstr("line 2")));
  EXPECT_THAT(why_refused(folder, replaced(bytes, "float nx", "double nx")), HasSubstr("line 8 is not 'property float nx'"));
  EXPECT_THAT(why_refused(folder, std::string(1 << 20, '\n')), HasSubstr("line 1"));
  EXPECT_THAT(why_refused(folder, std::string(1 << 20, 'p')), HasSubstr("without end_header"));
  std::string comments = "ply\n";
  while (comments.size() < (1U << 16)) comments += "comment nothing\n";
  EXPECT_THAT(why_refused(folder, comments + bytes.substr(4)), HasSubstr("without end_header"));
}

TEST(MeshIo, RefusesFacesThatNameNoVertex) {
  const auto folder = test::fresh_folder("mesh_io_faces");
  std::string bytes = bytes_of(one_triangle(), folder);
  std::string out_of_range = bytes;
  out_of_range[bytes.size() - 4] = 3;
  EXPECT_THAT(why_refused(folder, out_of_range), HasSubstr("face 0 names vertex 3 of 3"));
  std::string negative = bytes;
  negative[bytes.size() - 1] = static_cast<char>(0xFF);
  EXPECT_THAT(why_refused(folder, negative), HasSubstr("face 0 names vertex"));
  std::string quad = bytes;
  quad[bytes.size() - kFaceBytes] = 4;
  EXPECT_THAT(why_refused(folder, quad), HasSubstr("face 0 has 4 corners"));
}

TEST(MeshIo, RefusesPositionsThatAreNotFinite) {
  const auto folder = test::fresh_folder("mesh_io_nan");
  Mesh mesh = one_triangle();
  mesh.vertices[1].position.z() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(why_refused(folder, bytes_of(mesh, folder)), HasSubstr("vertex 1 is not finite"));
}

}  // namespace
}  // namespace panoptic
