// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/planning/plan_files.h"

namespace panoptic {
namespace {

// Tenths of a millimetre.
double short_of(double value) {
  constexpr double kPer_m = 1e4;
  return std::round(value * kPer_m) / kPer_m + 0.0;
}

Json totals_json(const AgentTotals& totals) {
  return {{"walked_m", short_of(totals.walked_m)},
          {"seats", totals.seats},
          {"beds", totals.beds},
          {"gave_up", totals.gave_up},
          {"stuck_s", short_of(totals.stuck_s)}};
}

Json insects_json(double crawled_m, double farthest_m) {
  return {{"crawled_m", short_of(crawled_m)}, {"farthest_m", short_of(farthest_m)}};
}

Json place_json(const Vec3d& p) { return Json::array({short_of(p.x()), short_of(p.y()), short_of(p.z())}); }

Json sample_json(const InsectSample& sample) {
  return {{"time_s", short_of(sample.time_s)}, {"position", place_json(sample.position)}, {"wall", sample.wall}};
}

Json sample_json(const AgentSample& sample) {
  return {{"time_s", short_of(sample.time_s)},
          {"position", place_json(sample.position)},
          {"state", name_of(sample.state)},
          {"facing", Json::array({short_of(sample.facing.x()), short_of(sample.facing.y())})}};
}

}  // namespace

void write_agents(const std::filesystem::path& file, const AgentsRun& run, const PlanOptions& options, const UpFrame& frame) {
  Json agents = Json::array();
  for (const AgentTrack& agent : run.agents) {
    Json samples = Json::array();
    for (const AgentSample& sample : agent.samples) samples.push_back(sample_json(sample));
    agents.push_back({{"summary", totals_json(agent.totals)}, {"samples", std::move(samples)}});
  }
  Json insects = Json::array();
  for (const InsectTrack& insect : run.insects) {
    Json samples = Json::array();
    for (const InsectSample& sample : insect.samples) samples.push_back(sample_json(sample));
    insects.push_back({{"summary", insects_json(insect.crawled_m, insect.farthest_m)}, {"samples", std::move(samples)}});
  }
  const AgentTotals totals = run.totals();
  Json all = {{"unit", "m"},
              {"world_from_grid", to_json(Pose(frame.grid_from_world.inverse()))},
              {"radius_m", options.agent.radius_m},
              {"seconds", options.agents->seconds},
              {"seed", options.agents->seed},
              {"sample_s", kAgentSample_s},
              {"summary", totals_json(totals)},
              {"insects_summary", insects_json(totals.crawled_m, totals.farthest_m)},
              {"agents", std::move(agents)},
              {"insects", std::move(insects)}};
  write_file(file, all.dump() + "\n");  // without spaces: they would be most of it
}

}  // namespace panoptic
