// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/log_rows.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/query.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "panoptic/map_file.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapping/checkpoint.h"
#include "tests/block_planes.h"
#include "tests/expect_error.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using testing::HasSubstr;

// A map that was written when format 1 was made, of a simulated home. It must load for ever.
SavedMap map_of_format_1() { return load_map(test::source_folder() / "tests/golden/format_1.panoptic"); }

TEST(MapFormat, OneStillLoads) {
  const std::filesystem::path path = test::source_folder() / "tests/golden/format_1.panoptic";
  const SavedMap saved = map_of_format_1();
  EXPECT_EQ(fmt::format("{:016x}", saved.map.voxels.hash()), "3804add6b87c88aa");
  EXPECT_EQ(saved.map.voxels.block_count(), 18U);
  EXPECT_EQ(saved.map.labels.name(), "scannet20");
  EXPECT_TRUE(is_complete(saved));
  EXPECT_EQ(options_of(saved).map.voxel_size_m, 0.3F);
  const std::vector<FrameRecord> frames = load_frames(path);
  ASSERT_EQ(frames.size(), 12U);
  const MapperState state = mapper_state(saved, frames);
  EXPECT_EQ(state.frames.used(), 12U);
  EXPECT_EQ(state.maintenance.covisible.size(), 1496U / 8);
  EXPECT_EQ(state.regularizer.handled.size(), 18U);
}

TEST(MapFormat, OneHasNoSumOfVotesSoThatTheWeightIsTakenAndSaysSo) {
  const SavedMap saved = map_of_format_1();
  EXPECT_EQ(saved.format, 1);
  EXPECT_THAT(note_of_format(saved, "home.panoptic"), testing::AllOf(HasSubstr("home.panoptic has format 1"),
                                                                     HasSubstr("the sum of votes"), HasSubstr("map.max_weight")));
  EXPECT_EQ(saved.options.max_weight, 0) << "there was no limit";
  std::size_t voted = 0;
  for (Slot slot = 0; slot < saved.map.voxels.block_count(); ++slot) {
    const BlockPlanes block = test::planes_of(saved.map.voxels.block(slot));
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      const bool any = block.label[v] != 0 || block.label_weight[v] > 0;
      ASSERT_EQ(block.vote_sum[v], any ? std::max(block.weight[v], block.label_weight[v]) : 0.0F);
      voted += any ? 1 : 0;
    }
  }
  EXPECT_GT(voted, 1000U);
}

// A map like that one, saved after the regularizer overruled votes and objects were merged.
TEST(MapFormat, TwoStillLoads) {
  const std::filesystem::path path = test::source_folder() / "tests/golden/format_2.panoptic";
  const SavedMap saved = load_map(path);
  EXPECT_EQ(saved.format, 2);
  EXPECT_THAT(note_of_format(saved, path),
              testing::AllOf(HasSubstr("has format 2, which lacks free space"), testing::Not(HasSubstr("votes"))));
  EXPECT_TRUE(saved.map.free_space.empty());
  EXPECT_EQ(fmt::format("{:016x}", saved.map.voxels.hash()), "3cd43395a3f80480");
  EXPECT_EQ(saved.map.objects.count(), 23U);
  EXPECT_EQ(saved.map.objects.merged().size(), 8U);
  for (const MergedObject& merged : saved.map.objects.merged()) EXPECT_NE(saved.map.objects.survivor(merged.id), merged.id);
  EXPECT_EQ(saved.options.max_weight, 10000);
  const MapperState state = mapper_state(saved, load_frames(path));
  EXPECT_EQ(state.frames.used(), 40U);
  EXPECT_EQ(state.maintenance.covisible.size(), 4836U / 12);
  std::size_t votes = 0;
  for (const auto& of_block : state.regularizer.votes) votes += of_block.size();
  EXPECT_EQ(votes, (16582U - 24 * 2) / 14);
}

// Two blocks, a chair, and free space with doubts.
TEST(MapFormat, ThreeStillLoads) {
  const std::filesystem::path path = test::source_folder() / "tests/golden/format_3.panoptic";
  const SavedMap saved = load_map(path);
  EXPECT_EQ(saved.format, 3);
  EXPECT_THAT(note_of_format(saved, path), testing::AllOf(HasSubstr("has format 3, which lacks the log of its frames"),
                                                          testing::Not(HasSubstr("free space"))));
  EXPECT_TRUE(load_log(path).empty());
  EXPECT_EQ(fmt::format("{:016x}", saved.map.voxels.hash()), "1534b667120d56b2");
  EXPECT_EQ(saved.map.objects.count(), 1U);
  const FreeSpaceMap& space = saved.map.free_space;
  EXPECT_EQ(fmt::format("{:016x}", space.hash()), "628811454865b805");
  EXPECT_EQ(space.doubt_count(), 2U);
  EXPECT_EQ(space.frames_per_tick(), 2U);
  EXPECT_EQ(space.last_view()->time, 5005U);
  EXPECT_EQ(space.record(cell_of(BlockIndex{1, -1, 1}, 0)), (CellRecord{6, 5004, std::nullopt}));
  EXPECT_EQ(space.at(cell_of(BlockIndex{1, -1, 2}, 20)), Space::kOccupied);
}

