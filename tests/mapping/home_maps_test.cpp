// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Merging and comparing maps of a simulated home.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "panoptic/map_pairs.h"
#include "panoptic/query.h"
#include "panoptic/sim/simulation.h"
#include "panoptic/surface.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/mapped.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using testing::HasSubstr;

constexpr int kFrames = 90;
const Camera kCamera{160, 120, 145, 145, 79.5, 59.5};

const Simulation& simulation() {
  static const Simulation kSimulation({.seed = 3, .rooms = 1, .frames = kFrames, .noise = "none"});
  return kSimulation;
}

// One room, filmed; things may be put elsewhere before, and the poses told in another world.
class FilmedHome {
 public:
  explicit FilmedHome(const Scene& scene, const Pose& world_from_home = Pose::Identity()) {
    const Renderer renderer(scene);
    for (int i = 0; i < kFrames; ++i) {
      views_.push_back(view(renderer, i));
      views_.back().frame.world_from_camera = world_from_home * views_.back().frame.world_from_camera;
    }
  }

  // Into `name`.panoptic in the test's folder.
  std::filesystem::path map(const std::string& name, int begin = 0, int end = kFrames) const {
    RunIdentity run{"home " + name, "", "", {}};
    run.options.map.voxel_size_m = 0.05F;
    run.options.depth.max_m = 6;
    const auto path = fresh_folder(name) / (name + ".panoptic");
    const auto view = [&](int i) { return views_[static_cast<std::size_t>(i)]; };
    test::map_views(view, begin, end, run, load_label_set("scannet20"), path);
    return path;
  }

 private:
  static test::LabelledView view(const Renderer& renderer, int i) {
    const Pose pose = simulation().true_path()[static_cast<std::size_t>(i)];
    Rendering r = renderer.render(kCamera, pose);
    Frame frame;
    frame.index = i;
    frame.time_s = i / 30.0;
    frame.depth_camera = frame.color_camera = kCamera;
    frame.world_from_camera = pose;
    frame.depth = std::move(r.depth);
    frame.color = std::move(r.color);
    return {std::move(frame), segmented(r)};
  }

  // The truth: a segment per thing and per class of stuff.
  static Segmentation segmented(const Rendering& r) {
    const LabelSet labels = load_label_set("scannet20");
    Segmentation s{Image<std::uint16_t>(kCamera.width, kCamera.height), {}};
    std::map<std::pair<ClassId, int>, std::uint16_t> segments;
    for (std::size_t i = 0; i < s.segment_at.size(); ++i) {
      if (r.class_id[i] == ClassId::kUnknown) continue;
      const int instance = labels.is_thing(r.class_id[i]) ? r.instance[i] : 0;
      const auto [at, is_new] =
          segments.try_emplace({r.class_id[i], instance}, static_cast<std::uint16_t>(s.segments.size() + 1));
      if (is_new) s.segments.push_back({r.class_id[i], 1.0F, {}});
      s.segment_at[i] = at->second;
    }
    return s;
  }

  std::vector<test::LabelledView> views_;
};

// Shared by both tests: as the home is, and all of it mapped.
const FilmedHome& home_as_it_is() {
  static const FilmedHome kHome(simulation().home().scene);
  return kHome;
}
const std::filesystem::path& whole_home_map() {
  static const std::filesystem::path kPath = home_as_it_is().map("whole");
  return kPath;
}

// Metres from each vertex of one mesh to the nearest of the other, by the median.
double median_distance_m(const Mesh& from, const Mesh& to) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < from.vertices.size(); i += 37) {
    double nearest = 1e9;
    for (const MeshVertex& v : to.vertices) nearest = std::min(nearest, double{(v.position - from.vertices[i].position).norm()});
    distances.push_back(nearest);
  }
  std::nth_element(distances.begin(), distances.begin() + distances.size() / 2, distances.end());
  return distances[distances.size() / 2];
}

std::size_t objects_with_surface(const SavedMap& saved) { return MapQuery(saved.map).objects().size(); }

TEST(HomeMaps, TwoHalvesMergedAreTheWhole) {
  const FilmedHome& home = home_as_it_is();
  const auto a = home.map("a", 0, 50);
  const auto b = home.map("b", 40, kFrames);
  const auto merged_path = fresh_folder("merged") / "merged.panoptic";
  const MergedFiles summary = merge_map_files(a, b, merged_path);
  const SavedMap whole = load_map(whole_home_map());
  const SavedMap merged = load_map(merged_path);
  const auto count = static_cast<double>(objects_with_surface(whole));
  EXPECT_NEAR(static_cast<double>(objects_with_surface(merged)), count, std::max(2.0, 0.15 * count));
  EXPECT_GT(summary.same, 0U);
  EXPECT_LT(summary.objects, summary.objects_a + summary.objects_b);
  const Mesh expected = surface_of(whole.map);
  const Mesh found = surface_of(merged.map);
  EXPECT_NEAR(static_cast<double>(found.vertices.size()), static_cast<double>(expected.vertices.size()),
              0.05 * static_cast<double>(expected.vertices.size()));
  EXPECT_LT(median_distance_m(expected, found), 0.005);
  EXPECT_LT(median_distance_m(found, expected), 0.005);

  EXPECT_TRUE(is_complete(merged));
  EXPECT_EQ(load_frames(merged_path).size(), 100U);
  EXPECT_THAT(test::error_of([&] { merge_map_files(a, b, merged_path); }), HasSubstr("is there already"));
  Mapper mapper({}, merged.map.labels);
  const RunIdentity run{merged.notes.texts.at("recording"), "", "", options_of(merged)};
  EXPECT_THAT(test::error_of([&] { Checkpoints({.path = merged_path, .resume = true}, run, mapper); }),
              HasSubstr("was merged from two maps"));
}

