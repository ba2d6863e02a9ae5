// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "panoptic/map_file.h"
#include "panoptic/outputs.h"
#include "panoptic/profile.h"
#include "tests/faults/operations.h"

namespace panoptic::test {
namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

// The system's word for the fault, or SQLite's.
bool names_reason(const std::string& text, const Fault& fault) {
  if (fault.error != 0 && contains(text, std::strerror(fault.error))) return true;
  if (fault.error == EIO && contains(text, "disk I/O error")) return true;
  if (fault.error == EMFILE && contains(text, "unable to open database file")) return true;
  // SQLite opens for reading a file that it cannot open for writing, and takes a file that it cannot look at for moved: then it
  // knows only that it may not write, and the remedy names the disk.
  const bool looks_read_only = contains(text, "readonly database; check that the disk is neither full nor read-only");
  if (looks_read_only && (contains(fault.calls, "create") || contains(fault.calls, "look"))) return true;
  // SQLite tries a full disk again in another way and then tells why that failed.
  return fault.error == ENOSPC && (contains(text, "database or disk is full") || contains(text, "the space on "));
}

bool is_failure(const std::string& line) { return line.starts_with("panoptic: "); }

// Progress, and what a run may say about its map and about files of the recording that it could not read beforehand.
bool is_expected(const std::string& line) {
  return line.empty() || is_failure(line) || contains(line, " frames  ") || line.starts_with("the map is not saved for now, ") ||
         line.starts_with("warning: frames: ");
}

std::string complaint_about_words(const FaultWorld& world, const Fault& fault, const ProgramResult& program) {
  std::string all;
  const std::vector<std::string> said = lines(program.err);
  for (const std::string& line : said) {
    if (!is_expected(line)) all += fmt::format("stderr has the line: {}\n", line);
  }
  const auto failures = std::count_if(said.begin(), said.end(), is_failure);
  if (failures != (program.exit_code == 0 ? 0 : 1)) all += fmt::format("{} lines of failure\n", failures);
  const auto failure = std::find_if(said.begin(), said.end(), is_failure);
  if (failure == said.end()) return all;
  if (!contains(*failure, world.root().string())) all += fmt::format("no file is named: {}\n", *failure);
  if (!names_reason(*failure, fault)) all += fmt::format("the reason is not named: {}\n", *failure);
  return all;
}

// A whole file of its kind, be it old or new.
bool is_sound(const fs::path& path, const std::string& bytes) {
  constexpr std::size_t kLengthAt = 8;
  try {
    const std::string kind = path.extension().string();
    if (kind == ".json") return !Json::parse(bytes, nullptr, false).is_discarded();
    if (kind == ".png") return read_rgb(path).width() > 0;
    if (path.filename() == "mesh.ply") return !read_ply(path).vertices.empty();
    if (kind == ".panoptic") return load_map(path).map.voxels.epoch() > 0;
    if (kind != ".glb") return true;
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + kLengthAt, sizeof(length));
    return length == bytes.size();
  } catch (const std::exception&) {
    return false;
  }
}

bool is_leftover(const std::string& name, const Operation& operation) {
  const bool is_log = name.ends_with("-wal") || name.ends_with("-shm") || name.ends_with("-journal");
  if (is_log && name.starts_with("map.panoptic")) {
    return !operation.changes_map;  // belongs to the map until a program closes it clean
  }
  constexpr std::array<std::string_view, 3> kMarks = {".partial", ".probe", ".new"};
  return is_log || std::any_of(kMarks.begin(), kMarks.end(), [&](std::string_view mark) { return contains(name, mark); });
}

// Without what differs from run to run.
std::string comparable(const fs::path& path, const std::string& bytes) {
  if (path.filename() == "report.json") {
    Json report = Json::parse(bytes, nullptr, false);
    for (const char* key :
         {"wall_s", "frames_per_s", "stages", "peak_rss_mb", "map_memory_mb", "memory_bytes_per_observed_voxel"})
      report.erase(key);
    return report.dump();
  }
  return bytes;
}

