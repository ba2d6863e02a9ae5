// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/operations.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/labels.h"
#include "panoptic/predict/prediction_io.h"
#include "tests/fresh_folder.h"
#include "tests/fusion/scenes.h"

namespace panoptic::test {
namespace {

constexpr int kFrames = 5;
constexpr int kBadFrame = 3;  // of the run that ends early, so that there is something to resume

void must_do(const std::vector<std::string>& arguments, int exit_code = 0) {
  const ProgramResult result = run_program(arguments);
  if (result.exit_code != exit_code) throw std::runtime_error(fmt::format("{}: {}", arguments[0], result.err));
}

// The ball is a chair, the rest is floor.
void write_predictions(const fs::path& folder) {
  const LabelSet labels = load_label_set("indoor");
  PredictionWriter writer(folder, labels, "test");
  const ClassId chair = labels.find("chair")->id;
  const ClassId floor = labels.find("floor")->id;
  for (int i = 0; i < kFrames; ++i) {
    const Frame frame = orbit_frame(i);
    Segmentation s{Image<std::uint16_t>(160, 120), {{chair, 0.8F, {{chair, 1.0F}}}, {floor, 1, {}}}};
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
        s.segment_at(u, v) = p.y() > 0.599 ? 2 : 1;
      }
    }
    writer.write(i, s);
  }
}

void copy_folder(const fs::path& from, const fs::path& to) {
  if (fs::exists(from)) fs::copy(from, to, fs::copy_options::recursive);
}

int some_object(const fs::path& run) { return read_json_file(run / "objects.json")["objects"].at(0)["id"]; }

}  // namespace

Files files_below(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = read_file(entry.path());
  }
  return files;
}

FaultWorld::FaultWorld()
    : root_(fresh_folder("world")), given_(root_ / "given"), before_(root_ / "before"), place_(root_ / "place") {
  for (const fs::path& folder : {given_, before_, place_}) fs::create_directories(folder);
  write_orbit_recording(given_ / "recording", kFrames);
  write_predictions(given_ / "predictions");
}

void FaultWorld::make_home() {
  if (fs::exists(given_ / "home")) return;
  must_do({"simulate", "--seed", "1", "--rooms", "1", "--frames", "3", "-o", (given_ / "home").string()});
  must_do({"run", "--no-pictures", (given_ / "home").string(), "--predictions", (given_ / "home/predictions").string(), "-o",
           (given_ / "home_run").string(), "--set", "map.voxel_size_m=0.08"});
}

void FaultWorld::make_map() {
  if (!fs::exists(given_ / "map.panoptic")) must_do(run_arguments((given_ / "map.panoptic").string()));
}

// Makes a map of the same place, with one frame less.
void FaultWorld::make_later_map() {
  make_map();
  if (fs::exists(given_ / "later.panoptic")) return;
  std::vector<std::string> arguments = run_arguments((given_ / "later.panoptic").string());
  arguments.insert(arguments.end(), {"--frames", fmt::format("0:{}", kFrames - 1)});
  must_do(arguments);
}

// A run that a bad prediction ended.
void FaultWorld::make_early_end() {
  const fs::path bad = given_ / "predictions" / fmt::format("{:06}.json", kBadFrame);
  const std::string good = read_file(bad);
  write_file(bad, "not JSON");
  fs::remove_all(place_);
  fs::create_directories(place_);
  must_do(run_arguments((place_ / "map.panoptic").string()), 1);
  write_file(bad, good);
  fs::rename(place_, before_ / "resume");
}

// Makes the files that are there before an operation changes them.
void FaultWorld::make_before(const std::string& name) {
  if (name == "resume") return make_early_end();
  fs::create_directories(before_ / name);
  if (name == "regularize") fs::copy(given_ / "map.panoptic", before_ / name / "map.panoptic");
  if (name.starts_with("run")) {
    must_do({"run", "--no-pictures", (given_ / "recording").string(), "-o", (before_ / name / "out").string(), "--set",
             "map.voxel_size_m=0.12"});
  }
  if (name == "mesh" || name == "scene" || name == "eval" || name == "explain" || name == "diff") {
    for (const char* file : {"mesh.ply", "scene.glb", "scores.json", "object.png", "changes.json", "changes.png"})
      write_file(before_ / name / file, "older");
  }
}

