// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/session/session.h"

#include <algorithm>
#include <utility>

#include "panoptic/base/error.h"
#include "panoptic/fusion/map_division.h"
#include "panoptic/fusion/object_views.h"
#include "panoptic/fusion/reference_labels.h"
#include "panoptic/predict/predictor_files.h"

namespace panoptic {
namespace {

// Copying a submap holds mapping up, so they are no larger than this, whatever regularizer.max_blocks says.
constexpr std::size_t kMostBlocksAtOnce = 64;
constexpr const char* kDefaultLabels = "indoor";
constexpr const char* kNoReading = "no depth reading between depth.min_m and depth.max_m";

}  // namespace

Session::Session(const Options& options, LabelSet labels)
    : map_(options.map, std::move(labels)),
      registration_(options.depth),
      tracker_(options.tracker, map_.labels),
      integrator_(options.integrator, map_.voxels, map_.labels.first_thing()),
      maintain_every_(static_cast<std::uint64_t>(options.objects.every_frames)),
      maintenance_(options.objects, map_.labels),
      regularizes_(options.regularizer.enabled),
      regularize_every_(static_cast<std::uint64_t>(options.regularizer.every_frames)),
      regularizer_(options.regularizer, map_.voxels),
      mesher_(options.mesher) {
  if (options.depth.min_m >= options.depth.max_m) {
    throw Error("depth.min_m is not below depth.max_m: no reading would be left; swap or correct them");
  }
  const double map_edge_m = double{map_.voxels.block_size_m()} * (kMaxBlockCoordinate - 2) - options.depth.max_m * 2.0;
  farthest_camera_m_ = map_edge_m;
}

// How long the stages of one frame take, and their sum "fusion".
class Session::Stages {
 public:
  explicit Stages(Profile& profile) : profile_(profile) {}
  void done(const char* name) {
    profile_.add(name, stopwatch_.seconds() - before_s_);
    before_s_ = stopwatch_.seconds();
  }
  void all_done(const char* name) { profile_.add(name, stopwatch_.seconds()); }