// The home after its bookshelf was taken away and a chair moved to where nothing stands.
struct ChangedHome {
  Scene scene = simulation().home().scene;
  Vec3d shelf_was = Vec3d::Zero();
  double chair_moved_m = 0;
};

ChangedHome changed_home() {
  ChangedHome home;
  std::vector<SceneObject>& objects = home.scene.objects;
  const auto named = [&](const char* name) {
    return std::find_if(objects.begin(), objects.end(), [&](const SceneObject& o) { return o.name == name; });
  };
  const auto chair = named("Chair");
  const Vec3d chair_was = chair->world_from_object.translation();
  chair->world_from_object.translation().head<2>() = simulation().true_path()[60].translation().head<2>();
  home.chair_moved_m = (chair->world_from_object.translation() - chair_was).norm();
  const auto shelf = named("Bookshelf");
  home.shelf_was = shelf->world_from_object.translation();
  objects.erase(shelf);
  return home;
}

void expect_the_changes(const ChangedHome& home, const MapDiff& diff, const LabelSet& labels) {
  ASSERT_EQ(diff.changes.size(), 2U);
  const ObjectChange& gone = diff.changes[0];
  EXPECT_EQ(gone.kind, ChangeKind::kVanished);
  EXPECT_EQ(labels.name_of(gone.before->class_id), "bookshelf");
  EXPECT_LT((gone.before->box.center_m - home.shelf_was).head<2>().norm(), 0.3);
  const ObjectChange& moved = diff.changes[1];
  EXPECT_EQ(moved.kind, ChangeKind::kMoved);
  EXPECT_EQ(labels.name_of(moved.before->class_id), "chair");
  EXPECT_NEAR(moved.moved_m, home.chair_moved_m, 0.25);
  EXPECT_GT(diff.unchanged, 30U);
}

TEST(HomeMaps, WhatWasTakenAwayAndWhatWasMovedIsFound) {
  const ChangedHome home = changed_home();
  const MapWithFrames a = load_map_with_frames(whole_home_map());
  const MapWithFrames b = load_map_with_frames(FilmedHome(home.scene).map("b"));
  expect_the_changes(home, diff_maps(a, b, "A", "B"), a.saved.map.labels);
}

Pose other_world() {
  Pose pose = Pose::Identity();
  pose.linear() =
      (Eigen::AngleAxisd(2.4, Vec3d::UnitZ()) * Eigen::AngleAxisd(0.1, Vec3d(1, 0.3, 0).normalized())).toRotationMatrix();
  pose.translation() = Vec3d(7, -3, 1);
  return pose;
}

TEST(HomeMaps, InAnotherWorldTheSameChangesAreFound) {
  const ChangedHome home = changed_home();
  const MapWithFrames a = load_map_with_frames(whole_home_map());
  const MapWithFrames b = load_map_with_frames(FilmedHome(home.scene, other_world()).map("elsewhere"));
  const MapAlignment alignment = align_maps(a, b, "A", "B");
  const Pose error = alignment.a_from_b * other_world();
  const Vec3d middle = simulation().true_path()[0].translation();
  EXPECT_LT((error * middle - middle).norm(), 0.01);
  EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 0.004);
  EXPECT_GT(alignment.objects, 20U);
  expect_the_changes(home, diff_maps(a, moved_map(b, alignment.a_from_b), "A", "B"), a.saved.map.labels);
}

TEST(HomeMaps, HalvesInDifferentWorldsBecomeOneMap) {
  const auto a = home_as_it_is().map("first_half", 0, 50);
  const auto b = FilmedHome(simulation().home().scene, other_world()).map("second_half", 40, kFrames);
  const auto path = fresh_folder("aligned") / "merged.panoptic";
  const MergedFiles summary = merge_map_files(a, b, path, true);
  ASSERT_TRUE(summary.alignment.has_value());
  const SavedMap whole = load_map(whole_home_map());
  const SavedMap merged = load_map(path);
  const auto count = static_cast<double>(objects_with_surface(whole));
  EXPECT_NEAR(static_cast<double>(objects_with_surface(merged)), count, std::max(2.0, 0.15 * count));
  EXPECT_LT(median_distance_m(surface_of(whole.map), surface_of(merged.map)), 0.01);
  EXPECT_LT(median_distance_m(surface_of(merged.map), surface_of(whole.map)), 0.01);
}

