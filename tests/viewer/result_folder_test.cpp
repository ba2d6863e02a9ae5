// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/result_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "apps/viewer/surface.h"
#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/outputs.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/io/run_json.h"
#include "tests/viewer/small_world.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using test::SmallWorld;
using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

// The mesh as a set of triangles, each by the positions and labels of its corners.
std::multiset<std::string> triangles_of(const Mesh& mesh) {
  std::multiset<std::string> all;
  for (const auto& t : mesh.triangles) {
    std::string text;
    for (const std::uint32_t corner : t) {
      const MeshVertex& v = mesh.vertices[corner];
      text.append(reinterpret_cast<const char*>(v.position.data()), 12);
      text += std::to_string(number(v.panoptic_id));
    }
    all.insert(std::move(text));
  }
  return all;
}

class ResultFolder : public testing::Test {
 protected:
  // A result as `panoptic run` leaves it, as far as the viewer reads it.
  ResultFolder() : folder_(fresh_folder("kitchen")) {
    mesh_ = SnapshotSurface(world_.snapshot()).assemble(test::small_labels());
    write_ply(folder_ / "mesh.ply", mesh_);
    report_["options"]["map"]["voxel_size_m"] = world_.map().voxels.voxel_size_m();
    write();
  }
  void write() const {
    write_json_file(folder_ / "report.json", report_);
    write_json_file(folder_ / "objects.json", objects_);
  }
  std::string refusal() const {
    return error_of([&] { (void)open_result(folder_); });
  }

  SmallWorld world_;
  fs::path folder_;
  Mesh mesh_;
  Json report_ = test::report_json();
  Json objects_ = {{"objects", {test::object_json(3, "swivel chair")}}};
};

TEST_F(ResultFolder, OpensAsTheRunSawIt) {
  const OpenedResult result = open_result(folder_);
  EXPECT_EQ(result.scene.title, "kitchen");
  EXPECT_EQ(result.scene.dataset, "made for a test");
  EXPECT_FALSE(result.scene.has_confidence);
  EXPECT_EQ(result.scene.labels.find(ClassId{2})->color, (Rgb{31, 119, 180}));
  EXPECT_FLOAT_EQ(result.scene.block_size_m, world_.map().voxels.block_size_m());
  const Snapshot& s = *result.snapshot;
  EXPECT_EQ(s.revision, 1U);
  EXPECT_EQ(s.up, Vec3f(0, 1, 0));
  EXPECT_EQ(s.frame.index, -1);
  EXPECT_TRUE(s.run.finished);
  EXPECT_EQ(s.run.frames_done, 42U);
  EXPECT_EQ(s.run.frames_labelled, 36U);
  EXPECT_EQ(s.run.stages.at("fusion").p95_ms, 5);
  ASSERT_EQ(s.objects.size(), 1U);
  EXPECT_EQ(s.objects[0].probabilities, (std::vector<ClassProbability>{{ClassId{1}, 0.25F}, {ClassId{2}, 0.75F}}));
  EXPECT_EQ(s.objects[0].max_m, Vec3f(1, 2, 3));
  EXPECT_TRUE(triangles_of(SnapshotSurface(result.snapshot).assemble(result.scene.labels)) == triangles_of(mesh_));
}

