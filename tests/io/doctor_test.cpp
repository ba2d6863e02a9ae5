// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The doctor on the real recordings as they are, and with each of the mistakes that it is there to find.
#include "panoptic/io/doctor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <map>
#include <mutex>

#include "tests/fresh_folder.h"
#include "tests/io/recordings.h"
#include "tests/places.h"
#include "tests/shared_data.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;
using Corruption = std::function<void(Frame&)>;

// A recording whose frames are decoded once, however often they are read: that takes longer than to look at them.
class DecodedOnce : public Dataset {
 public:
  explicit DecodedOnce(std::unique_ptr<Dataset> original) : original_(std::move(original)) {}

  std::string description() const override { return original_->description(); }
  std::size_t size() const override { return original_->size(); }
  ReadResult read(std::size_t position) const override {
    {
      const std::lock_guard lock(mutex_);
      if (const auto at = decoded_.find(position); at != decoded_.end()) return at->second;
    }
    ReadResult result = original_->read(position);
    const std::lock_guard lock(mutex_);
    return decoded_.try_emplace(position, std::move(result)).first->second;
  }

 private:
  std::unique_ptr<Dataset> original_;
  mutable std::mutex mutex_;
  mutable std::map<std::size_t, ReadResult> decoded_;
};

// A dataset whose frames were tampered with.
class Corrupted : public Dataset {
 public:
  Corrupted(const Dataset& original, Corruption corruption) : original_(original), corruption_(std::move(corruption)) {}

  std::string description() const override { return original_.description(); }
  std::size_t size() const override { return original_.size(); }
  ReadResult read(std::size_t position) const override {
    ReadResult result = original_.read(position);
    if (result.frame) corruption_(*result.frame);
    return result;
  }

 private:
  const Dataset& original_;
  Corruption corruption_;
};

const Check& check_named(const DoctorReport& report, const std::string& name) {
  for (const Check& check : report.checks) {
    if (check.name == name) return check;
  }
  throw std::out_of_range(name);
}

Corruption scaled_depth(float factor) {
  return [factor](Frame& frame) {
    Image<float> depth = frame.depth.copied();
    for (std::size_t i = 0; i < depth.size(); ++i) depth[i] *= factor;
    frame.depth = std::move(depth);
  };
}

Corruption turned_axes(const Vec3d& signs) {
  return [signs](Frame& frame) { frame.world_from_camera.linear() = frame.world_from_camera.linear() * signs.asDiagonal(); };
}

void inverted_pose(Frame& frame) { frame.world_from_camera = frame.world_from_camera.inverse(); }

// Intrinsics of another image size, taken for those of this one.
Corruption intrinsics_of(int width, int height) {
  return [=](Frame& frame) {
    Camera camera = resized(frame.depth_camera, width, height);
    camera.width = frame.depth_camera.width;
    camera.height = frame.depth_camera.height;
    frame.depth_camera = camera;
  };
}

class DoctorOnRecording : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    PANOPTIC_REQUIRE_SHARED(std::filesystem::path("data") / GetParam());
    std::unique_ptr<DecodedOnce>& shared = decoded()[GetParam()];
    if (!shared) shared = std::make_unique<DecodedOnce>(open_recording(shared_folder() / "data" / GetParam()));
    dataset_ = shared.get();
  }
  static void TearDownTestSuite() { decoded().clear(); }  // some 100 frames of each recording

  // A smaller sample than usual, to be quick.
  DoctorReport diagnose_with(Corruption corruption) const {
    return diagnose(Corrupted(*dataset_, std::move(corruption)), {.frames = 20, .pairs = 12, .revisits = 0});
  }

  // Exactly this check fails, with this in its evidence or remedy.
  void expect_only(const DoctorReport& report, const std::string& name, const std::string& text) const {
    for (const Check& check : report.checks) {
      EXPECT_EQ(check.verdict >= Verdict::kFailed, check.name == name) << to_text(report);
    }
    EXPECT_THAT(check_named(report, name).evidence + check_named(report, name).remedy, HasSubstr(text));
    EXPECT_GE(report.worst(), Verdict::kFailed);
  }

  const Dataset* dataset_ = nullptr;

 private:
  static std::map<std::string, std::unique_ptr<DecodedOnce>>& decoded() {
    static std::map<std::string, std::unique_ptr<DecodedOnce>> all;
    return all;
  }
};

