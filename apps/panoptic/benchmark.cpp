// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <optional>
#include <utility>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/base/files.h"
#include "panoptic/benchmark/report.h"
#include "panoptic/parallel.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

// A little below what was measured (docs/benchmarks.md): the simulation gives the same frames everywhere, so what falls through
// is a change of the code.
const std::array<Floor, 4> kQuickFloors{
    {{"no regularizer", 0.615, 0.66}, {"default", 0.645, 0.68}, {"oracle masks", 0.89, 0.915}, {"oracle", 0.915, 0.93}}};

// A group of the full study may be looked at quickly too: on the small home alone.
Study study_of(const Arguments& arguments) {
  if (arguments.group.empty()) return arguments.quick ? quick_study() : full_study();
  Study study = only(full_study(), arguments.group);
  if (arguments.quick) study.experiment.homes = quick_study().experiment.homes;
  return study;
}

}  // namespace

int benchmark(const Arguments& arguments) {
  set_thread_count(arguments.threads);
  require_writable_folder(arguments.output);
  const Study study = study_of(arguments);
  watch_for_interrupt();
  fmt::print("{} homes under {} settings\n", study.experiment.homes.size(), study.experiment.settings.size());
  std::fflush(stdout);
  const Stopwatch stopwatch;
  std::vector<SettingResult> outcomes;
  {
    std::optional<Progress> progress;
    outcomes = run(study.experiment, [&](std::size_t done, std::size_t total) {
      if (!progress) progress.emplace("frames", total);
      progress->advance(done);
      return !interrupted();
    });
  }
  if (outcomes.empty()) {
    tell(fmt::format("interrupted: a benchmark is written whole or not at all; nothing was written to {}\n", arguments.output));
    return kInterrupted;
  }
  write_report(arguments.output, study, outcomes);
  fmt::print("\n{}\ndone in {:.0f} s, peak {:.0f} MB\nlook at   {}/report.md and the charts beside it\n",
             markdown(study, outcomes), stopwatch.seconds(), peak_rss_mb(), arguments.output);
  if (!arguments.quick || !arguments.group.empty()) return kDone;
  const std::vector<std::string> fallen = below(kQuickFloors, outcomes);
  for (const std::string& line : fallen) tell(fmt::format("below its floor: {}\n", line));
  return fallen.empty() ? kDone : kWorldIsWrong;
}

}  // namespace panoptic
