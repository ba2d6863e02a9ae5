// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The questions of the benchmark: homes, settings, and groups of settings that answer one question each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/benchmark/chart.h"
#include "panoptic/benchmark/experiment.h"

namespace panoptic {

// The measure that the chart of a group shows.
enum class Measure : std::uint8_t { kPq, kPqAndTime };

struct Group {
  std::string title;
  std::string question;
  ChartKind chart = ChartKind::kBars;
  Measure measure = Measure::kPq;
  std::vector<std::string> settings;  // names; a setting may answer several questions
};

struct Study {
  Experiment experiment;
  std::vector<Group> groups;
};

// Every question on five homes: seeds 1 to 5, four rooms each.
Study full_study();

// The study with this group alone and the settings that it needs. Throws Error listing the groups if there is none of that title.
Study only(Study study, const std::string& title);

// The masks, the regularizer and the two ends of the error budget on one small home: for every change of the code.
Study quick_study();

}  // namespace panoptic