TEST_P(DoctorOnRecording, FindsNothingWrong) {
  const DoctorReport report = diagnose(*open_recording(shared_folder() / "data" / GetParam()));
  EXPECT_LE(report.worst(), Verdict::kAssumed) << to_text(report);
  EXPECT_GE(report.checks.size(), 8U);
}

TEST_P(DoctorOnRecording, FindsAWrongDepthScaleInEitherDirection) {
  expect_only(diagnose_with(scaled_depth(5)), "depth scale", "5000 instead of 1000");
  expect_only(diagnose_with(scaled_depth(0.2F)), "depth scale", "1000 instead of 5000");
  expect_only(diagnose_with(scaled_depth(6553.5F / 5000)), "depth scale", "6553.5 instead of 5000");
  expect_only(diagnose_with(scaled_depth(5000 / 6553.5F)), "depth scale", "5000 instead of 6553.5");
  expect_only(diagnose_with(scaled_depth(1000)), "depth scale", "1000 instead of 1");
}

TEST_P(DoctorOnRecording, FindsInvertedPoses) {
  expect_only(diagnose_with(inverted_pose), "poses", "inverse (camera from world)");
}

TEST_P(DoctorOnRecording, FindsFlippedAxes) {
  expect_only(diagnose_with(turned_axes({1, -1, -1})), "poses", "y and z flipped");
  expect_only(diagnose_with(turned_axes({-1, -1, 1})), "poses", "-x, -y, z");
}

TEST_P(DoctorOnRecording, FindsIntrinsicsOfAnotherImageSize) {
  const Camera camera = dataset_->read(0).frame->depth_camera;
  expect_only(diagnose_with(intrinsics_of(2 * camera.width, 2 * camera.height)), "depth intrinsics", "speak of images of about");
  expect_only(diagnose_with(intrinsics_of(camera.width / 2, camera.height / 2)), "depth intrinsics", "speak of images of about");
  expect_only(diagnose_with(intrinsics_of(1296, 968)), "depth intrinsics", "speak of images of about");
}

TEST_P(DoctorOnRecording, FindsAFocalLengthThatIsFarOff) {
  const DoctorReport report = diagnose_with([](Frame& frame) {
    frame.depth_camera.fx *= 2;
    frame.depth_camera.fy *= 2;
  });
  expect_only(report, "depth intrinsics", "focal lengths");
}

TEST_P(DoctorOnRecording, FindsTwoMistakesAtOnce) {
  const DoctorReport report = diagnose_with([](Frame& frame) {
    inverted_pose(frame);
    scaled_depth(5)(frame);
  });
  EXPECT_EQ(check_named(report, "poses").verdict, Verdict::kFailed) << to_text(report);
  EXPECT_EQ(check_named(report, "depth scale").verdict, Verdict::kFailed) << to_text(report);
}

TEST_P(DoctorOnRecording, FindsPosesThatBelongToOtherFrames) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < 20; ++i) poses.push_back(dataset_->read(i * dataset_->size() / 20).frame->world_from_camera);
  const DoctorReport report = diagnose_with(
      [&](Frame& frame) { frame.world_from_camera = poses[static_cast<std::size_t>(frame.index * 7919) % poses.size()]; });
  expect_only(report, "poses", "every pose belongs to its image");
}

// Poses that wander off by 20 cm over the recording, too slowly for any check of neighbouring frames.
TEST_P(DoctorOnRecording, FindsThatPosesDrift) {
  const DoctorOptions options{.frames = 20, .pairs = 12, .revisits = 40};
  const std::int64_t last = dataset_->read(dataset_->size() - 1).frame->index;
  const DoctorReport honest = diagnose(*dataset_, options);
  EXPECT_EQ(check_named(honest, "drift").verdict, Verdict::kOk) << to_text(honest);
  const DoctorReport report = diagnose(Corrupted(*dataset_,
                                                 [&](Frame& frame) {
                                                   const double share =
                                                       static_cast<double>(frame.index) / static_cast<double>(last);
                                                   frame.world_from_camera.translation() += share * Vec3d(0.12, 0.12, 0.12);
                                                 }),
                                       options);
  const Check& drift = check_named(report, "drift");
  EXPECT_EQ(drift.verdict, drift.evidence.starts_with("hardly") ? Verdict::kOk : Verdict::kWarning) << to_text(report);
  const bool is_told = std::string(GetParam()) == "kitchen";  // little of hololens is seen again
  EXPECT_EQ(drift.remedy.empty(), !is_told);
}

