// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/integrator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>

#include "panoptic/map/block_key.h"
#include "panoptic/meshing/mesher.h"
#include "panoptic/parallel.h"
#include "tests/block_planes.h"
#include "tests/fusion/naive_fusion.h"
#include "tests/fusion/naive_grazing.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

using test::look_at;

constexpr float kVoxel_m = 0.024F;
constexpr float kBand_m = 4 * kVoxel_m;

// A ball of 60 cm radius on a floor, seen from all around.
std::vector<Frame> orbit(int frames) {
  const test::Surface scene = test::nearest_of({test::sphere({0, 0, 0}, 0.6), test::plane(Vec3d::UnitY(), 0.6)});
  std::vector<Frame> result;
  for (int i = 0; i < frames; ++i) {
    const double angle = 6.283 * i / frames;
    result.push_back(
        test::render(scene, test::small_camera(), look_at({2 * std::cos(angle), -0.9, 2 * std::sin(angle)}, {0, 0, 0}), i));
  }
  return result;
}

std::vector<LabelSlot> labels_of(const RegisteredFrame& frame) {
  std::vector<LabelSlot> labels;
  for (const std::uint16_t s : frame.segment)
    labels.push_back(s == RegisteredFrame::kNoSegment ? LabelSlot::kNoVote : static_cast<LabelSlot>(s * 2));
  return labels;
}

VoxelMap fuse_frames(const std::vector<Frame>& frames, const std::string& method) {
  VoxelMap map({kVoxel_m, 4});
  Integrator integrator({method}, map);
  Registration registration({});
  for (const Frame& frame : frames) {
    const RegisteredFrame& registered = registration.apply(frame, test::halves(frame.color_camera));
    const auto labels = labels_of(registered);
    integrator.integrate(frame, registered, labels, map);
  }
  return map;
}

Vec3d voxel_center(BlockIndex b, int i) {
  return (Vec3d(b.x, b.y, b.z) * 16 + Vec3d(i % 16 + 0.5, i / 16 % 16 + 0.5, i / 256 + 0.5)) * double{kVoxel_m};
}

// The signed distance and weight of one observation, as the paper and voxblox define them, in double.
double naive_weight(double z, double distance) {
  const double quadric = 1 / (z * z);
  if (distance >= -kVoxel_m) return quadric;
  return quadric * std::max(0.0, (kBand_m + distance) / (kBand_m - kVoxel_m));
}

struct NaiveVoxel {
  double distance = 0, weight = 0, label_weight = 0, vote_sum = 0;
  std::uint16_t label = 0;
  std::array<double, 3> rgb{};
  bool colored = false;

  // Eq. 6-7 and 9-11; the mean of Eq. 6 for colours too.
  void observe(double d, double w, LabelSlot id, std::uint32_t color) {
    for (std::size_t c = 0; c < 3 && color != 0; ++c) {
      const double value = color >> (16 - 8 * c) & 0xFF;
      rgb[c] = colored ? (weight * rgb[c] + w * value) / (weight + w) : value;
    }
    colored |= color != 0;
    distance = (weight * distance + w * d) / (weight + w);
    weight += w;
    if (id == LabelSlot::kNoVote) return;
    vote_sum += w;
    if (number(id) == label) {
      label_weight += w;
    } else if (w > label_weight) {
      label = number(id);
      label_weight = w - label_weight;
    } else {
      label_weight -= w;
    }
  }
};

// Eq. 6-11 for every voxel of a block, by projecting its centre.
void observe_naively(const Frame& frame, const RegisteredFrame& registered, const std::vector<LabelSlot>& labels, BlockIndex b,
                     std::vector<NaiveVoxel>& voxels) {
  const KernelFrame pixels = test::depths_of(frame, registered);
  const Pose camera_from_world = frame.world_from_camera.inverse();
  for (int i = 0; i < kBlockVoxels; ++i) {
    const Vec3d p = camera_from_world * voxel_center(b, i);
    const double u = std::floor(frame.depth_camera.fx * p.x() / p.z() + frame.depth_camera.cx + 0.5);
    const double v = std::floor(frame.depth_camera.fy * p.y() / p.z() + frame.depth_camera.cy + 0.5);
    if (p.z() <= 0 || u < 0 || v < 0 || u >= registered.width || v >= registered.height) continue;
    const auto pixel = static_cast<std::size_t>(v * registered.width + u);
    const double z = registered.depth[pixel];
    if (z <= 0) continue;
    const double scale =
        test::naive_scale(pixels, {kBand_m, kVoxel_m}, double{kVoxel_m}, static_cast<int>(u), static_cast<int>(v));
    const double d = (z - p.z()) * p.norm() / p.z() * scale;
    if (std::abs(d) >= kBand_m) continue;
    const double share = frame.depth_weight.empty() ? 1 : frame.depth_weight(static_cast<int>(u), static_cast<int>(v));
    voxels[static_cast<std::size_t>(i)].observe(d, naive_weight(z, d) * share, labels[pixel], registered.color[pixel]);
  }
}

