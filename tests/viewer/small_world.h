// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Snapshots of a small map: a ball over a floor, eight blocks and more of them, so that there are borders between chunks.
#pragma once

#include <memory>
#include <utility>

#include "panoptic/labels.h"
#include "panoptic/mapping/snapshot.h"
#include "panoptic/meshing/mesher.h"
#include "tests/fusion/small_maps.h"

namespace panoptic::test {

inline LabelSet small_labels() {
  return {"small", {{ClassId{1}, "floor", false, {200, 180, 160}}, {ClassId{2}, "swivel chair", true, {31, 119, 180}}}};
}

inline constexpr LabelSlot kBallSlot{3};  // LabelSet::first_thing() of small_labels
inline constexpr PanopticId kBallId{3'000'000'003};

// With the ball, whose id has 32 bits.
inline ObjectRegistry small_objects() {
  ObjectRegistry objects(number(kBallSlot));
  objects.create();
  RegistryState state = objects.state();
  state.objects[0].id = kBallId;
  return {number(kBallSlot), std::move(state)};
}

class SmallWorld {
 public:
  SmallWorld() : map_(small_labels(), VoxelMap(MapOptions{}), small_objects()), mesher_(MesherOptions{}) {
    const Solid ball{[](const Vec3d& p) { return (p - Vec3d(0.02, 0.2, 0.01)).norm() - 0.3; }, kBallSlot};
    const Solid floor = solid_ground(Vec3d::UnitY(), -0.25, pid(1));
    add_solids(map_.voxels, {ball, floor}, Vec3d::Constant(-0.6), Vec3d::Constant(0.6));
    mesher_.update(map_);
    for (Slot slot = 0; slot < map_.voxels.block_count(); ++slot) {
      chunks_.push_back({map_.voxels.index_of(slot), 1, mesher_.chunks()[slot]});
    }
  }

  // The next revision, with a frame and an object.
  std::shared_ptr<Snapshot> snapshot() {
    auto s = std::make_shared<Snapshot>();
    s->revision = ++revision_;
    s->chunks = chunks_;
    SnapshotObject ball;
    ball.id = kBallId;
    ball.class_id = ClassId{2};
    ball.probabilities = {{ClassId{1}, 0.25F}, {ClassId{2}, 0.75F}};
    ball.vertices = 100;
    ball.max_m = Vec3f(1, 2, 3);
    s->objects = {ball};
    s->path_m = {Vec3f(0, 0, 0), Vec3f(0.5F, 0, 0)};
    s->up = Vec3f(0, 1, 0);
    s->frame.index = static_cast<std::int64_t>(revision_);
    s->frame.color_camera = {4, 2, 3, 3, 1.5, 0.5};
    s->frame.color = std::make_shared<const SharedImage<Rgb>>(Image<Rgb>(4, 2, Rgb{200, 100, 50}));
    s->frame.labelled_color = s->frame.color;
    auto ids = std::make_shared<Image<PanopticId>>(4, 2);
    (*ids)(1, 0) = kBallId;
    s->frame.labelled_ids = std::move(ids);
    s->run.stages["fusion"] = {10, 1, 2, 3};
    return s;
  }

  // The chunk of that place in the next snapshots is `surface`, new in the next one.
  void replace(std::size_t chunk, std::shared_ptr<const MeshChunk> surface) {
    chunks_[chunk].surface = std::move(surface);
    chunks_[chunk].version = revision_ + 1;
  }

  SnapshotScene scene() const {
    return {"small", "made for a test", small_labels(), map_.voxels.voxel_size_m(), map_.voxels.block_size_m()};
  }
  const PanopticMap& map() const { return map_; }
  const Mesher& mesher() const { return mesher_; }

 private:
  PanopticMap map_;
  Mesher mesher_;
  std::vector<SnapshotChunk> chunks_;
  std::uint64_t revision_ = 0;
};

}  // namespace panoptic::test