// The frames that could not be read are in the report, with the reason.
bool lists_skipped(const fs::path& report, const Fault& fault) {
  if (!is_there(report)) return false;
  const Json json = read_json_file(report);
  for (const Json& frame : json["frames"]["skipped_frames"]) {
    if (names_reason(frame["reason"].get<std::string>(), fault)) return true;
  }
  return false;
}

// The sheet of explain says in its place that a frame could not be read.
std::string picture_of_what_failed(const Operation& operation, const FaultyRun& run) {
  const bool in_recording = std::any_of(run.failed_at.begin(), run.failed_at.end(),
                                        [](const std::string& path) { return fs::path(path).extension() == ".sens"; });
  return operation.name == "explain" && in_recording ? "object.png" : "";
}

std::string differences(const FaultWorld& world, const Files& after, const Files& undisturbed, bool may_stay,
                        const std::string& shown_anyway) {
  std::string all;
  for (const auto& [name, bytes] : undisturbed) {
    const auto found = after.find(name);
    if (found == after.end()) {
      all += fmt::format("{} is missing\n", name);
    } else if (name.ends_with(".panoptic") || name == shown_anyway) {  // the pages of a map may lie in another order
      continue;
    } else if (comparable(name, found->second) != comparable(name, bytes)) {
      all += fmt::format("{} differs\n", name);
    }
  }
  for (const auto& [name, bytes] : after) {
    if (!undisturbed.contains(name) && !may_stay) all += fmt::format("{} is there\n", (world.place() / name).string());
  }
  return all;
}

std::string damage(const FaultWorld& world, const Operation& operation, const Files& after, const Files& before) {
  std::string all;
  for (const auto& [name, bytes] : after) {
    const auto old = before.find(name);
    const bool is_old = old != before.end() && old->second == bytes;
    const bool may_lie_in_log = operation.changes_map && name.ends_with(".panoptic");
    if ((!is_old || may_lie_in_log) && !is_sound(world.place() / name, bytes)) all += fmt::format("{} is damaged\n", name);
  }
  return all;
}

}  // namespace

std::string map_summary(const fs::path& path) {
  if (!is_there(path)) return "no map";
  const SavedMap saved = load_map(path);
  return fmt::format("{:016x}, {} objects, {} frames", saved.map.voxels.hash(), saved.map.objects.count(),
                     load_frames(path).size());
}

std::string complaints(const FaultWorld& world, const Operation& operation, const Fault& fault, const FaultyRun& run,
                       const Undisturbed& undisturbed) {
  const ProgramResult& program = run.program;
  if (program.exit_code != 0 && program.exit_code != 1) return fmt::format("exit code {}: {}\n", program.exit_code, program.err);
  std::string all = complaint_about_words(world, fault, program);
  const Files after = files_below(world.place());
  const bool may_stay = contains(fault.calls, "remove");
  if (!may_stay) {
    for (const auto& [name, bytes] : after) {
      if (is_leftover(fs::path(name).filename().string(), operation)) all += fmt::format("{} was left\n", name);
    }
  }
  if (program.exit_code == 0) {
    if (operation.reads_frames && lists_skipped(world.place() / "out/report.json", fault)) return all;
    if (operation.by_the_clock) return all + damage(world, operation, after, undisturbed.before);
    all += differences(world, after, undisturbed.files, may_stay, picture_of_what_failed(operation, run));
    if (operation.name == "info" && program.out != undisturbed.out) all += "it says something else\n";
    if (map_summary(world.place() / "map.panoptic") != undisturbed.map) all += "the map differs\n";
    return all;
  }
  for (const auto& [name, bytes] : undisturbed.before) {
    if (!after.contains(name) && !name.ends_with("-wal") && !name.ends_with("-shm")) all += fmt::format("{} was lost\n", name);
  }
  return all + damage(world, operation, after, undisturbed.before);
}

}  // namespace panoptic::test
