// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Plans of a map that grows: its snapshots tell planning what its voxels do, and the server gives the newest plan.
#include "apps/viewer/live_plan.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <tuple>

#include "apps/viewer/live_map.h"
#include "panoptic/planning/surface_samples.h"
#include "panoptic/profile.h"
#include "tests/viewer/server_fixture.h"

namespace panoptic {
namespace {

using test::HttpAnswer;
using testing::HasSubstr;

// By place, since both hold each edge of voxels once.
std::vector<SurfaceSample> in_order(const SurfaceByBlock& surface) {
  std::vector<SurfaceSample> all;
  for (const auto& block : surface) all.insert(all.end(), block.begin(), block.end());
  const auto place = [](const SurfaceSample& s) { return std::tuple(s.at_m.x(), s.at_m.y(), s.at_m.z()); };
  std::ranges::sort(all, {}, place);
  return all;
}

// Where the voxels end there are edges that belong to no whole cell, and so to no triangle.
TEST(LiveMap, HasTheSurfaceOfTheVoxelsWithItsLabelsAndWeights) {
  test::SmallWorld world;
  const LiveMap live = live_map(*world.snapshot(), world.scene());
  const std::vector<SurfaceSample> wanted = in_order(surface_samples(world.map().voxels));
  const std::vector<SurfaceSample> found = in_order(live.surface);
  ASSERT_GT(found.size(), 2000U);
  EXPECT_GT(found.size(), 0.95 * static_cast<double>(wanted.size()));
  std::size_t at = 0;
  for (const SurfaceSample& s : found) {
    while (at < wanted.size() && wanted[at].at_m != s.at_m) ++at;
    ASSERT_LT(at, wanted.size()) << s.at_m.transpose();
    ASSERT_EQ(live.map.objects.id_of(s.label), world.map().objects.id_of(wanted[at].label));
    ASSERT_EQ(s.weight, wanted[at].weight);
    ASSERT_GT(s.normal.dot(wanted[at].normal), 0.9F);
  }
  EXPECT_EQ(live.map.class_of(test::kBallId), ClassId{2});
}

class ServedLivePlan : public test::Served {
 protected:
  ServedLivePlan() {
    server_ = std::make_unique<ViewerServer>(ViewerOptions{.port = 0}, world_.scene(), latest_, PlaySource::of_growing_map());
    port_ = test::port_of(*server_);
  }
  // plan.json as soon as it no longer is of `revision`: plans are made once a second.
  Json plan_after(const Json& revision) {
    const Stopwatch since;
    Json plan = json("/api/play/plan.json");
    while (plan["revision"] == revision && since.seconds() < 120) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      plan = json("/api/play/plan.json");
    }
    return plan;
  }
};

TEST_F(ServedLivePlan, GivesTheNewestPlanByItsRevisionAndTheOneBefore) {
  EXPECT_EQ(json("/api/scene")["grows"], true);
  const Stopwatch since;
  const Json first = json("/api/play/plan.json");
  EXPECT_EQ(first["revision"], 1);
  EXPECT_EQ(first["why_not"], "");
  latest_.publish(world_.snapshot());
  const Json second = plan_after(1);
  EXPECT_GE(since.seconds(), 0.9) << "planned again within a second";
  EXPECT_EQ(second["revision"], 2);
  EXPECT_EQ(second["looked_at"], 2);
  for (const char* revision : {"1", "2"}) {
    EXPECT_FALSE(get(std::string("/api/play/navmesh.bin?r=") + revision).body.empty());
    EXPECT_TRUE(json(std::string("/api/play/affordances.json?r=") + revision).contains("world_from_grid"));
  }
  for (const char* query : {"?r=3", "?r=0", "?r=x", ""}) {
    const HttpAnswer answer = get(std::string("/api/play/navmesh.bin") + query);
    EXPECT_EQ(answer.status, 404) << query;
    EXPECT_THAT(answer.body, HasSubstr("plan.json names the newest")) << query;
  }
}

TEST_F(ServedLivePlan, SaysWhyThereIsNoneYetAndKeepsThePlanThatThereWas) {
  latest_.publish(std::make_shared<const Snapshot>());
  EXPECT_THAT(json("/api/play/plan.json")["why_not"].get<std::string>(), HasSubstr("nothing is mapped yet"));
  auto empty = world_.snapshot();
  for (SnapshotChunk& chunk : empty->chunks) chunk.surface = std::make_shared<const MeshChunk>();
  latest_.publish(empty);
  const Json none = json("/api/play/plan.json");
  EXPECT_EQ(none["revision"], 0);
  EXPECT_EQ(none["looked_at"], empty->revision);
  EXPECT_THAT(none["why_not"].get<std::string>(), HasSubstr("no surface"));
  auto last = world_.snapshot();
  last->run.finished = true;
  latest_.publish(last);
  const Json done = plan_after(0);
  EXPECT_EQ(done["revision"], last->revision);
  EXPECT_EQ(done["finished"], true);
  EXPECT_EQ(get("/api/play/frames.json").status, 404);
  EXPECT_THAT(get("/api/play/frames.json").body, HasSubstr("need a map file"));
}

}  // namespace
}  // namespace panoptic