TEST_F(ResultFolder, AMeshIsCutAtTheBordersOfItsBlocks) {
  const auto chunks = cut_into_chunks(mesh_, double{world_.map().voxels.voxel_size_m()});
  std::size_t with_surface = 0;
  const auto snapshot = world_.snapshot();
  for (const SnapshotChunk& chunk : snapshot->chunks) with_surface += chunk.surface->triangles.empty() ? 0 : 1;
  EXPECT_EQ(chunks.size(), with_surface) << "the very blocks that the mesher made them of";
  const double block_m = double{world_.map().voxels.block_size_m()};
  for (const SnapshotChunk& chunk : chunks) {
    const Slot slot = world_.map().voxels.find_slot(chunk.index);
    ASSERT_NE(slot, VoxelMap::kNoSlot);
    // Slivers on the very border may go either way.
    EXPECT_NEAR(static_cast<double>(chunk.surface->triangles.size()),
                static_cast<double>(world_.mesher().chunks()[slot]->triangles.size()), 5);
    const Vec3d low = Vec3d(chunk.index.x, chunk.index.y, chunk.index.z) * block_m;
    for (const ChunkVertex& v : chunk.surface->vertices) {
      EXPECT_NEAR(v.area_normal.norm(), 1, 1e-5);
      EXPECT_TRUE(((v.position.cast<double>() - low).array() >= 0).all());
      EXPECT_TRUE(((v.position.cast<double>() - low).array() < 2 * block_m).all());
    }
  }
}

TEST_F(ResultFolder, ItsTrajectoryIsThePathOfTheCamera) {
  write_file(folder_ / "trajectory.txt", "# time x y z qx qy qz qw\n0.5 1 2 3 0 0 0 1\n\n1.5 4 5 6 0 0 0 1\n");
  EXPECT_EQ(open_result(folder_).snapshot->path_m, (std::vector<Vec3f>{Vec3f(1, 2, 3), Vec3f(4, 5, 6)}));
  std::string longer;
  for (int i = 0; i < 50000; ++i) longer += "0 " + std::to_string(i) + " 0 0 0 0 0 1\n";
  write_file(folder_ / "trajectory.txt", longer);
  const auto path = open_result(folder_).snapshot->path_m;
  EXPECT_LE(path.size(), kMaxPathPoints);
  EXPECT_GT(path.size(), kMaxPathPoints / 2);
  EXPECT_EQ(path[1], Vec3f(3, 0, 0));
}

TEST_F(ResultFolder, IsShownWithoutItsPastIfThatCannotBeRead) {
  write_file(folder_ / "moving.json", "{");
  const OpenedResult result = open_result(folder_);
  EXPECT_THAT(result.note, AllOf(HasSubstr("the past is not shown"), HasSubstr("moving.json")));
  EXPECT_FALSE(result.snapshot->chunks.empty());
}

TEST_F(ResultFolder, OtherFoldersAreRefusedInOneLine) {
  EXPECT_THAT(error_of([&] { (void)open_result(folder_ / "absent"); }), AllOf(HasSubstr("absent"), HasSubstr("panoptic run")));
  fs::remove(folder_ / "mesh.ply");
  EXPECT_THAT(refusal(), HasSubstr("mesh.ply"));
  write_file(folder_ / "mesh.ply", "ply\n");
  EXPECT_THAT(refusal(), HasSubstr("mesh.ply"));
  fs::remove(folder_ / "objects.json");
  EXPECT_THAT(refusal(), HasSubstr("objects.json"));
  write_file(folder_ / "report.json", "{");
  EXPECT_THAT(refusal(), HasSubstr("report.json"));
}

TEST_F(ResultFolder, AProbabilityOfNoClassIsRefused) {
  objects_["objects"][0]["probabilities"]["spaceship"] = 0.5;
  write();
  EXPECT_THAT(refusal(), AllOf(HasSubstr("objects.json"), HasSubstr("spaceship")));
}

TEST_F(ResultFolder, AMeshThatDoesNotFitItsVoxelsIsRefused) {
  report_["options"]["map"]["voxel_size_m"] = 0.0001;
  write();
  EXPECT_THAT(refusal(), AllOf(HasSubstr("mesh.ply"), HasSubstr("triangle 0")));
  Mesh far;
  far.vertices.resize(3);
  for (MeshVertex& v : far.vertices) v.position = Vec3f(1e9F, 0, 0);
  far.triangles = {{0, 1, 2}};
  EXPECT_THAT(error_of([&] { (void)cut_into_chunks(far, 0.024); }), HasSubstr("triangle 0"));
  EXPECT_TRUE(cut_into_chunks({}, 0.024).empty());
}

}  // namespace
}  // namespace panoptic
