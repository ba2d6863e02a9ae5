// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/encode.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "panoptic/objects.h"
#include "tests/viewer/decoded.h"
#include "tests/viewer/small_world.h"

namespace panoptic {
namespace {

using test::decoded;
using test::DecodedChunk;
using test::DecodedVertex;
using test::SmallWorld;

// Every chunk of a snapshot, as a browser gets it.
std::vector<DecodedChunk> all_decoded(const SnapshotSurface& surface, float block_size_m) {
  std::vector<std::shared_ptr<const std::string>> bytes;
  for (std::size_t i = 0; i < surface.snapshot().chunks.size(); ++i) {
    bytes.push_back(std::make_shared<const std::string>(encode_chunk(surface, i, block_size_m)));
  }
  return decoded(join_chunks(bytes));
}

Vec3d position_of(const DecodedVertex& v, BlockIndex block, double block_size_m) {
  return (Vec3d(block.x, block.y, block.z) + Vec3d(v.steps[0], v.steps[1], v.steps[2]) / 32768.0) * block_size_m;
}

// Where on the one grid through the world, in whole steps.
std::array<std::int64_t, 3> grid_place(const DecodedVertex& v, BlockIndex block) {
  return {v.steps[0] + std::int64_t{block.x} * 32768, v.steps[1] + std::int64_t{block.y} * 32768,
          v.steps[2] + std::int64_t{block.z} * 32768};
}

class Encode : public testing::Test {
 protected:
  SmallWorld world_;
  SnapshotSurface surface_{world_.snapshot()};
  float block_size_m_ = world_.map().voxels.block_size_m();
};

TEST_F(Encode, TrianglesComeBackWithinAStepOfThePositions) {
  const auto chunks = all_decoded(surface_, block_size_m_);
  std::size_t compared = 0;
  for (std::size_t c = 0; c < chunks.size(); ++c) {
    const MeshChunk& original = *surface_.snapshot().chunks[c].surface;
    ASSERT_EQ(chunks[c].triangles.size(), original.triangles.size());
    ASSERT_EQ(chunks[c].vertices.size(), original.vertices.size());
    // The encoder may reorder both; triangles are told apart by where their corners are.
    std::multiset<std::array<std::int64_t, 9>> sent;
    std::multiset<std::array<std::int64_t, 9>> expected;
    const double step_m = double{block_size_m_} / 32768;
    const auto add = [](auto& set, std::array<std::array<std::int64_t, 3>, 3> t) {
      std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());  // which corner is first is not kept
      set.insert({t[0][0], t[0][1], t[0][2], t[1][0], t[1][1], t[1][2], t[2][0], t[2][1], t[2][2]});
    };
    for (const auto& t : chunks[c].triangles) {
      const auto place = [&](int k) {
        return grid_place(chunks[c].vertices.at(t[static_cast<std::size_t>(k)]), chunks[c].block);
      };
      add(sent, {place(0), place(1), place(2)});
    }
    for (const auto& t : original.triangles) {
      const auto place = [&](int k) -> std::array<std::int64_t, 3> {
        const Vec3d p = original.vertices[t[static_cast<std::size_t>(k)]].position.cast<double>() / step_m;
        return {std::llround(p.x()), std::llround(p.y()), std::llround(p.z())};
      };
      add(expected, {place(0), place(1), place(2)});
    }
    EXPECT_TRUE(sent == expected);
    compared += sent.size();
  }
  EXPECT_GT(compared, 1000U);
}

TEST_F(Encode, EveryVertexKeepsItsLabelColourConfidenceAndNormal) {
  const double half_step_m = double{block_size_m_} / 32768 / 2;
  for (std::size_t c = 0; c < surface_.snapshot().chunks.size(); ++c) {
    const auto chunk =
        decoded(join_chunks(std::vector{std::make_shared<const std::string>(encode_chunk(surface_, c, block_size_m_))}))[0];
    const MeshChunk& original = *surface_.snapshot().chunks[c].surface;
    const std::vector<Vec3f> normals = surface_.normals(c);
    for (const DecodedVertex& v : chunk.vertices) {
      const Vec3d p = position_of(v, chunk.block, double{block_size_m_});
      const auto nearest =
          std::min_element(original.vertices.begin(), original.vertices.end(), [&](const auto& a, const auto& b) {
            return (a.position.template cast<double>() - p).squaredNorm() <
                   (b.position.template cast<double>() - p).squaredNorm();
          });
      EXPECT_LE((nearest->position.cast<double>() - p).cwiseAbs().maxCoeff(), half_step_m * 1.01);
      EXPECT_EQ(chunk.ids.at(v.id), nearest->panoptic_id);
      EXPECT_EQ(v.confidence, nearest->confidence);
      EXPECT_EQ((Rgb{v.color[0], v.color[1], v.color[2]}), nearest->color);
      EXPECT_EQ(v.zero, 0);
      const Vec3f& normal = normals[static_cast<std::size_t>(nearest - original.vertices.begin())];
      for (int a = 0; a < 3; ++a) EXPECT_NEAR(v.normal[static_cast<std::size_t>(a)], normal[a] * 127, 0.51);
    }
  }
}

TEST_F(Encode, ChunksMeetWithoutCracksAndWithoutSeamsInTheirNormals) {
  std::map<std::array<std::int64_t, 3>, std::pair<std::array<std::int8_t, 3>, std::set<std::size_t>>> places;
  const auto chunks = all_decoded(surface_, block_size_m_);
  for (std::size_t c = 0; c < chunks.size(); ++c) {
    for (const DecodedVertex& v : chunks[c].vertices) {
      auto& [normal, owners] =
          places.try_emplace(grid_place(v, chunks[c].block), v.normal, std::set<std::size_t>{}).first->second;
      owners.insert(c);
      EXPECT_EQ(normal, v.normal);
    }
  }
  const auto shared = std::count_if(places.begin(), places.end(), [](const auto& p) { return p.second.second.size() > 1; });
  EXPECT_GT(shared, 100);
  // There are as many places as the one mesh with shared vertices has: no border vertex moved away from its twin.
  const Mesh whole = world_.mesher().assemble(world_.map());
  EXPECT_EQ(places.size(), whole.vertices.size());
}

TEST_F(Encode, TheAssembledSurfaceIsTheMeshersOwn) {
  const Mesh ours = surface_.assemble(test::small_labels());
  const Mesh reference = world_.mesher().assemble(world_.map());
  ASSERT_EQ(ours.vertices.size(), reference.vertices.size());
  EXPECT_TRUE(ours.triangles == reference.triangles);
  for (std::size_t i = 0; i < ours.vertices.size(); ++i) {
    EXPECT_EQ(ours.vertices[i].position, reference.vertices[i].position);
    EXPECT_LT((ours.vertices[i].normal - reference.vertices[i].normal).norm(), 1e-5F);
    EXPECT_EQ(ours.vertices[i].panoptic_id, reference.vertices[i].panoptic_id);
    const ClassId expected = ours.vertices[i].panoptic_id == test::kBallId ? ClassId{2} : reference.vertices[i].class_id;
    EXPECT_EQ(ours.vertices[i].class_id, expected) << "the class of the ball is the snapshot's";
  }
}

TEST_F(Encode, AChunkIsNewWhereverANeighbourIs) {
  const std::size_t middle = surface_.find({0, 0, 0});
  ASSERT_NE(middle, SnapshotSurface::kNoChunk);
  world_.replace(middle, std::make_shared<const MeshChunk>());
  const SnapshotSurface next(world_.snapshot());
  for (std::size_t c = 0; c < next.snapshot().chunks.size(); ++c) {
    const BlockIndex b = next.snapshot().chunks[c].index;
    const bool near = std::abs(b.x) <= 1 && std::abs(b.y) <= 1 && std::abs(b.z) <= 1;
    EXPECT_EQ(next.version(c), near ? 2U : 1U) << b.x << " " << b.y << " " << b.z;
  }
}

TEST_F(Encode, AnEmptyChunkHasNoBytes) {
  world_.replace(0, std::make_shared<const MeshChunk>());
  const SnapshotSurface next(world_.snapshot());
  const std::string bytes = encode_chunk(next, 0, block_size_m_);
  EXPECT_EQ(bytes.size(), 40U);
  EXPECT_TRUE(decoded(join_chunks(std::vector{std::make_shared<const std::string>(bytes)}))[0].triangles.empty());
}

TEST_F(Encode, TheCacheEncodesEachVersionOnceAndKeepsToItsBound) {
  std::size_t all = 0;
  std::size_t largest = 0;
  ChunkCache roomy(block_size_m_, 1U << 30);
  for (int round = 0; round < 3; ++round) {
    for (std::size_t c = 0; c < surface_.snapshot().chunks.size(); ++c) {
      const std::size_t size = roomy.encoded(surface_, c)->size();
      if (round == 0) all += size;
      largest = std::max(largest, size);
    }
  }
  EXPECT_EQ(roomy.encodings(), surface_.snapshot().chunks.size());
  EXPECT_EQ(roomy.bytes(), all);
  ChunkCache narrow(block_size_m_, all / 2);
  for (std::size_t c = 0; c < surface_.snapshot().chunks.size(); ++c) {
    EXPECT_EQ(*narrow.encoded(surface_, c), *roomy.encoded(surface_, c));
    EXPECT_LE(narrow.bytes(), all / 2);
  }
  EXPECT_GT(narrow.bytes(), all / 2 - largest);
  roomy.clear();
  EXPECT_EQ(roomy.bytes(), 0U);
}

TEST_F(Encode, ANewVersionTakesThePlaceOfTheOldOneInTheCache) {
  ChunkCache cache(block_size_m_, 1U << 30);
  const std::size_t middle = surface_.find({0, 0, 0});
  const auto old_bytes = cache.encoded(surface_, middle);
  world_.replace(middle, std::make_shared<const MeshChunk>());
  const SnapshotSurface next(world_.snapshot());
  EXPECT_EQ(cache.encoded(next, middle)->size(), 40U);
  EXPECT_EQ(cache.bytes(), 40U);
  EXPECT_GT(old_bytes->size(), 40U) << "who holds it may go on reading";
}

}  // namespace
}  // namespace panoptic
