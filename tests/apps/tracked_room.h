// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Recordings of the painted room on disk, without poses, and runs over them.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "tests/apps/program.h"
#include "tests/fresh_folder.h"
#include "tests/tracking/painted_room.h"

namespace panoptic::test {

inline constexpr int kWayRound = 150;

class TrackedRoom : public testing::Test {
 protected:
  // A folder of `count` frames of the way round, from that one on, numbered from 0.
  std::filesystem::path recording(const std::string& name, int first, int count) const {
    const std::filesystem::path folder = folder_ / name;
    std::filesystem::create_directories(folder);
    write_file(folder / "camera-intrinsics.txt", "260 0 159.5\n0 260 119.5\n0 0 1\n");
    for (int n = 0; n < count; ++n) write_frame(folder, n, room_frame(first + n, kWayRound));
    return folder;
  }
  static void write_frame(const std::filesystem::path& folder, int n, const Frame& frame) {
    Image<std::uint16_t> depth(frame.depth.width(), frame.depth.height());
    for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = static_cast<std::uint16_t>(1000 * frame.depth[i] + 0.5F);
    const std::string name = fmt::format("frame-{:06}", n);
    write_png(folder / (name + ".color.png"), frame.color.copied());
    write_png(folder / (name + ".depth.png"), depth);
  }
  ProgramResult run_over(const std::filesystem::path& folder, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"run", folder.string(), "-o", out_.string(), "--no-pictures", "--set", "map.voxel_size_m=0.03"};
    all.insert(all.end(), more.begin(), more.end());
    return run_program(all);
  }
  Json report() const { return Json::parse(read_file(out_ / "report.json")); }

  const std::filesystem::path folder_ = fresh_folder("track");
  const std::filesystem::path out_ = folder_ / "out";
};

}  // namespace panoptic::test