TEST(HomeMaps, OfTwoHomesCannotBeAligned) {
  const Simulation other({.seed = 8, .rooms = 1, .frames = kFrames, .noise = "none"});
  const MapWithFrames a = load_map_with_frames(whole_home_map());
  const MapWithFrames b = load_map_with_frames(FilmedHome(other.home().scene).map("other_home"));
  EXPECT_THAT(test::error_of([&] { align_maps(a, b, "A", "B"); }), HasSubstr("B cannot be aligned with A: "));
}

TEST(HomeMaps, WithoutFreeSpaceNothingWouldSpeakAgainstAWrongAlignment) {
  MapWithFrames a = load_map_with_frames(whole_home_map());
  const MapWithFrames b = load_map_with_frames(whole_home_map());
  a.saved.map.free_space = FreeSpaceMap(a.saved.map.voxels.voxel_size_m());
  EXPECT_THAT(test::error_of([&] { align_maps(a, b, "A", "B"); }), HasSubstr("A has no free space"));
}

TEST(HomeMaps, AMapIsNotMovedFartherThanMapsReach) {
  const MapWithFrames map = load_map_with_frames(whole_home_map());
  for (const double x : {1e9, std::nan("")}) {
    EXPECT_THAT(test::error_of([&] { moved_map(map, Pose(Eigen::Translation3d(x, 0, 0))); }),
                HasSubstr("farther from the origin"));
  }
}

// Cells of the moved map are free only where those of the old one are.
void expect_the_space_of(const MapWithFrames& map, const Pose& new_from_old, const MapWithFrames& moved) {
  std::size_t before = 0;
  map.saved.map.free_space.for_each([&](const CellIndex&, Space space) { before += space == Space::kFree ? 1 : 0; });
  std::size_t after = 0;
  std::size_t wrong = 0;
  const FreeSpaceMap& old = map.saved.map.free_space;
  moved.saved.map.free_space.for_each([&](const CellIndex& cell, Space space) {
    if (space != Space::kFree) return;
    ++after;
    const Vec3d middle = (Vec3d(cell[0], cell[1], cell[2]) + Vec3d::Constant(0.5)) * old.cell_size_m();
    const auto at = old.cell_around(new_from_old.inverse() * middle);
    wrong += at && old.at(*at) == Space::kFree ? 0 : 1;
  });
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(after, before / 10);  // cells are 20 cm wide here: a layer of them is most of a room's
  EXPECT_LE(after, before + before / 20);
}

TEST(HomeMaps, MovedAnyhowItHasTheSameSurfaceSpaceAndPoses) {
  const MapWithFrames map = load_map_with_frames(whole_home_map());
  const MapWithFrames moved = moved_map(map, other_world());
  Mesh back = surface_of(moved.saved.map);
  for (MeshVertex& v : back.vertices) v.position = (other_world().inverse() * v.position.cast<double>()).cast<float>();
  constexpr double kHalfAVoxel_m = 0.025;  // from vertex to vertex, which lie elsewhere on the same surface
  EXPECT_LT(median_distance_m(surface_of(map.saved.map), back), kHalfAVoxel_m);
  EXPECT_LT(median_distance_m(back, surface_of(map.saved.map)), kHalfAVoxel_m);
  expect_the_space_of(map, other_world(), moved);
  const Pose first = *moved.frames.front().world_from_camera;
  EXPECT_TRUE(first.isApprox(other_world() * *map.frames.front().world_from_camera));
}

TEST(HomeMaps, MovedByABlockAndBackIsTheSame) {
  const MapWithFrames map = load_map_with_frames(whole_home_map());
  Pose by_a_block = Pose::Identity();
  by_a_block.translation() = double{map.saved.map.voxels.block_size_m()} * Vec3d(1, -2, 0);
  const MapWithFrames there = moved_map(map, by_a_block);
  EXPECT_NE(there.saved.map.voxels.hash(), map.saved.map.voxels.hash());
  const MapWithFrames back = moved_map(there, by_a_block.inverse());
  const VoxelMap& before = map.saved.map.voxels;
  EXPECT_EQ(back.saved.map.voxels.observed_voxels(), before.observed_voxels());
  std::size_t differing = 0;
  for (Slot slot = 0; slot < before.block_count(); ++slot) {
    const VoxelBlock* after = back.saved.map.voxels.find(before.index_of(slot));
    for (int offset = 0; offset < kBlockVoxels; ++offset) {
      const Voxel was = before.block(slot).at(offset);
      if (!(was.weight > 0)) continue;
      const Voxel is = after == nullptr ? Voxel{} : after->at(offset);
      const bool alike = std::abs(is.distance - was.distance) < 1e-6F && is.label == was.label && is.red == was.red;
      differing += alike ? 0 : 1;
    }
  }
  EXPECT_EQ(differing, 0U);
  EXPECT_EQ(there.frames.size(), map.frames.size());
}

}  // namespace
}  // namespace panoptic