// A map without history: of six frames of a simulated home, with their log.
TEST(MapFormat, FourStillLoads) {
  const std::filesystem::path path = test::source_folder() / "tests/golden/format_4.panoptic";
  const SavedMap saved = load_map(path);
  EXPECT_EQ(saved.format, 4);
  EXPECT_THAT(note_of_format(saved, path), HasSubstr("has format 4, which lacks what moved or is gone"));
  EXPECT_TRUE(saved.map.history.past.empty());
  EXPECT_EQ(fmt::format("{:016x}", saved.map.voxels.hash()), "b2bea32721726a0e");
  const FrameLog log(load_log(path), 0);
  ASSERT_EQ(log.size(), 6U);
  const std::vector<FrameRecord> frames = load_frames(path);
  for (std::size_t n = 0; n < log.size(); ++n) {
    EXPECT_EQ(log.entries()[n].frame, static_cast<std::int64_t>(n));
    EXPECT_TRUE(log.entries()[n].world_from_camera.isApprox(*frames[n].world_from_camera, 1e-12));
    const auto labels = log.labels(n);
    ASSERT_TRUE(labels.has_value());
    EXPECT_TRUE(labels->segmentation.segment_at.same_size(640, 480));
  }
  EXPECT_EQ(log.labels(0)->ids.size(), 10U);
}

class Query : public testing::Test {
 protected:
  SavedMap saved_ = map_of_format_1();
  MapQuery query_{saved_.map};
};

TEST_F(Query, FindsObjectsByClass) {
  const std::vector<FoundObject> chairs = query_.of_class("chair");
  ASSERT_EQ(chairs.size(), 2U);
  EXPECT_EQ(chairs[0].id, PanopticId{66});
  EXPECT_EQ(chairs[1].id, PanopticId{73});
  EXPECT_GT(chairs[0].probability, 0.2);
  EXPECT_EQ(query_.of_class("unknown").size(), 11U);
  EXPECT_THAT(test::error_of([&] { query_.of_class("dragon"); }), HasSubstr("its classes are wall, floor"));
}

TEST_F(Query, FindsObjectsByBox) {
  EXPECT_EQ(query_.objects().size(), 53U);
  const FoundObject bed = query_.of_class("bed").at(0);
  const auto has_bed = [&](const Vec3d& min_m, const Vec3d& max_m) {
    const std::vector<FoundObject> found = query_.in_box(min_m, max_m);
    return std::any_of(found.begin(), found.end(), [&](const FoundObject& o) { return o.id == bed.id; });
  };
  EXPECT_TRUE(has_bed(bed.box.center_m, bed.box.center_m));
  EXPECT_TRUE(has_bed(bed.box.max_m, bed.box.max_m + Vec3d::Ones()));
  EXPECT_FALSE(has_bed(bed.box.max_m + Vec3d(0.01, 0, 0), bed.box.max_m + Vec3d::Ones()));
  EXPECT_EQ(query_.in_box(Vec3d::Constant(-1e9), Vec3d::Constant(1e9)).size(), 53U);
}

// Every surface voxel of every object, one after the other.
double naive_distance(const SavedMap& saved, LabelSlot slot_of_object, const Vec3d& point_m) {
  double nearest = std::numeric_limits<double>::infinity();
  const double size = saved.map.voxels.voxel_size_m();
  for (Slot slot = 0; slot < saved.map.voxels.block_count(); ++slot) {
    const BlockPlanes block = test::planes_of(saved.map.voxels.block(slot));
    const BlockIndex b = saved.map.voxels.index_of(slot);
    for (int z = 0; z < 16; ++z) {
      for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
          const auto v = static_cast<std::size_t>(voxel_offset(x, y, z));
          if (block.weight[v] <= 0 || std::abs(block.distance[v]) > 1.5F * saved.map.voxels.voxel_size_m()) continue;
          if (block.label[v] != number(slot_of_object)) continue;
          const Vec3d place((16 * b.x + x + 0.5) * size, (16 * b.y + y + 0.5) * size, (16 * b.z + z + 0.5) * size);
          nearest = std::min(nearest, (place - point_m).norm());
        }
      }
    }
  }
  return nearest;
}

TEST_F(Query, FindsTheNearestObjects) {
  for (const Vec3d& point : {Vec3d(0, 0, 0), Vec3d(2, 1, 0.5), Vec3d(-3, 5, 1)}) {
    const std::vector<NearObject> near = query_.nearest(point, 100);
    ASSERT_EQ(near.size(), 53U);
    for (std::size_t i = 0; i < near.size(); ++i) {
      EXPECT_NEAR(near[i].distance_m, naive_distance(saved_, near[i].object.slot, point), 1e-9);
      if (i > 0) {
        EXPECT_LE(near[i - 1].distance_m, near[i].distance_m);
      }
    }
    EXPECT_EQ(query_.nearest(point, 3).size(), 3U);
  }
  EXPECT_TRUE(query_.nearest(Vec3d::Constant(std::numeric_limits<double>::quiet_NaN()), 3).empty());
}

TEST_F(Query, SaysWhatIsAtEveryVoxel) {
  const double size = saved_.map.voxels.voxel_size_m();
  std::size_t observed = 0;
  for (Slot slot = 0; slot < saved_.map.voxels.block_count(); ++slot) {
    const BlockIndex b = saved_.map.voxels.index_of(slot);
    for (int v = 0; v < kBlockVoxels; ++v) {
      const Vec3d voxel(16 * b.x + v % 16, 16 * b.y + v / 16 % 16, 16 * b.z + v / 256);
      const auto answer = query_.at((voxel + Vec3d(0.1, 0.5, 0.9)) * size);
      ASSERT_EQ(answer.has_value(), saved_.map.voxels.block(slot).weight(v) > 0);
      if (!answer) continue;
      ++observed;
      ASSERT_EQ(answer->distance_m, saved_.map.voxels.block(slot).distance(v));
      ASSERT_EQ(number(answer->id), saved_.map.voxels.block(slot).label(v));
      ASSERT_TRUE(answer->label_share >= 0 && answer->label_share <= 1);
    }
  }
  EXPECT_EQ(observed, 1475U);
  for (const double far : {1e9, -1e300, std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(query_.at(Vec3d(0, far, 0)).has_value());
  }
}

}  // namespace
}  // namespace panoptic
