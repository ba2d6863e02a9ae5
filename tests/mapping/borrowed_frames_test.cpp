// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Frames whose images lie in a caller's memory.
#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "panoptic/mapper.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/mapping_run.h"
#include "panoptic/online.h"
#include "panoptic/voxel_map.h"
#include "tests/base/foreign_memory.h"
#include "tests/mapping/online_fixture.h"

namespace panoptic {
namespace {

using test::ForeignMemory;
using test::OnlineRun;
using test::orbit_frame;
using test::RowOrder;
using test::segmented;

constexpr int kFrames = 12;

struct Layout {
  std::size_t depth_gap_bytes = 0;
  std::size_t color_gap_bytes = 0;
  RowOrder order = RowOrder::kTopFirst;
};

// The images of a frame in a caller's memory.
struct LentFrame {
  LentFrame(const Frame& frame, const Layout& layout)
      : depth(frame.depth, layout.depth_gap_bytes, layout.order), color(frame.color, layout.color_gap_bytes, layout.order) {}

  Frame borrowed(Frame frame, const std::shared_ptr<const void>& owner = nullptr) const {
    frame.depth = SharedImage<float>(depth.view(), owner);
    frame.color = SharedImage<Rgb>(color.view(), owner);
    return frame;
  }

  ForeignMemory<float> depth;
  ForeignMemory<Rgb> color;
};

// A colour camera of its own, a hand's breadth beside the other and larger.
Frame two_camera_frame(int i) {
  Frame frame = orbit_frame(i);
  frame.color_camera = {100, 70, 75, 75, 49.5, 34.5};
  frame.color_from_depth.translation() = Vec3d(0.1, 0.01, 0);
  Image<Rgb> color(100, 70);
  for (std::size_t k = 0; k < color.size(); ++k) {
    color[k] = {static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(k >> 4), static_cast<std::uint8_t>(i)};
  }
  frame.color = std::move(color);
  return frame;
}

// One segment for the left half, the same whatever the size.
Segmentation left_half(const Frame& frame) {
  Segmentation s{Image<std::uint16_t>(frame.color.width(), frame.color.height()), {{ClassId{3}, 0.9F, {{ClassId{3}, 1.0F}}}}};
  for (int v = 0; v < frame.color.height(); ++v) std::fill_n(s.segment_at.row(v), frame.color.width() / 2, std::uint16_t{1});
  return s;
}

TEST(BorrowedFrames, StagesUpToTheIntegratorReadThePixelsOfTheCaller) {
  const Frame owned = orbit_frame(0);
  const LentFrame memory(owned, {.depth_gap_bytes = 8, .color_gap_bytes = 5});
  int looked = 0;
  const auto look = [&](const FrameToLabel& seen) {
    EXPECT_EQ(seen.frame.depth.row(0), memory.depth.view().row(0));
    EXPECT_EQ(seen.frame.color.row(0), memory.color.view().row(0));
    ++looked;
  };
  std::vector<LabelSlot> labels;
  std::vector<LabelSlot> ids;
  std::vector<std::uint32_t> areas_px;
  ReplacedStages stages;
  stages.associate = [&](const FrameToLabel& seen, PanopticMap&) {
    look(seen);
    labels.assign(seen.registered.segment.size(), LabelSlot::kNoVote);
    ids.assign(seen.segmentation.segments.size(), LabelSlot::kNoVote);
    areas_px.assign(ids.size(), 0);
    return Association{labels, ids, areas_px};
  };
  stages.labelled = [&](const FrameToLabel& seen, std::span<const LabelSlot>) { look(seen); };
  MapperParts mapper(test::coarse(), test::test_labels(), stages);
  const Frame borrowed = memory.borrowed(owned);
  ASSERT_TRUE(mapper.add(borrowed, segmented(owned)).used);
  EXPECT_EQ(looked, 2) << "before and after the integrator";
}

TEST(BorrowedFrames, GiveTheMapOfOwnedOnesThoughTheirMemoryIsGoneAfterEachCall) {
  for (const bool one_camera : {true, false}) {
    const auto frame_at = [&](int i) { return one_camera ? orbit_frame(i) : two_camera_frame(i); };
    Mapper owning(test::coarse(), test::test_labels());
    for (int i = 0; i < kFrames; ++i) ASSERT_TRUE(owning.add(frame_at(i), left_half(frame_at(i))).used);
    owning.finish();
    for (const Layout& layout : {Layout{}, Layout{4, 0}, Layout{0, 1}, Layout{64, 48}, Layout{8, 7, RowOrder::kTopLast}}) {
      Mapper borrowing(test::coarse(), test::test_labels());
      for (int i = 0; i < kFrames; ++i) {
        const Frame frame = frame_at(i);
        const auto memory = std::make_unique<const LentFrame>(frame, layout);
        ASSERT_TRUE(borrowing.add(memory->borrowed(frame), left_half(frame)).used);
      }
      borrowing.finish();
      EXPECT_EQ(borrowing.map().voxels.hash(), owning.map().voxels.hash())
          << one_camera << ' ' << layout.depth_gap_bytes << ' ' << layout.color_gap_bytes;
    }
  }
}

// With the frames that `give` makes of the orbit's.
std::uint64_t online_hash(const std::function<Frame(int)>& give) {
  OnlineRun run;
  for (int i = 0; i < kFrames; ++i) EXPECT_TRUE(run.pipeline.push_when_free(give(i)));
  EXPECT_EQ(run.pipeline.finish().used, std::uint64_t{kFrames});
  return run.mapper.map().voxels.hash();
}

TEST(BorrowedFrames, WithoutAnOwnerAreCopiedWhenTheyAreHandedToAnOnlineRun) {
  std::unique_ptr<const LentFrame> memory;
  const std::uint64_t hash = online_hash([&](int i) {
    const Frame frame = orbit_frame(i);
    memory = std::make_unique<const LentFrame>(frame, Layout{4, 1});  // the one before is gone
    return memory->borrowed(frame);
  });
  EXPECT_EQ(hash, online_hash(orbit_frame));
}

// Notes where the pixels lie that it is given.
class Addresses final : public Predictor {
 public:
  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override {
    const std::lock_guard lock(mutex_);
    seen_.insert(frame.color.row(0));
    return segmented(frame);
  }
  std::set<const void*> seen() {
    const std::lock_guard lock(mutex_);
    return seen_;
  }

