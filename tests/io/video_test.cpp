// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/video.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "panoptic/base/files.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/io/recordings.h"
#include "tests/io/small_video.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr std::size_t kImages = 27;
constexpr ImageSize kSize{94, 66};  // no multiple of what encoders and converters work in

std::uint8_t level_of(std::size_t i) { return static_cast<std::uint8_t>(20 + 8 * i); }

// Patterns that differ everywhere, or one grey for each.
std::vector<Image<Rgb>> images_of(const VideoKind& kind) {
  std::vector<Image<Rgb>> images;
  for (std::size_t i = 0; i < kImages; ++i) {
    Image<Rgb> image(kSize.width, kSize.height, {level_of(i), level_of(i), level_of(i)});
    for (int v = 0; v < kSize.height && kind.codec == "libx264rgb"; ++v) {
      for (int u = 0; u < kSize.width; ++u) {
        const auto mixed = static_cast<std::uint32_t>(u * 7919 + v * 104729) * 2654435761U;
        image(u, v) = {static_cast<std::uint8_t>(mixed >> 24), level_of(i), static_cast<std::uint8_t>(u + v)};
      }
    }
    images.push_back(std::move(image));
  }
  return images;
}

// A video of the wanted kind; skips the test where there is none.
#define PANOPTIC_REQUIRE_VIDEO(path, kind)                                            \
  if (!reads_videos()) GTEST_SKIP() << "this build reads no videos (PANOPTIC_VIDEO)"; \
  if (!write_video(path, images_of(kind), kind)) GTEST_SKIP() << "this FFmpeg has no encoder " << (kind).codec

class VideoKinds : public ::testing::TestWithParam<VideoKind> {};
INSTANTIATE_TEST_SUITE_P(All, VideoKinds,
                         ::testing::Values(VideoKind{"libx264rgb", 8, 3}, VideoKind{"libx264rgb", 1, 0},
                                           VideoKind{"libx264rgb", 100, 2}, VideoKind{"libx264", 9, 3},
                                           VideoKind{"libx265", 8, 3}));

TEST_P(VideoKinds, GiveTheSameImageInWhateverOrderItIsAskedFor) {
  const fs::path path = fresh_folder("video") / "rgb.mp4";
  const VideoKind kind = GetParam();
  PANOPTIC_REQUIRE_VIDEO(path, kind);
  const std::vector<Image<Rgb>> expected = images_of(kind);
  const Video in_order(path);
  ASSERT_EQ(in_order.size(), kImages);
  EXPECT_FALSE(in_order.is_cut_off());
  std::vector<Image<Rgb>> images;
  for (std::size_t i = 0; i < kImages; ++i) images.push_back(in_order.read(i));
  for (std::size_t i = 0; i < kImages; ++i) {
    ASSERT_TRUE(images[i].same_size(kSize.width, kSize.height));
    if (kind.codec == "libx264rgb") {
      EXPECT_EQ(images[i], expected[i]) << i;
    } else {
      EXPECT_NEAR(images[i](20, 20).g, level_of(i), 3) << i;
    }
  }
  const Video mixed(path);
  for (std::size_t n = 0; n < 2 * kImages; ++n) {
    const std::size_t i = n * 11 * (n + 3) % kImages;  // back and forth, and some twice
    EXPECT_EQ(mixed.read(i), images[i]) << n << ": " << i;
    EXPECT_EQ(mixed.read(i), images[i]) << n << ": " << i << " again";
  }
  const Video backwards(path);
  for (std::size_t i = kImages; i-- > 0;) EXPECT_EQ(backwards.read(i), images[i]) << i;
}

TEST(Video, IsReadFromSeveralThreads) {
  const fs::path path = fresh_folder("video") / "rgb.mp4";
  const VideoKind kind;
  PANOPTIC_REQUIRE_VIDEO(path, kind);
  const std::vector<Image<Rgb>> expected = images_of(kind);
  const Video video(path);
  std::vector<int> wrong(3);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < wrong.size(); ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t n = 0; n < kImages; ++n)
        wrong[t] += video.read((n * (t + 1)) % kImages) == expected[(n * (t + 1)) % kImages] ? 0 : 1;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(3, 0));
}

TEST(Video, IsReadAsFarAsItGoesIfCutOff) {
  const fs::path path = fresh_folder("video") / "rgb.mp4";
  const VideoKind kind{.index_first = true};
  PANOPTIC_REQUIRE_VIDEO(path, kind);
  fs::resize_file(path, fs::file_size(path) * 2 / 3);
  const Video video(path);
  EXPECT_TRUE(video.is_cut_off());
  ASSERT_GT(video.size(), 8U);
  ASSERT_LT(video.size(), kImages);
  EXPECT_EQ(video.read(8), images_of(kind)[8]);
}

TEST(Video, WithoutItsIndexIsNone) {
  const fs::path path = fresh_folder("video") / "rgb.mp4";
  const VideoKind kind;
  PANOPTIC_REQUIRE_VIDEO(path, kind);
  fs::resize_file(path, fs::file_size(path) * 2 / 3);
  EXPECT_THAT(error_of([&] { Video{path}; }), HasSubstr("no video that can be read"));
  write_text(path, "no video at all");
  EXPECT_THAT(error_of([&] { Video{path}; }), HasSubstr("no video that can be read"));
  EXPECT_THAT(error_of([&] { Video{path / "nowhere.mp4"}; }), HasSubstr("no such file"));
}

TEST(Video, OfAnotherKindIsRefused) {
  const fs::path path = fresh_folder("video") / "rgb.mp4";
  const VideoKind kind{.codec = "mpeg4"};
  PANOPTIC_REQUIRE_VIDEO(path, kind);
  EXPECT_THAT(error_of([&] { Video{path}; }), HasSubstr("neither H.264 nor HEVC"));
}

// The images between two key images depend on one another; those before and after are sound.
TEST(Video, RefusesDamagedImagesAndNoOthers) {
  const fs::path path = fresh_folder("video") / "rgb.mp4";
  const VideoKind kind{.images_between = 0};
  PANOPTIC_REQUIRE_VIDEO(path, kind);
  const std::vector<Image<Rgb>> expected = images_of(kind);
  std::string bytes = read_file(path);
  bytes.replace(bytes.size() / 2, 200, 200, '\x7f');
  write_text(path, bytes);
  const Video video(path);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < kImages; ++i) {
    try {
      EXPECT_EQ(video.read(i), expected[i]) << i;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("is damaged, or one that it is derived from"));
      ++refused;
    }
  }
  EXPECT_GE(refused, 1U);
  EXPECT_LE(refused, 16U);
}

TEST(Video, IsRefusedWithTheCommandThatExtractsItWhereTheBuildHasNone) {
  if (reads_videos()) GTEST_SKIP() << "this build reads videos";
  EXPECT_THAT(error_of([&] { Video{"/tmp/walk/rgb.mp4"}; }),
              HasSubstr("mkdir /tmp/walk/rgb && ffmpeg -ignore_editlist 1 -noautorotate -i /tmp/walk/rgb.mp4 -fps_mode "
                        "passthrough -start_number 0"));
}

}  // namespace
}  // namespace panoptic::test