// The frames, with another weight for each reading from one pixel to the next, and none where nothing was read.
std::vector<Frame> weighed(std::vector<Frame> frames) {
  for (Frame& frame : frames) {
    Image<float> weight(frame.depth.width(), frame.depth.height());
    for (std::size_t i = 0; i < weight.size(); ++i) {
      const bool is_reading = frame.depth[i] > 0;
      const float none = i % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : std::numeric_limits<float>::infinity();
      weight[i] = is_reading ? 1.0F / static_cast<float>(1 + i % 5) : none;
    }
    frame.depth_weight = std::move(weight);
  }
  return frames;
}

void expect_projective_is_naive(const std::vector<Frame>& frames) {
  VoxelMap map({kVoxel_m, 4});
  Integrator integrator({}, map);
  Registration registration({});
  std::vector<std::vector<NaiveVoxel>> naive;
  for (const Frame& frame : frames) {
    const RegisteredFrame& registered = registration.apply(frame, test::halves(frame.color_camera));
    const auto labels = labels_of(registered);
    integrator.integrate(frame, registered, labels, map);
    naive.resize(map.block_count(), std::vector<NaiveVoxel>(kBlockVoxels));
    for (Slot slot = 0; slot < map.block_count(); ++slot) {
      if (map.changed_at(slot) == map.epoch()) observe_naively(frame, registered, labels, map.index_of(slot), naive[slot]);
    }
  }
  std::size_t observed = 0;
  std::size_t different = 0;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    const BlockPlanes block = test::planes_of(map.block(slot));
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      const NaiveVoxel& expected = naive[slot][i];
      observed += expected.weight > 0 ? 1 : 0;
      const bool same =
          std::abs(block.distance[i] - expected.distance) < 1e-4 && std::abs(block.weight[i] - expected.weight) < 1e-4 &&
          std::abs(block.vote_sum[i] - expected.vote_sum) < 1e-4 && block.label[i] == expected.label &&
          std::abs(block.label_weight[i] - expected.label_weight) < 1e-4 &&
          std::abs(block.red[i] / 256.0 - expected.rgb[0]) < 0.05 && std::abs(block.green[i] / 256.0 - expected.rgb[1]) < 0.05 &&
          std::abs(block.blue[i] / 256.0 - expected.rgb[2]) < 0.05;
      different += same ? 0 : 1;
    }
  }
  EXPECT_GT(observed, 50000U);
  EXPECT_LE(different, observed / 2000) << "of " << observed;  // float and double may round to neighbouring pixels
}

TEST(Integrator, ProjectiveEqualsTheNaiveReferenceVoxelByVoxel) { expect_projective_is_naive(orbit(6)); }
TEST(Integrator, ProjectiveEqualsTheNaiveReferenceWithAWeightForEachReading) { expect_projective_is_naive(weighed(orbit(6))); }

TEST(Integrator, WeightsOfOneChangeNoBit) {
  for (const char* method : {"projective", "raycast"}) {
    std::vector<Frame> frames = orbit(2);
    const std::uint64_t hash = fuse_frames(frames, method).hash();
    for (Frame& frame : frames) frame.depth_weight = Image<float>(frame.depth.width(), frame.depth.height(), 1);
    EXPECT_EQ(fuse_frames(frames, method).hash(), hash) << method;
    EXPECT_NE(fuse_frames(weighed(frames), method).hash(), hash) << method;
  }
}

TEST(Integrator, TheBlocksItTouchesHoldNearlyAllVoxelsOfTheNaiveReference) {
  const Frame frame = orbit(1)[0];
  Registration registration({});
  const RegisteredFrame& registered = registration.apply(frame, {});
  const std::vector<LabelSlot> labels(registered.depth.size(), LabelSlot::kNoVote);
  VoxelMap map({kVoxel_m, 4});
  Integrator({}, map).integrate(frame, registered, labels, map);
  std::size_t inside = 0;
  std::size_t missed = 0;
  for (int x = -12; x < 12; ++x) {
    for (int y = -12; y < 12; ++y) {
      for (int z = -12; z < 12; ++z) {
        std::vector<NaiveVoxel> voxels(kBlockVoxels);
        observe_naively(frame, registered, labels, {x, y, z}, voxels);
        const auto seen = std::count_if(voxels.begin(), voxels.end(), [](const NaiveVoxel& v) { return v.weight > 0; });
        (map.find({x, y, z}) != nullptr ? inside : missed) += static_cast<std::size_t>(seen);
      }
    }
  }
  EXPECT_GT(inside, 20000U);
  EXPECT_LE(missed, inside / 100) << "of " << inside;
}