TEST_P(DoctorOnRecording, ReadsABoundedNumberOfFrames) {
  std::atomic<std::size_t> reads = 0;
  const DoctorReport report = diagnose_with([&](Frame&) { ++reads; });
  EXPECT_EQ(report.worst(), Verdict::kOk) << to_text(report);
  EXPECT_LE(reads, 20U + 8U * 12U);
  EXPECT_GE(reads, 20U + 2U * 12U);
  reads = 0;
  diagnose(Corrupted(*dataset_, [&](Frame&) { ++reads; }), {.frames = 1, .pairs = 0, .revisits = 9});
  EXPECT_LE(reads, 1U + 2U * 9U);
}

INSTANTIATE_TEST_SUITE_P(Real, DoctorOnRecording, ::testing::Values("kitchen", "hololens"),
                         [](const auto& param) { return std::string(param.param); });

TEST(Doctor, TheKitchenPassesWithItsCalibrationToo) {
  PANOPTIC_REQUIRE_SHARED("data/kitchen");
  const auto dataset = open_recording(shared_folder() / "data" / "kitchen", source_folder() / "configs/kitchen.toml");
  const DoctorReport report = diagnose(*dataset);
  EXPECT_EQ(report.worst(), Verdict::kOk) << to_text(report);
}

TEST(Doctor, ACalibrationFileForAnotherSizeIsFound) {
  PANOPTIC_REQUIRE_SHARED("data/kitchen");
  const std::filesystem::path file = fresh_folder("calibration") / "scannet.toml";
  write_text(file, "[depth]\nfx = 1170\nfy = 1170\ncx = 647.5\ncy = 483.5\n");
  const DoctorReport report = diagnose(*open_recording(shared_folder() / "data" / "kitchen", file), {.frames = 20, .pairs = 12});
  EXPECT_EQ(check_named(report, "depth intrinsics").verdict, Verdict::kImpossible);
  EXPECT_THAT(check_named(report, "depth intrinsics").remedy, HasSubstr("1295x967"));
}

TEST(Doctor, CountsDroppedFramesByReason) {
  const std::filesystem::path root = fresh_folder("scene");
  write_seven_scenes(root);
  std::filesystem::remove(root / "frame-000001.color.png");
  write_text(root / "frame-000002.pose.txt", "nan 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1");
  std::filesystem::resize_file(root / "frame-000003.depth.png", 50);
  const DoctorReport report = diagnose(*open_recording(root));
  const Check& frames = check_named(report, "frames");
  EXPECT_EQ(frames.verdict, Verdict::kFailed);
  EXPECT_THAT(frames.evidence, HasSubstr("4 of 4 frames looked at, 3 cannot be used"));
  EXPECT_THAT(frames.evidence, HasSubstr("1 x pose is not finite"));
  EXPECT_THAT(frames.evidence, HasSubstr("1 x colour image missing"));
  EXPECT_THAT(frames.evidence, HasSubstr("1 x depth image unreadable"));
}

TEST(Doctor, SaysWhenMotionIsTooLittleToTell) {
  const std::filesystem::path root = fresh_folder("scene");
  write_seven_scenes(root);
  for (int i = 0; i < kFrameCount; ++i) write_depth(root / ("frame-00000" + std::to_string(i) + ".depth.png"), raw_depth(0));
  const DoctorReport report = diagnose(*open_recording(root));
  EXPECT_EQ(check_named(report, "poses").verdict, Verdict::kWarning);
  EXPECT_THAT(check_named(report, "poses").evidence, HasSubstr("too little motion"));
}

TEST(Doctor, PrintsVerdictEvidenceAndRemedy) {
  const DoctorReport report{
      {{"frames", Verdict::kOk, "all good", ""}, {"poses", Verdict::kFailed, "27 % agree", "turn them round"}}};
  EXPECT_EQ(to_text(report),
            "ok       frames            all good\n"
            "FAILED   poses             27 % agree\n"
            "                           -> turn them round\n");
  EXPECT_EQ(report.worst(), Verdict::kFailed);
  EXPECT_EQ(DoctorReport{}.worst(), Verdict::kOk);
}

}  // namespace
}  // namespace panoptic::test
