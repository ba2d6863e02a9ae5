// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/moving_home.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/sim/camera_path.h"
#include "panoptic/sim/home_truth.h"
#include "panoptic/sim/random.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kPurpose = 0x64796e61;

void make_presences(MovingHome& world) {
  std::set<std::size_t> starts;
  Presence presence(world.home.scene.objects.size(), 1);
  for (const Change& change : world.changes) {
    starts.insert(change.frame);
    if (change.after) presence[*change.after] = 0;
  }
  world.starts.assign(starts.begin(), starts.end());
  world.presences = {presence};
  for (const std::size_t start : world.starts) {
    for (const Change& change : world.changes) {
      if (change.frame != start) continue;
      if (change.before) presence[*change.before] = 0;
      if (change.after) presence[*change.after] = 1;
    }
    world.presences.push_back(presence);
  }
}

std::uint16_t highest_instance(const Scene& scene) {
  std::uint16_t highest = 0;
  for (const SceneObject& object : scene.objects) highest = std::max(highest, object.instance);
  return highest;
}

void add_movers(const HomeOptions& home, MovingHome& world) {
  Random random(home.seed, kPurpose);
  MoverOptions options;
  options.seed = home.seed;
  options.people = home.rooms == 1 ? 1 + (random.chance(0.5) ? 1 : 0) : random.integer(2, 3);
  const double pet = random.uniform();
  options.cats = pet < 0.35 ? 1 : 0;
  options.dogs = pet >= 0.35 && pet < 0.6 ? 1 : 0;
  options.first_instance = static_cast<std::uint16_t>(highest_instance(world.home.scene) + 1);
  std::vector<TrueSeat> seats = home_truth(world.home, home).seats;
  std::erase_if(seats, [&](const TrueSeat& seat) {
    return std::any_of(world.changes.begin(), world.changes.end(),
                       [&](const Change& change) { return change.instance == seat.instance; });
  });
  world.movers = plan_movers(world.home, seats, world.path, options);
}

}  // namespace

const std::vector<std::string>& dynamics_names() {
  static const std::vector<std::string> kNames = {"static", "people", "changes", "busy"};
  return kNames;
}

Dynamics dynamics_of(const std::string& name) {
  const auto& names = dynamics_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw Error(fmt::format("there are no dynamics '{}'; choose one of {}", name, fmt::join(names, ", ")));
  return static_cast<Dynamics>(found - names.begin());
}

std::size_t MovingHome::presence_at(std::size_t frame) const {
  return static_cast<std::size_t>(std::upper_bound(starts.begin(), starts.end(), frame) - starts.begin());
}

std::vector<Figure> MovingHome::figures_at(std::size_t frame) const {
  std::vector<Figure> figures;
  for (const Mover& mover : movers) figures.push_back(mover.figure_at(frame));
  return figures;
}

MovingHome make_moving_home(const MovingHomeOptions& options, const Catalogue& catalogue, const Camera& camera) {
  const bool has_changes = options.dynamics == Dynamics::kChanges || options.dynamics == Dynamics::kBusy;
  const bool has_people = options.dynamics == Dynamics::kPeople || options.dynamics == Dynamics::kBusy;
  MovingHome world;
  world.home = make_home(options.home, catalogue);
  world.path = make_camera_path(world.home, {options.home.seed, options.frames, has_changes ? 2 : 1});
  if (has_changes) world.changes = plan_changes(options.home.seed, world.path, camera, world.home);
  make_presences(world);
  if (has_people) add_movers(options.home, world);
  return world;
}

Home final_home(const MovingHome& world) {
  Home home;
  home.rooms = world.home.rooms;
  home.doorways = world.home.doorways;
  home.wall_height_m = world.home.wall_height_m;
  home.scene.models = world.home.scene.models;
  home.scene.materials = world.home.scene.materials;
  home.scene.lamps = world.home.scene.lamps;
  for (std::size_t i = 0; i < world.home.scene.objects.size(); ++i) {
    if (world.presences.back()[i] != 0) home.scene.objects.push_back(world.home.scene.objects[i]);
  }
  return home;
}

LabelSet labels_of(const MovingHome& world) {
  LabelSet labels = load_label_set("scannet20");
  if (world.movers.empty()) return labels;
  std::vector<LabelClass> classes = labels.classes();
  classes.push_back({kPersonClass, "person", true, {214, 39, 40}, 2.2, false, true});
  classes.push_back({kCatClass, "cat", true, {255, 127, 80}, 1.0, false, true});
  classes.push_back({kDogClass, "dog", true, {205, 92, 92}, 1.6, false, true});
  return {"scannet20 with people and pets", std::move(classes)};
}

}  // namespace panoptic
