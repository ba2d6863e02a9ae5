// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "panoptic/parallel.h"
#include "panoptic/sim/moving_home.h"
#include "panoptic/sim/sensor_noise.h"
#include "panoptic/sim/surfaces.h"
#include "panoptic/sim/view_log.h"

namespace panoptic {
namespace {

constexpr int kWidth = 80;
constexpr int kHeight = 60;

Eigen::AlignedBox3d box_of(const SceneObject& object, const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (const Vec3f& position : scene.models[object.model].positions) box.extend(world_point(object, position).cast<double>());
  return box;
}

// A thing by itself, which says where it would be seen if it were there.
class Ghost {
 public:
  Ghost(const Scene& scene, std::uint32_t object) {
    scene_.models = {scene.models[scene.objects[object].model]};
    scene_.materials = scene.materials;
    for (Material& material : scene_.materials) material.texture = -1;
    scene_.objects = {scene.objects[object]};
    scene_.objects.front().model = 0;
    renderer_ = std::make_unique<Renderer>(scene_);
  }

  // Pixels that would show it, near enough to count.
  int shown_px(const Camera& camera, const Pose& world_from_camera, const Glance& rest) const {
    constexpr float kBehind_m = 0.02F;
    const Glance alone = renderer_->look(camera, world_from_camera);
    int pixels = 0;
    for (std::size_t i = 0; i < alone.depth.size(); ++i) {
      const float depth_m = alone.depth[i];
      if (depth_m <= 0 || static_cast<double>(depth_m) >= kShown_m) continue;
      if (rest.depth[i] <= 0 || depth_m < rest.depth[i] + kBehind_m) ++pixels;
    }
    return pixels;
  }

 private:
  Scene scene_;
  std::unique_ptr<Renderer> renderer_;
};

PlaceViews views_of(const std::vector<std::uint8_t>& shown, std::size_t change_frame) {
  PlaceViews views;
  for (std::size_t frame = 0; frame < shown.size(); ++frame) {
    if (shown[frame] == 0) continue;
    (frame < change_frame ? views.before : views.after) += 1;
    if (frame >= change_frame && !views.first_after) views.first_after = static_cast<std::int64_t>(frame);
  }
  return views;
}

// Per frame, whether enough is to be seen of each of these objects, there or not.
std::map<std::uint32_t, std::vector<std::uint8_t>> shown_frames(const MovingHome& world, const Renderer& renderer,
                                                                const Camera& camera, const std::vector<std::uint32_t>& objects) {
  constexpr auto kEnough_px = static_cast<int>(kEnoughOfPicture * kWidth * kHeight);
  const Camera small = resized(camera, kWidth, kHeight);
  std::vector<std::unique_ptr<Ghost>> ghosts;
  for (const std::uint32_t object : objects) ghosts.push_back(std::make_unique<Ghost>(world.home.scene, object));
  std::vector<std::vector<std::uint8_t>> shown(world.path.size());
  parallel_for(world.path.size(), [&](std::size_t frame) {
    const Glance glance = renderer.look(small, world.path[frame], world.presence_at(frame));
    for (const auto& ghost : ghosts) {
      shown[frame].push_back(ghost->shown_px(small, world.path[frame], glance) >= kEnough_px ? 1 : 0);
    }
  });
  std::map<std::uint32_t, std::vector<std::uint8_t>> by_object;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    for (const auto& frame : shown) by_object[objects[i]].push_back(frame[i]);
  }
  return by_object;
}

void add_changes(const MovingHome& world, const Renderer& renderer, const Camera& camera, const LabelSet& labels,
                 DynamicsTruth& truth) {
  std::vector<std::uint32_t> objects;
  for (const Change& change : world.changes) {
    if (change.before) objects.push_back(*change.before);
    if (change.after) objects.push_back(*change.after);
  }
  const auto shown = shown_frames(world, renderer, camera, objects);
  const Scene& scene = world.home.scene;
  for (const Change& change : world.changes) {
    TrueChange it;
    it.frame = static_cast<std::int64_t>(change.frame);
    it.kind = change.kind;
    it.instance = change.instance;
    const std::uint32_t any = change.before ? *change.before : *change.after;
    it.class_name = labels.name_of(scene.objects[any].class_id);
    if (change.before) {
      it.old_box = box_of(scene.objects[*change.before], scene);
      it.old_place = views_of(shown.at(*change.before), change.frame);
    }
    if (change.after) {
      it.new_box = box_of(scene.objects[*change.after], scene);
      it.new_place = views_of(shown.at(*change.after), change.frame);
    }
    truth.changes.push_back(std::move(it));
  }
}

void add_things(const MovingHome& world, const LabelSet& labels, DynamicsTruth& truth) {
  const Scene& scene = world.home.scene;
  std::map<std::uint16_t, std::size_t> thing_of;
  for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    if (object.instance == 0) continue;
    const auto [found, is_new] = thing_of.try_emplace(object.instance, truth.things.size());
    if (is_new)
      truth.things.push_back({object.instance, object.class_id, std::string(labels.name_of(object.class_id)), object.name, {}});
    TrueStay stay;
    stay.last_frame = truth.frames - 1;
    stay.world_from_object = object.world_from_object;
    stay.box = box_of(object, scene);
    for (const Change& change : world.changes) {
      if (change.after == i) stay.first_frame = static_cast<std::int64_t>(change.frame);
      if (change.before != i) continue;
      stay.last_frame = static_cast<std::int64_t>(change.frame) - 1;
      stay.ended_by = change.kind;
    }
    truth.things[found->second].stays.push_back(stay);
  }
}

const char* name_of(Activity activity) {
  switch (activity) {
    case Activity::kStanding:
      return "standing";
    case Activity::kWalking:
      return "walking";
    case Activity::kSitting:
      return "sitting";
    case Activity::kLying:
      return "lying";
  }
  return "";
}

}  // namespace

DynamicsTruth dynamics_truth(const MovingHome& world, const Renderer& renderer, const Camera& camera,
                             const std::string& dynamics) {
  const LabelSet labels = labels_of(world);
  DynamicsTruth truth;
  truth.dynamics = dynamics;
  truth.rate_hz = kFrameRate_hz;
  truth.frames = static_cast<std::int64_t>(world.path.size());
  add_things(world, labels, truth);
  add_changes(world, renderer, camera, labels, truth);
  for (const Mover& mover : world.movers) {
    TrueMover it{mover.instance, class_of(mover.body.kind), std::string(labels.name_of(class_of(mover.body.kind))), {}};
    for (std::size_t frame = 0; frame < mover.poses.size(); ++frame) {
      it.frames.push_back({static_cast<std::int64_t>(frame), name_of(mover.activities[frame]), box_of(mover.figure_at(frame))});
    }
    truth.movers.push_back(std::move(it));
  }
  return truth;
}

}  // namespace panoptic
