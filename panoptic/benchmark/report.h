// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A study's outcomes for people (Markdown with charts) and programs (JSON).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/benchmark/experiment.h"
#include "panoptic/benchmark/studies.h"

namespace panoptic {

// A table per group; scores in percent.
std::string markdown(const Study& study, std::span<const SettingResult> outcomes);

// Per setting: pq, sq, rq (each {all, things, stuff}), miou, ap, ap50, ap25, f_score, coverage as fractions, times, memory.
Json to_json(const Study& study, std::span<const SettingResult> outcomes);

// Writes report.md, report.json and a PNG per group into the folder. Throws Error.
void write_report(const std::filesystem::path& folder, const Study& study, std::span<const SettingResult> outcomes);

// A floor under a score, so that a change that costs accuracy is noticed.
struct Floor {
  std::string setting;
  double pq = 0;  // fractions
  double miou = 0;
};

// Scores below their floors, a line each; empty = all is well. REQUIRES every floor's setting among the outcomes.
std::vector<std::string> below(std::span<const Floor> floors, std::span<const SettingResult> outcomes);

}  // namespace panoptic