void expect_raycast_is_naive(const std::vector<Frame>& frames) {
  const VoxelMap map = fuse_frames(frames, "raycast");
  std::map<std::uint64_t, std::vector<Voxel>> naive;
  Registration registration({});
  for (const Frame& frame : frames) {
    const RegisteredFrame& registered = registration.apply(frame, test::halves(frame.color_camera));
    const auto labels = labels_of(registered);
    const Eigen::Matrix3f rotation = frame.world_from_camera.linear().cast<float>();
    const Vec3f origin = (frame.world_from_camera.translation() / double{kVoxel_m}).cast<float>();
    for (int pixel = 0; pixel < registered.width * registered.height; ++pixel) {
      const float z = registered.depth[static_cast<std::size_t>(pixel)];
      if (z <= 0) continue;
      const float share = frame.depth_weight.empty() ? 1 : frame.depth_weight[static_cast<std::size_t>(pixel)];
      const Camera& c = frame.depth_camera;
      const Vec3f ray = rotation * Vec3f(static_cast<float>((pixel % c.width - c.cx) / c.fx),
                                         static_cast<float>((pixel / c.width - c.cy) / c.fy), 1);
      const Vec3f to_surface = ray * (z / kVoxel_m);
      const float range = to_surface.norm();
      const Vec3f direction = to_surface / range;
      const Vec3f surface = origin + to_surface;
      const Vec3f half = direction * (map.truncation_m() / kVoxel_m);
      test::walk_cells(surface - half, surface + half, [&](int x, int y, int k) {
        const Vec3f center = Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(k)) + Vec3f::Constant(0.5F);
        const float d = std::clamp((range - direction.dot(center - origin)) * kVoxel_m, -map.truncation_m(), map.truncation_m());
        const float w = observation_weight(z, d, {map.truncation_m(), kVoxel_m}) * share;
        if (w <= 0) return;
        std::vector<Voxel>& block = naive[pack({x >> 4, y >> 4, k >> 4})];
        block.resize(kBlockVoxels);
        test::fuse_voxel(block[static_cast<std::size_t>(voxel_offset(x & 15, y & 15, k & 15))],
                         {d, w, registered.color[static_cast<std::size_t>(pixel)], labels[static_cast<std::size_t>(pixel)]},
                         LabelVotes{}, map.max_weight());
      });
    }
  }
  ASSERT_GT(naive.size(), 20U);
  for (const auto& [key, block] : naive) {
    const VoxelBlock* actual = map.find(unpack(key));
    ASSERT_NE(actual, nullptr);
    for (int v = 0; v < kBlockVoxels; ++v) {
      const Voxel a = actual->at(v);
      const Voxel& b = block[static_cast<std::size_t>(v)];
      ASSERT_EQ(std::tuple(a.distance, a.weight, a.label, a.label_weight, a.vote_sum, a.red, a.green, a.blue),
                std::tuple(b.distance, b.weight, b.label, b.label_weight, b.vote_sum, b.red, b.green, b.blue));
    }
  }
}

TEST(Integrator, RaycastEqualsTheNaiveLoopOverPixelsBitForBit) {
  expect_raycast_is_naive(orbit(3));
  expect_raycast_is_naive(weighed(orbit(3)));
}

// Distance of a point to the ball or floor of orbit().
double distance_to_surface(const Vec3d& p) { return std::min(std::abs(p.norm() - 0.6), std::abs(0.6 - p.y())); }

struct SurfaceError {
  double mean_m = 0;
  std::map<std::array<int, 3>, PanopticId> label_at;  // by voxel
};

SurfaceError surface_error(VoxelMap voxels) {
  LabelSet labels = test::test_labels();
  ObjectRegistry objects(labels.first_thing());
  const PanopticMap map(std::move(labels), std::move(voxels), std::move(objects));
  Mesher mesher({});
  mesher.update(map);
  const Mesh mesh = mesher.assemble(map);
  SurfaceError result;
  for (const MeshVertex& v : mesh.vertices) {
    result.mean_m += distance_to_surface(v.position.cast<double>()) / static_cast<double>(mesh.vertices.size());
    const Vec3f cell = v.position / kVoxel_m;
    result.label_at[{static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y())),
                     static_cast<int>(std::floor(cell.z()))}] = v.panoptic_id;
  }
  return result;
}

// Labels that are the same from every side: the ball is 3, the floor 5.
std::vector<LabelSlot> labels_by_surface(const Frame& frame) {
  std::vector<LabelSlot> labels(frame.depth.size() + 1, LabelSlot::kNoVote);
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
      labels[static_cast<std::size_t>(v) * frame.depth.width() + u] = p.y() > 0.599 ? LabelSlot{5} : LabelSlot{3};
    }
  }
  return labels;
}