Operation FaultWorld::operation(const std::string& name) {
  if (name == "run_sens" || name == "eval" || name == "explain") make_home();
  if (name == "merge" || name == "diff") make_later_map();
  if (name == "info" || name == "mesh" || name == "scene" || name == "regularize") make_map();
  if (!fs::exists(before_ / name)) make_before(name);
  return described(name);
}

std::vector<std::string> FaultWorld::run_arguments(const std::string& map) const {
  std::vector<std::string> all{"run",
                               (given_ / "recording").string(),
                               "-o",
                               (place_ / "out").string(),
                               "--predictions",
                               (given_ / "predictions").string(),
                               "--set",
                               "map.voxel_size_m=0.08",
                               "--threads",
                               "2"};
  if (!map.empty()) all.insert(all.end(), {"--no-pictures", "--map", map, "--resume", "--checkpoint-every", "0"});
  return all;
}

std::vector<std::string> FaultWorld::operations() {
  return {"simulate", "run",   "run_paged",  "run_sens", "map",  "resume", "online", "info",
          "mesh",     "scene", "regularize", "merge",    "diff", "eval",   "explain"};
}

Operation FaultWorld::online(const std::string& map) const {
  std::vector<std::string> arguments = run_arguments("");
  arguments.insert(arguments.end(), {"--no-pictures", "--map", map, "--checkpoint-every", "0", "--online", "--speed", "max"});
  return {"online", arguments, true, false, true, true};
}

Operation FaultWorld::described(const std::string& name) const {
  const auto given = [&](const char* file) { return (given_ / file).string(); };
  const auto place = [&](const char* file) { return (place_ / file).string(); };
  if (name == "simulate") return {name, {name, "--seed", "1", "--rooms", "1", "--frames", "2", "-o", place("home")}};
  if (name == "run") return {name, run_arguments(""), true, false};
  if (name == "run_paged") {
    std::vector<std::string> all = run_arguments("");
    all.insert(all.end(), {"--no-pictures", "--set", "map.memory_limit_mb=4000"});
    return {name, all, true, false};
  }
  if (name == "run_sens") {
    return {name,
            {"run", "--no-pictures", given("home"), "--predictions", given("home/predictions"), "-o", place("out"), "--set",
             "map.voxel_size_m=0.08"},
            true,
            false};
  }
  if (name == "map" || name == "resume") return {name, run_arguments(place("map.panoptic")), true, true, true};
  if (name == "online") return online(place("map.panoptic"));
  if (name == "info") return {name, {name, given("map.panoptic"), "--json"}};
  if (name == "mesh") return {name, {name, given("map.panoptic"), "-o", place("mesh.ply")}};
  if (name == "scene") return {name, {"mesh", given("map.panoptic"), "-o", place("scene.glb")}};
  if (name == "regularize") {
    return {name, {name, place("map.panoptic"), "--set", "regularizer.w2=20"}, false, false, true};
  }
  if (name == "merge") return {name, {name, given("map.panoptic"), given("later.panoptic"), "-o", place("map.panoptic")}};
  if (name == "diff") {
    return {
        name,
        {name, given("map.panoptic"), given("later.panoptic"), "--json", place("changes.json"), "--png", place("changes.png")}};
  }
  if (name == "eval") return {name, {name, given("home_run"), "--gt", given("home"), "--json", place("scores.json")}};
  if (name == "explain")
    return {name, {name, given("home_run"), std::to_string(some_object(given_ / "home_run")), "--png", place("object.png")}};
  throw std::logic_error("no operation " + name);
}

void FaultWorld::put_back(const Operation& operation) const {
  fs::remove_all(place_);
  fs::create_directories(place_);
  copy_folder(before_ / operation.name, place_);
}

}  // namespace panoptic::test