 private:
  LabelSet labels_ = test::test_labels();
  std::mutex mutex_;
  std::set<const void*> seen_;
};

TEST(BorrowedFrames, WithAnOwnerAreReadInPlaceByAnOnlineRunAndLetGoAfterIt) {
  Addresses predictor;
  std::set<const void*> lent;
  std::vector<std::weak_ptr<const void>> owners;
  {
    OnlineRun run(&predictor);
    for (int i = 0; i < kFrames; ++i) {
      const Frame frame = orbit_frame(i);
      const auto memory = std::make_shared<const LentFrame>(frame, Layout{4, 1});
      lent.insert(memory->color.view().row(0));
      owners.emplace_back(memory);
      ASSERT_TRUE(run.pipeline.push_when_free(memory->borrowed(frame, memory)));
    }
    EXPECT_EQ(run.pipeline.finish().used, std::uint64_t{kFrames});
    EXPECT_EQ(*run.latest.newest()->frame.color, orbit_frame(kFrames - 1).color) << "a snapshot keeps what it shows";
  }
  ASSERT_FALSE(predictor.seen().empty());
  for (const void* address : predictor.seen()) EXPECT_TRUE(lent.contains(address));
  for (const auto& owner : owners) EXPECT_TRUE(owner.expired());
}

// A recording in memory: its frames borrow from it.
class InMemory final : public Dataset {
 public:
  InMemory() {
    for (int i = 0; i < kFrames; ++i) memory_.push_back(std::make_unique<const LentFrame>(orbit_frame(i), Layout{4, 1}));
  }
  std::string description() const override { return "in memory"; }
  std::size_t size() const override { return memory_.size(); }
  ReadResult read(std::size_t position) const override {
    return {memory_[position]->borrowed(orbit_frame(static_cast<int>(position))), {}};
  }

 private:
  std::vector<std::unique_ptr<const LentFrame>> memory_;
};

TEST(BorrowedFrames, ASnapshotOutlivesTheRecordingThatLentThem) {
  LatestSnapshot latest;
  Mapper mapper(test::coarse(), test::test_labels());
  {
    const InMemory dataset;
    LoopPublisher publisher(mapper, latest, dataset.size());
    ASSERT_EQ(map_offline({.dataset = dataset, .range = {}, .mapper = mapper}, &publisher).failure, "");
  }
  EXPECT_EQ(mapper.frames().used(), std::uint64_t{kFrames});
  EXPECT_EQ(*latest.newest()->frame.color, orbit_frame(kFrames - 1).color);
}

}  // namespace
}  // namespace panoptic
