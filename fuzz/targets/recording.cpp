// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <memory>

#include "fuzz/input.h"
#include "panoptic/base/image_io.h"
#include "panoptic/source.h"

namespace panoptic::fuzz {
namespace {

// A layout of recordings: two frames of images that are sound, and the text files that the input fills.
struct Layout {
  const char* name;
  std::array<const char*, 2> color;
  std::array<const char*, 2> depth;
  std::vector<const char*> texts;
  std::vector<const char*> confidence = {};
};

const std::vector<Layout>& layouts() {
  static const std::vector<Layout> kLayouts = {
      {"scannet",
       {"color/0.png", "color/1.png"},
       {"depth/0.png", "depth/1.png"},
       {"pose/0.txt", "pose/1.txt", "intrinsic/intrinsic_depth.txt", "intrinsic/intrinsic_color.txt",
        "intrinsic/extrinsic_depth.txt", "intrinsic/extrinsic_color.txt"}},
      {"scannet_cpp",
       {"frame-000000.color.png", "frame-000001.color.png"},
       {"frame-000000.depth.pgm", "frame-000001.depth.pgm"},
       {"_info.txt", "frame-000000.pose.txt"}},
      {"seven_scenes",
       {"frame-000000.color.png", "frame-000001.color.png"},
       {"frame-000000.depth.png", "frame-000001.depth.png"},
       {"camera-intrinsics.txt", "frame-000000.pose.txt", "frame-000001.pose.txt"}},
      {"tum", {"rgb/0.png", "rgb/1.png"}, {"depth/0.png", "depth/1.png"}, {"rgb.txt", "depth.txt", "groundtruth.txt"}},
      {"icl", {"rgb/0.png", "rgb/1.png"}, {"depth/0.png", "depth/1.png"}, {"associations.txt", "a.gt.freiburg"}},
      {"replica",
       {"results/frame000000.png", "results/frame000001.png"},
       {"results/depth000000.png", "results/depth000001.png"},
       {"traj.txt", "cam_params.json"}},
      {"plain", {"images/0.png", "images/1.png"}, {"depth/0.png", "depth/1.png"}, {"K.txt", "poses.txt"}},
      {"open3d", {"color/0.png", "color/1.png"}, {"depth/0.png", "depth/1.png"}, {"camera_intrinsic.json", "trajectory.log"}},
      {"sun3d", {"image/1-0.png", "image/2-9.png"}, {"depth/1-1.png", "depth/2-8.png"}, {"intrinsics.txt", "extrinsics/1.txt"}},
      {"flat", {"0-color.png", "1-color.png"}, {"0-depth.png", "1-depth.png"}, {"intrinsic.txt", "0-pose.txt", "1-pose.txt"}},
      {"arkitscenes",
       {"lowres_wide/9_1.000.png", "lowres_wide/9_1.100.png"},
       {"lowres_depth/9_1.000.png", "lowres_depth/9_1.100.png"},
       {"lowres_wide.traj", "lowres_wide_intrinsics/9_1.000.pincam", "lowres_wide_intrinsics/9_1.100.pincam"},
       {"confidence/9_1.000.png", "confidence/9_1.100.png"}},
      {"stray",
       {"rgb/000000.png", "rgb/000001.png"},
       {"depth/000000.png", "depth/000001.png"},
       {"odometry.csv", "camera_matrix.csv"},
       {"confidence/000000.png", "confidence/000001.png"}},
      {"record3d", {"rgb/0.png", "rgb/1.png"}, {"depth/0.png", "depth/1.png"}, {"metadata.json"}, {"confidence/0.png"}},
      {"rtabmap",
       {"a_rgb/1.png", "a_rgb/2.png"},
       {"a_depth/1.png", "a_depth/2.png"},
       {"a_calib/1.yaml", "a_calib/2.yaml", "a_camera_poses.txt", "a_poses.txt"}},
      {"bundle_fusion",
       {"frame-000000.color.png", "frame-000001.color.png"},
       {"frame-000000.depth.png", "frame-000001.depth.png"},
       {"info.txt", "frame-000000.pose.txt", "frame-000001.pose.txt"}}};
  return kLayouts;
}

void put_depth(const Scratch& scratch, const char* name, const Image<std::uint16_t>& depth) {
  if (!std::string_view(name).ends_with(".pgm")) return write_png(scratch.path() / name, depth);
  std::string bytes = "P5 8 6 65535\n";
  for (const std::uint16_t value : depth.pixels()) {
    bytes += static_cast<char>(value >> 8);
    bytes += static_cast<char>(value & 255);
  }
  scratch.put(name, bytes_of(bytes));
}

std::unique_ptr<Scratch> with_images(const Layout& layout) {
  auto scratch = std::make_unique<Scratch>(layout.name);
  const auto path_of = [&](const char* name) {
    std::filesystem::create_directories((scratch->path() / name).parent_path());
    return scratch->path() / name;
  };
  for (const char* name : layout.color) write_png(path_of(name), Image<Rgb>(8, 6, Rgb{10, 20, 30}));
  for (const char* name : layout.depth) {
    path_of(name);
    put_depth(*scratch, name, Image<std::uint16_t>(8, 6, 1500));
  }
  for (const char* name : layout.confidence) write_png(path_of(name), Image<std::uint16_t>(8, 6, 2));
  for (const char* name : layout.texts) path_of(name);
  return scratch;
}

void read(const Scratch& scratch) {
  constexpr std::size_t kMostFrames = 3;
  const auto dataset = open_recording(scratch.path());
  for (std::size_t i = 0; i < std::min(dataset->size(), kMostFrames); ++i) {
    const ReadResult result = dataset->read(i);
    require(result.frame || !result.skipped.reason.empty(), "there is a frame or a reason");
    require(!result.frame || is_finite(result.frame->world_from_camera), "poses are finite");
  }
}

}  // namespace

// The first byte says which format; then the text files, some of which may be missing.
void recording(Input input) {
  if (input.empty()) return;
  static std::vector<std::unique_ptr<Scratch>> scratches(layouts().size());
  const std::size_t index = input[0] % layouts().size();
  const Layout& layout = layouts()[index];
  if (scratches[index] == nullptr) scratches[index] = with_images(layout);
  const std::vector<Input> parts = parts_of(input.subspan(1), layout.texts.size());
  for (std::size_t i = 0; i < layout.texts.size(); ++i) {
    if (i < parts.size()) {
      scratches[index]->put(layout.texts[i], parts[i]);
    } else {
      std::filesystem::remove(scratches[index]->path() / layout.texts[i]);
    }
  }
  succeeds([&] { read(*scratches[index]); });
}

}  // namespace panoptic::fuzz
