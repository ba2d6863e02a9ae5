// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/numbers.h"
#include "apps/panoptic/progress.h"
#include "panoptic/map_file.h"
#include "panoptic/parallel.h"
#include "panoptic/planning.h"
#include "panoptic/run_outputs.h"

namespace panoptic {
namespace {

// A place is three numbers; everything else is a name.
bool is_place(const std::string& text) { return text.find(',') != std::string::npos; }

PlanOptions options_of_plan(const Arguments& a) {
  PlanOptions options;
  options.agent = a.agent;
  for (const std::string& band : a.bands) {
    const std::vector<double> heights = numbers_from(band, 2, "--band", ':');
    options.bands.push_back({heights[0], heights[1]});
  }
  if (a.agent_count) {
    options.agents = a.agents;
    options.agents->count = *a.agent_count;
  }
  if (a.path_from.empty()) return options;
  options.journey.emplace(Journey{.from_m = point_from(a.path_from, "--from"), .to_m = {}, .to_object = {}});
  if (is_place(a.path_to)) {
    options.journey->to_m = point_from(a.path_to, "--to");
  } else {
    options.journey->to_object = a.path_to;
  }
  return options;
}

void tell_summary(const PlanSummary& summary, const std::string& folder) {
  for (const std::string& note : summary.notes) tell_note(note);
  fmt::print("walkable  {:.1f} m2 in {} {}, {} polygons made in {:.0f} ms\n", summary.walkable_m2, summary.islands,
             summary.islands == 1 ? "part" : "parts", summary.polygons, summary.mesh_ms);
  fmt::print("walls     {} with a navigation mesh\n", summary.walls);
  if (summary.length_m) fmt::print("way       {:.2f} m, look at {}/path.png\n", *summary.length_m, folder);
  if (!summary.why_not.empty()) fmt::print("way       none: {}\n", summary.why_not);
  if (summary.agents) {
    const AgentTotals& all = *summary.agents;
    fmt::print("agents    {} walked {:.0f} m, sat {} times, lay {} times, gave up {} times\n", all.agents, all.walked_m,
               all.seats, all.beds, all.gave_up);
    if (all.insects > 0) {
      fmt::print("insects   {} crawled {:.1f} m, at most {:.1f} cm from the surface of the map\n", all.insects, all.crawled_m,
                 100 * all.farthest_m);
    }
  }
  fmt::print("files     {}\n", folder);
}

}  // namespace

int plan(const Arguments& a) {
  set_thread_count(a.threads);
  PlanOptions options = options_of_plan(a);
  check(options.agent);  // before the map is loaded
  for (const HeightBand& band : options.bands) check(band);
  if (options.agents) check(*options.agents);
  const SavedMap saved = load_map_and_tell(a.map);
  options.up = noted_up(saved);
  PlanSummary summary;
  {
    Progress progress("steps", kPlanSteps);
    summary = write_plan(a.output, saved.map, options, [&](const std::string&, std::size_t number) { progress.advance(number); });
    progress.advance(kPlanSteps);
  }
  tell_summary(summary, a.output);
  return kDone;
}

}  // namespace panoptic
