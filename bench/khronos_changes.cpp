// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// khronos_changes RECORDING RUN: says in RUN/objects.json which objects are gone or new by the rule that Schmid et al. describe
// (Khronos, RSS 2024): the rays of the recording are asked for every object before it was first seen and after it was last seen.
// A ray that ends far behind a point of the object's surface votes for its absence, one that ends near it for its presence. The
// object is absent where most votes of a few seconds say so. RUN must hold what was ever there: a run without moving.objects and
// carving. Their rule does not tell what was moved. Written from the description; numbers are those of the
// configuration that they publish for an apartment.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/run_files.h"
#include "panoptic/source.h"

namespace panoptic {
namespace {

constexpr double kDepthTolerance_m = 0.3;
constexpr double kFarthest_m = 5;   // of a ray that is trusted
constexpr double kBin_s = 1;        // votes are counted by so many seconds
constexpr std::size_t kWindow = 5;  // bins that are judged together
constexpr double kLongest_s = 1e5;
constexpr double kAbsent = 0.6;          // share of the votes
constexpr double kApart_s = 3;           // nearer to when it was seen, an object is not asked for
constexpr std::size_t kSampled = 100;    // one vertex in so many
constexpr std::size_t kFramesApart = 5;  // one frame in so many is asked

struct Votes {
  std::uint64_t absent = 0;
  std::uint64_t present = 0;
};

// The surface that a map keeps of an object, and the votes on it.
struct Fragment {
  std::vector<Vec3d> points;  // world
  double first_s = 0;
  double last_s = 0;
  std::vector<Votes> bins;
};

using Fragments = std::map<PanopticId, Fragment>;

// `time_of`: by frame, seconds from the first one.
Fragments fragments_of(const std::filesystem::path& run, const std::map<std::int64_t, double>& time_of) {
  Fragments fragments;
  const auto seconds = [&](std::int64_t frame) {
    const auto at = time_of.lower_bound(frame);
    return at == time_of.end() ? time_of.rbegin()->second : at->second;
  };
  for (const RunObject& object : read_run_objects(run).objects) {
    fragments[object.id].first_s = seconds(object.first_frame);
    fragments[object.id].last_s = seconds(object.last_frame);
  }
  std::map<PanopticId, std::size_t> met;
  for (const MeshVertex& vertex : read_run_mesh(run).vertices) {
    const auto found = fragments.find(vertex.panoptic_id);
    if (found == fragments.end() || met[vertex.panoptic_id]++ % kSampled != 0) continue;
    found->second.points.emplace_back(vertex.position.cast<double>());
  }
  return fragments;
}

void vote(const Frame& frame, std::size_t bin, Fragment& fragment) {
  const Camera& camera = frame.depth_camera;
  const Pose camera_from_world = frame.world_from_camera.inverse();
  fragment.bins.resize(std::max(fragment.bins.size(), bin + 1));
  for (const Vec3d& point : fragment.points) {
    const Vec3d at = camera_from_world * point;
    if (!(at.z() > 0)) continue;
    const auto u = static_cast<int>(std::lround(camera.fx * at.x() / at.z() + camera.cx));
    const auto v = static_cast<int>(std::lround(camera.fy * at.y() / at.z() + camera.cy));
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
    const auto depth_m = static_cast<double>(frame.depth(u, v));
    if (!(depth_m > 0) || depth_m > kFarthest_m) continue;
    const double behind_m = (depth_m - at.z()) * at.norm() / at.z();
    if (behind_m > kDepthTolerance_m) ++fragment.bins[bin].absent;
    if (std::abs(behind_m) <= kDepthTolerance_m) ++fragment.bins[bin].present;
  }
}

// There is a window of bins between both times in which most rays see that the object is not there.
bool is_absent(const Fragment& fragment, double from_s, double to_s) {
  const auto first = static_cast<std::size_t>(std::ceil(std::max(0.0, from_s) / kBin_s));
  const auto end = std::min(fragment.bins.size(), static_cast<std::size_t>(std::max(0.0, to_s) / kBin_s));
  for (std::size_t at = first; at < end; ++at) {
    Votes sum;
    for (std::size_t b = at; b < std::min(end, at + kWindow); ++b) {
      sum.absent += fragment.bins[b].absent;
      sum.present += fragment.bins[b].present;
    }
    if (sum.absent > 0 && static_cast<double>(sum.absent) >= kAbsent * static_cast<double>(sum.absent + sum.present)) return true;
  }
  return false;
}

void judge(const std::filesystem::path& recording_path, const std::filesystem::path& run) {
  const std::unique_ptr<Dataset> recording = open_recording(recording_path);
  std::map<std::int64_t, double> time_of;
  for (const Frame& frame : *recording) time_of[frame.index] = frame.time_s;
  if (time_of.empty()) throw Error(fmt::format("{}: no frame can be used", recording_path.string()));
  const double first_s = time_of.begin()->second;
  for (auto& [frame, time_s] : time_of) {
    time_s -= first_s;
    if (!(time_s >= 0 && time_s <= kLongest_s)) {
      throw Error(fmt::format("{}: frame {} is {} s after the first one; its time stamps are no use here",
                              recording_path.string(), frame, time_s));
    }
  }
  Fragments fragments = fragments_of(run, time_of);
  std::size_t met = 0;
  for (const Frame& frame : *recording) {
    if (met++ % kFramesApart != 0) continue;
    const auto bin = static_cast<std::size_t>(time_of.at(frame.index) / kBin_s);
    for (auto& [id, fragment] : fragments) vote(frame, bin, fragment);
  }
  Json file = read_json_file(run / "objects.json");
  for (Json& object : file["objects"]) {
    const auto found = fragments.find(static_cast<PanopticId>(object["id"].get<std::uint32_t>()));
    if (found == fragments.end() || found->second.points.empty()) continue;
    const Fragment& fragment = found->second;
    const bool is_gone = is_absent(fragment, fragment.last_s + kApart_s, time_of.rbegin()->second + kBin_s);
    object["state"] = is_gone ? "gone" : "present";
    object["appeared"] = is_absent(fragment, 0, fragment.first_s - kApart_s);
  }
  write_json_file(run / "objects.json", file);
}

}  // namespace
}  // namespace panoptic

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: khronos_changes RECORDING RUN\n");
    return 2;
  }
  try {
    panoptic::judge(argv[1], argv[2]);
  } catch (const std::exception& e) {
    fmt::print(stderr, "khronos_changes: {}\n", e.what());
    return 1;
  }
  return 0;
}
