// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <future>
#include <utility>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/sim/home_statistics.h"
#include "panoptic/sim/home_truth.h"
#include "panoptic/sim/scan_writer.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr int kMostJumps = 10000;

// `<folder>.partial` while the scan is written; becomes `folder` when it is whole, and else is removed.
class StagingFolder {
 public:
  explicit StagingFolder(const fs::path& folder) : final_(fs::absolute(folder).lexically_normal()) {
    if (!final_.has_filename()) final_ = final_.parent_path();  // "home/" is "home"
    path_ = final_.string() + ".partial";
    std::error_code error;
    if (fs::exists(final_, error) && !(fs::is_directory(final_, error) && fs::is_empty(final_, error))) {
      throw Error(fmt::format("{} already holds something: choose another folder or remove it", final_.string()));
    }
    if (fs::exists(path_, error)) {
      throw Error(fmt::format("{} is there: an earlier simulation was killed, or another is writing it; if none is, remove it",
                              path_.string()));
    }
    require_writable_folder(path_);
    ours_ = true;
  }
  ~StagingFolder() {
    std::error_code ignored;
    if (ours_) fs::remove_all(path_, ignored);
  }
  StagingFolder(const StagingFolder&) = delete;
  StagingFolder& operator=(const StagingFolder&) = delete;

  const fs::path& path() const { return path_; }

  void publish() {
    std::error_code error;
    fs::rename(path_, final_, error);
    if (error) {
      throw Error(
          fmt::format("cannot rename {} to {}: {}; choose another folder", path_.string(), final_.string(), error.message()));
    }
    ours_ = false;
  }

 private:
  fs::path final_;
  fs::path path_;
  bool ours_ = false;
};

// A batch is made in parallel while the one before it is written, so at most two are in memory.
bool write_frames(const Simulation& simulation, const ExportOptions& options, ScanWriter& writer, const ExportWatch& watch) {
  constexpr std::size_t kPerThread = 2;
  const std::size_t batch = kPerThread * static_cast<std::size_t>(thread_count());
  std::future<void> writing;
  const auto wait = [&] {
    if (writing.valid()) writing.get();  // throws what the writer threw
  };
  for (std::size_t begin = 0; begin < simulation.size(); begin += batch) {
    std::vector<ExportedFrame> frames(std::min(batch, simulation.size() - begin));
    parallel_for(frames.size(), [&](std::size_t i) { frames[i] = make_frame(simulation, options, begin + i); });
    wait();
    writing = std::async(std::launch::async, [&writer, made = std::move(frames)] {
      for (const ExportedFrame& frame : made) writer.write(frame);
    });
    if (!watch(std::min(begin + batch, simulation.size()))) return false;
  }
  wait();
  return true;
}

// The home as it is at the end, and what happens in it.
void write_home(const Simulation& simulation, const fs::path& folder) {
  const Home home = final_home(simulation.world());
  write_png(folder / "plan.png", draw_plan(home, simulation.true_path()));
  write_home_truth(home_truth(home, {simulation.options().seed, simulation.options().rooms}), folder);
  if (!simulation.jumps().jumps.empty()) write_jumps(folder / kJumpsFile, simulation.jumps(), kFrameRate_hz);
  if (!simulation.moves()) return;
  write_dynamics(folder / kDynamicsFile,
                 dynamics_truth(simulation.world(), simulation.renderer(), simulation.camera(), simulation.options().dynamics));
}

}  // namespace

Fields fields(ExportOptions& o) {
  Fields all = {
      {"seed", &o.seed, "which home: a whole number", {}},
      {"rooms", &o.rooms, "rooms of the home", in_range(1, 8)},
      {"frames", &o.frames, "frames of the recording; 0: as many as the way through the home takes at 30 Hz", in_range(0, 1e6)},
      {"noise", &o.noise, "preset of the sensor's noise", {}},
      {"dynamics", &o.dynamics, "what moves: static, people, changes or busy", one_of(dynamics_names())},
      {"jumps", &o.jumps, "how often the camera is carried to another place", in_range(0, kMostJumps)},
      {"predictions", &o.predictions, "preset that prediction_noise came from, or none", {}},
      {"jpeg_quality", &o.jpeg_quality, "quality of the colour images", in_range(1, 100)},
      {"truth_stride", &o.truth_stride, "every how many frames enter the true mesh; 0: about 600 do", in_range(0, 1e6)},
  };
  append_group(all, "prediction_noise", fields(o.prediction_noise));
  return all;
}

void set_predictions(ExportOptions& options, const std::string& preset) {
  options.predictions = preset;
  if (preset != "none") options.prediction_noise = prediction_noise_preset(preset);
}

SimulationOptions simulation_options(const ExportOptions& o) {
  if (o.seed.find(',') != std::string::npos)
    throw Error(fmt::format("seed '{}' is not a whole number; write for example 7", o.seed));
  SimulationOptions simulation = parse_simulation("sim:" + o.seed);
  simulation.rooms = o.rooms;
  simulation.frames = o.frames;
  simulation.noise = o.noise;
  sensor_noise_preset(o.noise);
  simulation.dynamics = o.dynamics;
  dynamics_of(o.dynamics);
  simulation.jumps = o.jumps;
  if (o.jumps < 0 || o.jumps > kMostJumps) {
    throw Error(fmt::format("jumps = {} is out of range; it may be 0 to {}", o.jumps, kMostJumps));
  }
  return simulation;
}

bool export_scan(const Simulation& simulation, const ExportOptions& options, const fs::path& folder, const ExportWatch& watch) {
  StagingFolder staging(folder);
  ExportOptions written = options;
  write_file(staging.path() / "simulation.toml", to_toml(fields(written)));
  write_home(simulation, staging.path());
  ScanWriter writer(staging.path(), simulation, options);
  if (!write_frames(simulation, options, writer, watch)) return false;
  writer.finish();
  staging.publish();
  return true;
}

// Facts of ScanNet's category map: the number of the raw category that bears the class's name ("furniture" for
// otherfurniture, which is none).
std::uint16_t scannet_category(ClassId class_id) {
  static const std::map<int, std::uint16_t> kByNyu40 = {{1, 1},   {2, 3},   {3, 7},   {4, 11},  {5, 2},   {6, 1313}, {7, 4},
                                                        {8, 5},   {9, 16},  {10, 18}, {11, 15}, {12, 35}, {14, 9},   {16, 21},
                                                        {24, 27}, {28, 55}, {33, 17}, {34, 14}, {36, 42}, {39, 213}};
  const auto at = kByNyu40.find(number(class_id));
  return at == kByNyu40.end() ? std::uint16_t{0} : at->second;
}

}  // namespace panoptic