 private:
  Profile& profile_;
  Stopwatch stopwatch_;
  double before_s_ = 0;
};

std::optional<std::string> Session::why_refused(const Frame& frame, const Segmentation& segmentation) const {
  if (std::optional<std::string> reason = why_unusable(frame)) return reason;
  if (const char* why = why_unusable(segmentation, frame.color.width(), frame.color.height())) return why;
  if (frame.world_from_camera.translation().cwiseAbs().maxCoeff() > farthest_camera_m_) {
    return "pose lies farther out than a map reaches";
  }
  return std::nullopt;
}

std::optional<std::string> Session::why_unfit(const Frame& frame, const RegisteredFrame& registered) {
  if (registered.readings == 0) return kNoReading;
  return integrator_.why_too_large(frame, registered, map_.voxels);
}

std::optional<std::string> Session::add(const Frame& frame, const Segmentation& segmentation) {
  if (std::optional<std::string> reason = why_refused(frame, segmentation)) {
    skip({frame.index, *reason});
    return reason;
  }
  if (map_.objects.wants_retirement()) retire_objects();

  Stages stages(profile_);
  const RegisteredFrame& registered = registration_.apply(frame, segmentation);
  if (std::optional<std::string> reason = why_unfit(frame, registered)) {
    skip({frame.index, *reason});
    return reason;
  }
  stages.done("register");
  const auto& ids = track(frame, segmentation, registered, stages);
  integrator_.integrate(frame, registered, ids, map_.voxels);  // Eq. 6-11
  stages.done("integrate");
  stages.all_done("fusion");

  count_frame(frame);
  count_labels(segmentation);
  if (frames_.used() % regularize_every_ == 0) regularize();
  return std::nullopt;
}

std::optional<std::string> Session::add_geometry(const Frame& frame) {
  Stages stages(profile_);
  std::optional<std::string> reason = why_refused(frame, {});
  const RegisteredFrame* registered = reason ? nullptr : &registration_.apply(frame, {});
  if (registered != nullptr) reason = why_unfit(frame, *registered);
  if (reason) {
    skip({frame.index, *reason});
    return reason;
  }
  stages.done("register");
  no_votes_.assign(registered->segment.size(), LabelSlot::kNoVote);
  integrator_.integrate(frame, *registered, no_votes_, map_.voxels);  // Eq. 6-8
  stages.done("integrate");
  stages.all_done("fusion");
  count_frame(frame);
  return std::nullopt;
}

std::optional<std::string> Session::add_labels(const Frame& frame, const Segmentation& segmentation) {
  if (std::optional<std::string> reason = why_refused(frame, segmentation)) return reason;
  if (map_.objects.wants_retirement()) retire_objects();
  Stages stages(profile_);
  const RegisteredFrame& registered = registration_.apply(frame, segmentation);
  if (std::optional<std::string> reason = why_unfit(frame, registered)) return reason;
  stages.done("register labels");
  const auto& ids = track(frame, segmentation, registered, stages);
  integrator_.integrate_labels(frame, registered, ids, map_.voxels);  // Eq. 9-11
  stages.done("integrate labels");
  stages.all_done("label fusion");
  count_labels(segmentation);
  return std::nullopt;
}

const std::vector<LabelSlot>& Session::track(const Frame& frame, const Segmentation& segmentation,
                                             const RegisteredFrame& registered, Stages& stages) {
  reference_labels(map_.voxels, frame, registered, reference_);  // Eq. 2
  stages.done("reference");
  const auto& ids = tracker_.assign(registered, segmentation.segments, reference_, frame.index, map_.objects);  // Eq. 3-5, 12
  record_views(segmentation, {frame.index, tracker_.segment_ids(), tracker_.segment_areas_px()}, map_.objects);
  stages.done("track");
  return ids;
}

void Session::count_frame(const Frame& frame) {
  up_sum_ -= frame.world_from_camera.linear().col(1);
  last_frame_ = frame.index;
  frames_.count_used({frame.time_s, frame.world_from_camera});
}

void Session::count_labels(const Segmentation& segmentation) {
  ++label_frames_;
  if (!segmentation.segment_at.empty()) ++labelled_;
  note_together();
  if (label_frames_ % maintain_every_ != 0) return;
  const Stopwatch maintaining;
  maintenance_.run(map_.voxels, map_.objects, regularizer_.votes(), so_far());
  profile_.add("maintain", maintaining.seconds());
}

void Session::note_together() {
  std::vector<PanopticId> seen;
  for (std::size_t s = 0; s < tracker_.segment_ids().size(); ++s) {
    const Object* object = map_.objects.find(tracker_.segment_ids()[s]);
    if (object != nullptr && tracker_.segment_areas_px()[s] > 0) seen.push_back(object->id);
  }
  maintenance_.saw_together(seen);
}

std::vector<PanopticId> Session::segment_ids() const {
  std::vector<PanopticId> ids;
  for (const LabelSlot slot : tracker_.segment_ids()) ids.push_back(map_.objects.id_of(slot));
  return ids;
}

// An object whose last voxel was overruled lives on as long as frames voted for it: its surroundings may come to take its side.
// Covisibility names objects by their ids, and so does what was gathered (now_called), so neither holds a slot.
void Session::retire_objects() {
  std::vector<bool> in_use = ids_in_use(map_.voxels);
  regularizer_.votes().add_in_use(in_use);
  map_.objects.retire_unused(in_use, regularizer_.named_slots());
}

void Session::regularize() {
  if (!regularizes_) return;
  const Stopwatch stopwatch;
  if (regularizer_.run(map_.voxels) > 0) retire_objects();
  profile_.add("regularize", stopwatch.seconds());
}

std::vector<std::vector<Slot>> Session::choose_submaps() {
  if (!regularizes_) return {};
  std::vector<std::vector<Slot>> submaps;
  for (const std::vector<Slot>& blocks : regularizer_.choose(map_.voxels)) {
    if (blocks.size() <= kMostBlocksAtOnce) {
      submaps.push_back(blocks);
    } else {
      for (std::vector<Slot>& part : divide_map(map_.voxels, blocks, kMostBlocksAtOnce)) submaps.push_back(std::move(part));
    }
  }
  return submaps;
}

SubmapGraph Session::gather(const std::vector<Slot>& blocks) const {
  SubmapGraph submap = regularizer_.gather(map_.voxels, blocks);
  submap.next_id = map_.objects.next_id();
  return submap;
}

// The label now of what a label named when `next_id` was the registry's. Nothing if the object is no more, or if its slot was
// given anew since.
std::optional<std::uint16_t> Session::now_called(std::uint16_t label, PanopticId next_id) const {
  const auto slot = static_cast<LabelSlot>(label);
  if (!map_.labels.is_object(slot)) return label;
  const PanopticId id = map_.objects.named_by(slot);
  const Object* object = map_.objects.find(map_.objects.survivor(id));
  return object == nullptr || id >= next_id ? std::nullopt : std::optional(number(object->slot));
}

void Session::write_back(SubmapChanges changes) {
  std::erase_if(changes.changes, [&](LabelChange& change) {
    CoreVoxel& before = change.before;
    const auto held = now_called(before.held.label, changes.next_id);
    const auto voted = now_called(before.voted.label, changes.next_id);
    const auto label = now_called(change.label.label, changes.next_id);
    if (!held || !voted || !label) return true;
    before.held.label = *held;
    before.voted.label = *voted;
    change.label.label = *label;
    if (change.label.label == before.voted.label) change.label.weight = std::min(before.voted.weight, before.vote_sum);
    return change.label.label == before.held.label;
  });
  map_.voxels.begin_epoch();
  regularizer_.write_back(changes, map_.voxels);
}

void Session::finish() {
  const Stopwatch maintaining;
  maintenance_.finish(map_.voxels, map_.objects, regularizer_.votes(), so_far());
  profile_.add("maintain", maintaining.seconds());
  regularize();
  forget_votes_without_voxels();
}

void Session::forget_votes_without_voxels() {
  const std::vector<bool> in_use = ids_in_use(map_.voxels);
  regularizer_.votes().forget_unused(in_use);
  map_.objects.retire_unused(in_use, regularizer_.named_slots());
}

const std::vector<std::shared_ptr<const MeshChunk>>& Session::surface() {
  const Stopwatch stopwatch;
  mesher_.update(map_);
  profile_.add("mesh", stopwatch.seconds());
  return mesher_.chunks();
}

Mesh Session::mesh() {
  const Stopwatch stopwatch;
  mesher_.update(map_);
  Mesh mesh = mesher_.assemble(map_);
  profile_.add("mesh", stopwatch.seconds());
  return mesh;
}

SessionState Session::state() const {
  return {maintenance_.seen_together(), regularizer_.state(), frames_, label_frames_, labelled_, up_sum_, last_frame_};
}

void Session::restore(PanopticMap map, SessionState state) {
  map_ = std::move(map);
  maintenance_.restore(std::move(state.together));
  regularizer_.restore(std::move(state.regularizer));
  frames_ = std::move(state.frames);
  label_frames_ = state.label_frames;
  labelled_ = state.labelled;
  up_sum_ = state.up_sum;
  last_frame_ = state.last_frame;
}

Vec3d Session::up() const { return up_sum_.norm() > 0 ? Vec3d(up_sum_.normalized()) : Vec3d(-Vec3d::UnitY()); }

std::unique_ptr<Predictor> make_predictor(const Options& options) {
  const bool networks = !options.networks.semantic.empty() || !options.networks.instance.empty();
  if (!options.predictions.empty() && networks) {
    throw Error("both a prediction folder and networks are given; choose one");
  }
  const auto labels = options.labels.empty() ? std::nullopt : std::optional(load_label_set(options.labels));
  if (!options.predictions.empty()) {
    return make_file_predictor(options.predictions, labels, options.networks.segmentation.keep_whole_classes);
  }
  if (networks) return make_network_predictor(options.networks, labels.value_or(load_label_set(kDefaultLabels)));
  return nullptr;
}

LabelSet labels_of(const Options& options, const Predictor* predictor) {
  if (predictor != nullptr) return predictor->labels();
  return load_label_set(options.labels.empty() ? kDefaultLabels : options.labels);
}

}  // namespace panoptic