TEST(Integrator, BothMethodsFindTheSurfaceAndAgreeOnLabels) {
  SurfaceError errors[2];
  for (const std::size_t method : {0U, 1U}) {
    VoxelMap map({kVoxel_m, 4});
    Integrator integrator({method == 0 ? "projective" : "raycast"}, map);
    Registration registration({});
    for (const Frame& frame : orbit(12)) {
      const RegisteredFrame& registered = registration.apply(frame, {});
      integrator.integrate(frame, registered, labels_by_surface(frame), map);
    }
    errors[method] = surface_error(std::move(map));
    EXPECT_LT(errors[method].mean_m, kVoxel_m / 3) << "method " << method;
  }
  int compared = 0;
  int same = 0;
  for (const auto& [voxel, label] : errors[0].label_at) {
    const auto other = errors[1].label_at.find(voxel);
    if (other == errors[1].label_at.end()) continue;
    compared++;
    same += other->second == label ? 1 : 0;
  }
  ASSERT_GT(compared, 5000);
  EXPECT_GT(same, compared * 97 / 100) << "of " << compared;
}

// The promise of the whole project: the same frames give the same map, bit for bit. If a deliberate change of the arithmetic
// moves these numbers, say so in the changelog.
constexpr std::uint64_t kGoldenProjective = 7124610607236522960ULL;
constexpr std::uint64_t kGoldenRaycast = 17506956839138180593ULL;

TEST(Integrator, MapHashIsGoldenAtAnyThreadCount) {
  const std::vector<Frame> frames = orbit(8);
  for (const int threads : {1, 2, 4, 5}) {
    set_thread_count(threads);
    EXPECT_EQ(fuse_frames(frames, "projective").hash(), kGoldenProjective) << threads << " threads";
    EXPECT_EQ(fuse_frames(frames, "raycast").hash(), kGoldenRaycast) << threads << " threads";
  }
  set_thread_count(0);
}

TEST(Integrator, LabelRuleIsTheWeightedMajorityVote) {
  // Eq. 9-11 on one voxel: agree, disagree, flip, and the weight never turns negative.
  VoxelLabel v{0, 0};
  v = fused_label(v, 7, 2);
  EXPECT_EQ(v.label, 7);
  EXPECT_FLOAT_EQ(v.weight, 2);
  v = fused_label(v, 7, 1);
  EXPECT_FLOAT_EQ(v.weight, 3);
  v = fused_label(v, 9, 2.5F);
  EXPECT_EQ(v.label, 7);
  EXPECT_FLOAT_EQ(v.weight, 0.5F);
  v = fused_label(v, 9, 0.5F);  // w_t > W is strict: no flip on a tie
  EXPECT_EQ(v.label, 7);
  EXPECT_FLOAT_EQ(v.weight, 0);
  v = fused_label(v, 9, 1);
  EXPECT_EQ(v.label, 9);
  EXPECT_FLOAT_EQ(v.weight, 1);
}

TEST(Integrator, ColourMeansKeepMovingAfterHundredsOfFrames) {
  std::int32_t c = fused_color(0, 0, 100, 1);
  EXPECT_EQ(c, 100 * 256);
  for (int i = 1; i < 500; ++i) c = fused_color(c, static_cast<float>(i), 100, 1);
  for (int i = 500; i < 1000; ++i) c = fused_color(c, static_cast<float>(i), 110, 1);
  EXPECT_NEAR(c / 256.0, 105, 0.3);
  EXPECT_GT(fused_color(0, 0, 0, 1), 0) << "black is a colour; 0 means none yet";
}

TEST(Integrator, PixelsWithoutAVoteLeaveLabelsAlone) {
  std::vector<Frame> frames = orbit(1);
  VoxelMap map({kVoxel_m, 4});
  Integrator integrator({}, map);
  Registration registration({});
  const RegisteredFrame& registered = registration.apply(frames[0], {});
  integrator.integrate(frames[0], registered, std::vector<LabelSlot>(registered.depth.size(), LabelSlot::kNoVote), map);
  ASSERT_GT(map.block_count(), 0U);
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    for (const float w : test::planes_of(map.block(slot)).label_weight) ASSERT_EQ(w, 0);
    for (const float w : test::planes_of(map.block(slot)).vote_sum) ASSERT_EQ(w, 0);
  }
}

TEST(Integrator, DepthBeyondTheGridIsLeftOut) {
  for (const char* method : {"projective", "raycast"}) {
    std::vector<Frame> frames = orbit(1);
    frames[0].world_from_camera.translation() = Vec3d(1e9, -1e9, 1e9);
    EXPECT_EQ(fuse_frames(frames, method).block_count(), 0U) << method;
  }
}

}  // namespace
}  // namespace panoptic
