// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/batch/batch_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "panoptic/base/files.h"
#include "panoptic/base/version.h"

namespace panoptic {
namespace {

double sum_of_seconds(const BatchReport& report) {
  double sum_s = 0;
  for (const SceneRecord& scene : report.scenes) sum_s += scene.wall_s;
  return sum_s;
}

double largest_mb(const BatchReport& report) {
  double most_mb = 0;
  for (const SceneRecord& scene : report.scenes) most_mb = std::max(most_mb, scene.peak_mb);
  return most_mb;
}

// A cell of a table cannot hold a bar as it is.
std::string cell(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

Json json_of(const BatchReport& r) {
  Json scenes = Json::array();
  for (const SceneRecord& scene : r.scenes) scenes.push_back(to_json(scene));
  return {{"program", fmt::format("panoptic {}", version())},
          {"list", r.list},
          {"run_options", r.run_options},
          {"jobs", r.jobs},
          {"complete", is_complete(r)},
          {"finished", count(r, SceneState::kFinished)},
          {"failed", count(r, SceneState::kFailed)},
          {"waiting", count(r, SceneState::kWaiting)},
          {"unscored", count_unscored(r)},
          {"skipped", r.skipped},
          {"wall_s", r.wall_s},
          {"sum_s", sum_of_seconds(r)},
          {"peak_mb", largest_mb(r)},
          {"scenes", std::move(scenes)}};
}

std::string line_of(const SceneRecord& r) {
  static constexpr const char* kWords[] = {"waiting", "done", "FAILED"};
  const char* const state = kWords[static_cast<std::size_t>(r.state)];
  if (r.state == SceneState::kWaiting) return fmt::format("| {} | {} | | | | | |\n", cell(r.scene.name), state);
  if (r.state == SceneState::kFailed) {
    return fmt::format("| {} | {} | {:.1f} | {:.0f} | | | {} |\n", cell(r.scene.name), state, r.wall_s, r.peak_mb,
                       cell(r.reason));
  }
  return fmt::format("| {} | {} | {:.1f} | {:.0f} | {} | {} | {}|\n", cell(r.scene.name), state, r.wall_s, r.peak_mb, r.frames,
                     r.objects, r.reason.empty() ? "" : "not scored: " + cell(r.reason) + " ");
}

std::string markdown_of(const BatchReport& r) {
  std::string text =
      fmt::format("# {} scenes of {}\n\n{} done, {} failed, {} waiting; {:.0f} s for all scenes together, at most {:.0f} MB",
                  r.scenes.size(), r.list, count(r, SceneState::kFinished), count(r, SceneState::kFailed),
                  count(r, SceneState::kWaiting), sum_of_seconds(r), largest_mb(r));
  if (!r.run_options.empty()) text += fmt::format("\n\nOptions: `{}`", fmt::join(r.run_options, " "));
  text += "\n\n| scene | state | s | MB | frames | objects | reason |\n|---|---|---:|---:|---:|---:|---|\n";
  for (const SceneRecord& scene : r.scenes) text += line_of(scene);
  if (!r.scores.empty()) text += fmt::format("\n## Scores\n\n```\n{}```\n", r.scores);
  return text;
}

}  // namespace

std::size_t count(const BatchReport& report, SceneState state) {
  return static_cast<std::size_t>(
      std::count_if(report.scenes.begin(), report.scenes.end(), [&](const SceneRecord& r) { return r.state == state; }));
}

std::size_t count_unscored(const BatchReport& report) {
  return static_cast<std::size_t>(std::count_if(report.scenes.begin(), report.scenes.end(), [](const SceneRecord& r) {
    return r.state == SceneState::kFinished && !r.reason.empty();
  }));
}

bool is_complete(const BatchReport& report) {
  return count(report, SceneState::kFinished) == report.scenes.size() && count_unscored(report) == 0;
}

void write_batch_report(const std::filesystem::path& folder, const BatchReport& report) {
  write_json_file(folder / "batch.json", json_of(report));
  write_file(folder / "batch.md", markdown_of(report));
}

}  // namespace panoptic
