// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/agents.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "panoptic/planning/agent_rules.h"
#include "panoptic/planning/mesh_places.h"

namespace panoptic {
namespace {

namespace rules = agent_rules;

double apart(const Vec3d& a, const Vec3d& b) { return (a - b).head<2>().norm(); }

class Household {
 public:
  Household(const RecastMesh& mesh, const HomePlan& home, const AgentSize& size, std::uint32_t seed)
      : mesh_(mesh), home_(home), places_(mesh), dice_(seed), walk_(rules::kWalk), crowd_(mesh, kMost, of_crowd(size.radius_m)) {
    walk_.radius_m = of_crowd(size.radius_m);
    walk_.height_m = size.height_m;
  }

  // False if there is no room.
  bool add() {
    const double apart_m = std::max(rules::kApart_m, 2 * walk_.radius_m);
    for (int i = 0; i < rules::kTries; ++i) {
      const Vec3d at = places_.any(dice_);
      const bool is_alone = std::all_of(people_.begin(), people_.end(),
                                        [&](const Person& other) { return apart(other.agent.place(), at) > apart_m; });
      if (!is_alone || !is_roomy(at)) continue;
      const double heading_rad = 2 * std::numbers::pi * dice_.roll();
      people_.push_back({{{mesh_, crowd_}, walk_, at, heading_rad, people_.size()}, dice_.between(rules::kBored_s), {}});
      return true;
    }
    return false;
  }

  void note_samples(double time_s) {
    for (Person& p : people_) p.track.samples.push_back({time_s, p.agent.state(), p.agent.place(), p.agent.facing()});
  }

  void step() {
    for (Person& person : people_) decide(person);
    make_way();
    crowd_.step(rules::kStep_s);
    for (Person& person : people_) {
      const AgentState before = person.agent.state();
      person.agent.update(rules::kStep_s);
      AgentTotals& totals = person.track.totals;
      const AgentState now = person.agent.state();
      totals.seats += now != before && now == AgentState::kSitting ? 1 : 0;
      totals.beds += now != before && now == AgentState::kLying ? 1 : 0;
      totals.stuck_s += person.agent.is_stuck() ? rules::kStep_s : 0;
    }
  }

  std::vector<AgentTrack> tracks() {
    std::vector<AgentTrack> result;
    for (Person& person : people_) {
      person.track.totals.agents = 1;
      person.track.totals.walked_m = person.agent.walked_m();
      person.track.totals.gave_up = person.agent.gave_up();
      result.push_back(std::move(person.track));
    }
    return result;
  }

 private:
  static constexpr std::size_t kMost = rules::kMostAgents;
  struct Person {
    Agent agent;
    double wait_s = 0;
    AgentTrack track;
  };

  // A crowd needs some extent.
  static double of_crowd(double radius_m) {
    constexpr double kLeast_m = 0.02;
    return std::max(radius_m, kLeast_m);
  }

  // Not on a scrap of floor behind furniture.
  bool is_roomy(const Vec3d& at) {
    constexpr int kAsked = 6;
    constexpr int kEnough = 2;
    int reached = 0;
    for (int i = 0; i < kAsked; ++i) reached += mesh_.way(at, places_.any(dice_)).has_value() ? 1 : 0;
    return reached >= kEnough;
  }

  template <typename Place>
  bool is_free(const Place& place) const {
    return std::none_of(people_.begin(), people_.end(), [&](const Person& p) { return p.agent.takes(&place); });
  }

  void decide(Person& person) {
    Agent& agent = person.agent;
    const bool is_at_rest = agent.state() == AgentState::kSitting || agent.state() == AgentState::kLying;
    if (!is_at_rest && agent.state() != AgentState::kStanding) return;
    person.wait_s -= rules::kStep_s;
    if (person.wait_s > 0) return;
    person.wait_s = dice_.between(rules::kBored_s);
    if (is_at_rest) {
      agent.stand();
      return;
    }
    const double share = dice_.roll();
    if (share < rules::kSitsShare) {
      take(person, home_.seats, [&](const Seat& seat) { return agent.sit(seat); });
    } else if (share < rules::kSitsShare + rules::kLiesShare) {
      take(person, home_.lying_places, [&](const LyingPlace& bed) { return agent.lie(bed); });
    } else {
      agent.go(places_.any(dice_));
    }
  }

  template <typename Place, typename Act>
  void take(Person& person, const std::vector<Place>& all, const Act& act) {
    std::vector<const Place*> free;
    for (const Place& place : all) {
      if (is_free(place)) free.push_back(&place);
    }
    if (!free.empty() && act(*free[dice_.below(free.size())])) person.wait_s = dice_.between(rules::kRests_s);
  }

  // Who stands in somebody's way steps aside, and of two who block each other the one who came later.
  void make_way() {
    for (std::size_t i = 0; i < people_.size(); ++i) {
      if (!people_[i].agent.is_stuck()) continue;
      for (std::size_t k = 0; k < people_.size(); ++k) {
        Agent& other = people_[k].agent;
        const bool yields = k != i && (other.state() == AgentState::kStanding || (k > i && other.is_stuck()));
        if (yields && apart(other.place(), people_[i].agent.place()) <= rules::kInTheWay_m) {
          step_aside(other, people_[i].agent.place());
        }
      }
    }
  }

  void step_aside(Agent& agent, const Vec3d& from) {
    for (int i = 0; i < rules::kTries; ++i) {
      const Vec3d to = places_.any(dice_);
      const bool fits = apart(to, agent.place()) < rules::kAside_m.high && apart(to, from) > rules::kAside_m.low;
      if (fits && agent.go(to)) return;
    }
  }

  const RecastMesh& mesh_;
  const HomePlan& home_;
  MeshPlaces places_;
  Dice dice_;
  WalkRules walk_;
  RecastCrowd crowd_;
  std::vector<Person> people_;
};

}  // namespace

AgentTotals AgentsRun::totals() const {
  AgentTotals all;
  for (const AgentTrack& agent : agents) {
    all.agents += agent.totals.agents;
    all.walked_m += agent.totals.walked_m;
    all.seats += agent.totals.seats;
    all.beds += agent.totals.beds;
    all.gave_up += agent.totals.gave_up;
    all.stuck_s += agent.totals.stuck_s;
  }
  all.insects = static_cast<int>(insects.size());
  for (const InsectTrack& insect : insects) {
    all.crawled_m += insect.crawled_m;
    all.farthest_m = std::max(all.farthest_m, insect.farthest_m);
  }
  return all;
}

AgentsRun let_live(const RecastMesh& mesh, const HomePlan& home, const AgentSize& size, const AgentOptions& options) {
  Household household(mesh, home, size, options.seed);
  AgentsRun run;
  int added = 0;
  while (added < options.count && household.add()) ++added;
  if (added == 0)
    throw Error("no place was found from which an agent could get anywhere: the floor of the map lies in small pieces");
  if (added < options.count) run.notes.push_back(fmt::format("there is room for {} of {} agents", added, options.count));
  if (home.seats.empty()) run.notes.emplace_back("the map has no seats: agents sit on nothing");
  const auto steps = static_cast<int>(std::floor(options.seconds * rules::kStepsPer_s + 1e-6));
  for (int i = 0; i <= steps; ++i) {
    if (i > 0) household.step();
    if (i % rules::kStepsPerSample == 0) household.note_samples(i * rules::kStep_s);
  }
  run.agents = household.tracks();
  return run;
}

}  // namespace panoptic
