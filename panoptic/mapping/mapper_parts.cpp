// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/mapper_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "panoptic/base/memory.h"
#include "panoptic/error.h"
#include "panoptic/fusion/reference_labels.h"
#include "panoptic/map/block_pager.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/objects/object_views.h"
#include "panoptic/profile.h"
#include "panoptic/surface.h"

namespace panoptic {
namespace {

constexpr double kFramesPerSecond = 30;  // of frames that come without times

constexpr std::size_t kMegabyte = 1'000'000;

FrameLog empty_log(const MapOptions& options) {
  const bool copies = options.log == "copy";
  const bool logs = copies || options.log == "reference";
  return FrameLog(logs ? static_cast<std::size_t>(options.log_limit_mb) * kMegabyte : 0,
                  copies ? LoggedCopies::kInMemory : LoggedCopies::kNone);
}

}  // namespace

MapperParts::MapperParts(const Options& options, LabelSet labels, ReplacedStages replaced)
    : options_(checked(options)),
      map_(options.map, std::move(labels)),
      replaced_(std::move(replaced)),
      registration_(options.depth),
      tracker_(options.tracker, map_.labels),
      integrator_(options.integrator, map_.voxels, map_.labels.first_thing()),
      space_(options.map, options.carving),
      motion_mask_(options.moving),
      knows_presence_(options.moving.objects),
      maintenance_(options.objects),
      regularizer_(options.regularizer, map_.voxels),
      mesher_(options.mesher),
      regularizes_(options.regularizer.enabled),
      tasks_{{"maintain", Counted::kLabelFrame, static_cast<std::uint64_t>(options.objects.every_frames), &MapperParts::maintain},
             {"regularize", Counted::kFrame, static_cast<std::uint64_t>(options.regularizer.every_frames),
              &MapperParts::regularize_changes}},
      log_(empty_log(options.map)) {
  if (!regularizes_) tasks_.pop_back();
  farthest_camera_m_ = double{map_.voxels.block_size_m()} * (kMaxBlockCoordinate - 2) - options.depth.max_m * 2.0;
}

Outcome MapperParts::add(const Frame& frame, const Segmentation& segmentation) {
  StageTimer timer(profile_);
  const Accepted accepted = accept(frame, segmentation, timer);
  if (accepted.registered == nullptr) return count_refused(frame, accepted.outcome);
  const auto labels = associate({frame, segmentation, *accepted.registered}, timer);  // Eq. 2-5, 12
  integrator_.integrate(frame, *accepted.registered, labels, map_.voxels);            // Eq. 6-11
  timer.done("integrate");
  see_space(frame, *accepted.registered);
  timer.done("free space");
  timer.all_done("fusion");
  if (replaced_.labelled) replaced_.labelled({frame, segmentation, *accepted.registered}, labels);

  count_frame(frame);
  count_labels(frame, segmentation);
  run_due_tasks(Counted::kLabelFrame);
  run_due_tasks(Counted::kFrame);
  return {};
}

Outcome MapperParts::add_geometry(const Frame& frame) {
  StageTimer timer(profile_);
  const Accepted accepted = accept(frame, {}, timer);
  if (accepted.registered == nullptr) return count_refused(frame, accepted.outcome);
  no_votes_.assign(accepted.registered->segment.size(), LabelSlot::kNoVote);
  integrator_.integrate(frame, *accepted.registered, no_votes_, map_.voxels);  // Eq. 6-8
  timer.done("integrate");
  see_space(frame, *accepted.registered);
  timer.done("free space");
  timer.all_done("fusion");
  count_frame(frame);
  return {};
}

Outcome MapperParts::add_labels(const Frame& given, const Segmentation& segmentation) {
  StageTimer timer(profile_);
  Frame frame = given;
  frame.world_from_camera = pose_of(given);
  const Accepted accepted = accept(frame, segmentation, timer, "register labels");
  if (accepted.registered == nullptr) return accepted.outcome;
  const FrameToLabel to_label{frame, segmentation, *accepted.registered};
  const auto labels = associate(to_label, timer);
  integrator_.integrate_labels(frame, *accepted.registered, labels, map_.voxels);  // Eq. 9-11
  timer.done("integrate labels");
  timer.all_done("label fusion");
  if (replaced_.labelled) replaced_.labelled(to_label, labels);

  count_labels(frame, segmentation);
  run_due_tasks(Counted::kLabelFrame);
  return {};
}

// Every check of a frame, and colour and segments registered to its depth.
MapperParts::Accepted MapperParts::accept(const Frame& frame, const Segmentation& segmentation, StageTimer& timer,
                                          const char* stage) {
  Accepted accepted{check_frame(frame, segmentation)};
  if (!accepted.outcome.used) return accepted;
  timer.restart();
  RegisteredFrame& registered = registration_.apply(frame, segmentation);
  accepted.outcome = registered.readings > 0 ? integrator_.check_extent(frame, registered, map_.voxels)
                                             : Outcome::refused("no depth reading between depth.min_m and depth.max_m");
  if (!accepted.outcome.used) return accepted;
  timer.done(stage);
  const bool looked = !segmentation.segment_at.empty();
  moving_ = &motion_mask_.take_out(frame, segmentation, map_, moving_tracks_.expected(frame.time_s, looked), registered);
  moving_tracks_.add(moving_->things, frame.index, frame.time_s, looked);
  timer.done("moving");
  accepted.registered = &registered;
  return accepted;
}

Outcome MapperParts::check_frame(const Frame& frame, const Segmentation& segmentation) const {
  if (Outcome outcome = check(frame); !outcome.used) return outcome;
  if (frame.world_from_camera.translation().cwiseAbs().maxCoeff() > farthest_camera_m_) {
    return Outcome::refused("pose lies farther out than a map reaches");
  }
  if (Outcome outcome = check_classes(segmentation, map_.labels); !outcome.used) return outcome;
  return check(segmentation, frame.color.width(), frame.color.height());
}

Outcome MapperParts::count_refused(const Frame& frame, Outcome outcome) {
  skip({frame.index, outcome.reason});
  return outcome;
}

std::span<const LabelSlot> MapperParts::associate(const FrameToLabel& to_label, StageTimer& timer) {
  prune_if_due();
  association_ = replaced_.associate ? replaced_.associate(to_label, map_) : track(to_label, timer);
  record_views(to_label.segmentation, {to_label.frame.index, association_.segment_ids, association_.segment_areas_px},
               map_.objects);
  timer.done("track");
  return association_.labels;
}

Association MapperParts::track(const FrameToLabel& to_label, StageTimer& timer) {
  const auto& [frame, segmentation, registered] = to_label;
  reference_labels(map_.voxels, frame, registered, reference_);  // Eq. 2
  timer.done("reference");
  const auto& labels = tracker_.assign(registered, segmentation.segments, reference_, frame.index, map_.objects);
  return {labels, tracker_.segment_ids(), tracker_.segment_areas_px()};
}

ObjectPresence::FramesBefore MapperParts::frames_before(double time_s) const {
  const std::uint64_t now = frames_.used();
  const auto older_than = [&](double s) -> std::uint64_t {
    if (has_times(time_s)) return frames_.used_until(time_s - s);
    const auto frames = static_cast<std::uint64_t>(std::lround(s * kFramesPerSecond));
    return now >= frames ? now - frames + 1 : 0;
  };
  return {now, older_than(ObjectPresence::kStay_s), older_than(ObjectPresence::kLongestGap_s)};
}

bool MapperParts::has_times(double newest_s) const {
  return frames_.trajectory().empty() || newest_s > frames_.trajectory().front().time_s;
}

double MapperParts::seconds_of(std::int64_t frame) const {
  const bool knows = !frames_.trajectory().empty() && has_times(frames_.trajectory().back().time_s);
  return knows ? frames_.time_of(frame) : static_cast<double>(frame) / kFramesPerSecond;
}

// Nothing is known any longer of what is carved, neither what the regularizer wrote there nor what frames voted for.
void MapperParts::see_space(const Frame& frame, const RegisteredFrame& registered) {
  const std::vector<CellIndex> settled = presence_.settled(moving_->cells, frames_before(frame.time_s));
  const std::vector<CarvedVoxels>& carved = space_.see(frame, registered, frames_.used(), settled, map_);
  if (knows_presence_) presence_.came_up(space_.came_up(), frame.index);
  for (const CarvedVoxels& c : carved) {
    if (knows_presence_) presence_.looks_through(c.slot, c.brick, c.voxels, frame.index, map_);
    regularizer_.votes().forget(c.slot, c.brick, c.voxels);
  }
  clear(carved, map_.voxels);
}

void MapperParts::find_gone() {
  if (!knows_presence_) return;
  const auto least = static_cast<std::uint64_t>(options_.objects.min_observations);
  constexpr std::uint64_t kFramesPerObservation = 35;  // as in object maintenance
  presence_.find_gone({std::min(least, labelled_ / kFramesPerObservation + 1), finished_}, regularizer_.votes(), map_);
}

// Throws Error if the first frame, which has just been integrated, takes more than the limit allows: so would every other.
void MapperParts::check_memory() const {
  constexpr std::size_t kStep = 10'000'000;
  const BlockPager* pager = map_.voxels.pager();
  if (pager == nullptr || frames_.used() > 0 || tasks_.empty()) return;  // no tasks: it is made anew beside an older map
  const std::size_t least = pager->least_limit_bytes();
  if (pager->limit_bytes() >= least) return;
  throw Error(fmt::format("map.memory_limit_mb = {}, but already the first frame takes more; set it to {} at least, or 0",
                          pager->limit_bytes() / 1'000'000, (least + kStep / 2 + kStep - 1) / kStep * 10));
}

void MapperParts::count_frame(const Frame& frame) {
  check_memory();
  up_sum_ -= frame.world_from_camera.linear().col(1);
  last_frame_ = frame.index;
  frames_.count_used({frame.time_s, frame.world_from_camera, frame.index});
  log_.add(frame);
}

Pose MapperParts::pose_of(const Frame& frame) const {
  const auto n = times_anew_ > 0 && !log_.has_doubles() ? log_.find(frame.index) : std::nullopt;
  return n ? log_.entries()[*n].world_from_camera : frame.world_from_camera;
}

void MapperParts::count_labels(const Frame& frame, const Segmentation& segmentation) {
  ++label_frames_;
  note_covisible();
  if (segmentation.segment_at.empty()) return;
  ++labelled_;
  log_labels(frame, segmentation);
}

void MapperParts::log_labels(const Frame& frame, const Segmentation& segmentation) {
  std::vector<PanopticId> ids = segment_ids();
  for (std::size_t s = 0; s < ids.size(); ++s) {
    if (association_.segment_ids[s] == LabelSlot::kNoVote) ids[s] = LoggedLabels::kNoPlace;
  }
  log_.set_labels(frame.index, segmentation, ids);
}

void MapperParts::note_covisible() {
  std::vector<PanopticId> seen;
  for (std::size_t s = 0; s < association_.segment_ids.size(); ++s) {
    const Object* object = map_.objects.find(association_.segment_ids[s]);
    if (object != nullptr && association_.segment_areas_px[s] > 0) seen.push_back(object->id);
  }
  maintenance_.saw_together(seen);
}

std::vector<PanopticId> MapperParts::segment_ids() const {
  std::vector<PanopticId> ids;
  for (const LabelSlot slot : association_.segment_ids) ids.push_back(map_.objects.id_of(slot));
  return ids;
}

// One more was counted.
void MapperParts::run_due_tasks(Counted counted) {
  const std::uint64_t count = counted == Counted::kFrame ? frames_.used() : label_frames_;
  for (const Task& task : tasks_) {
    if (task.counted != counted || count % task.every != 0) continue;
    timed(task.stage, [&] { (this->*task.run)(); });
    if (map_.voxels.pager() != nullptr) give_back_free_memory();  // to the voxels
  }
}

void MapperParts::maintain() {
  find_gone();
  maintenance_.run(map_, regularizer_.votes(), so_far());
}

void MapperParts::regularize_changes() {
  if (regularizer_.run(map_.voxels) > 0) prune();
}

void MapperParts::regularize() {
  if (regularizes_) timed("regularize", [&] { regularize_changes(); });
}

void MapperParts::prune_if_due() {
  if (map_.objects.wants_retirement()) prune();
}

// An object whose last voxel was overruled lives on as long as frames voted for it: its surroundings may come to take its side.
// Covisibility names objects by their ids, and so does what was gathered (now_called), so neither holds a slot.
void MapperParts::prune() {
  find_gone();
  std::vector<bool> in_use = ids_in_use(map_.voxels);
  regularizer_.votes().add_in_use(in_use);
  map_.objects.retire_unused(in_use, regularizer_.named_slots());
}

void MapperParts::finish() {
  finished_ = true;
  give_back_free_memory();
  timed("maintain", [&] {
    find_gone();
    maintenance_.finish(map_, regularizer_.votes(), so_far());
    if (knows_presence_) presence_.find_arrivals([&](std::int64_t frame) { return seconds_of(frame); }, map_);
  });
  give_back_free_memory();
  regularize();
  forget_votes_without_voxels();
  give_back_free_memory();
}

void MapperParts::forget_votes_without_voxels() {
  const std::vector<bool> in_use = ids_in_use(map_.voxels);
  regularizer_.votes().forget_unused(in_use);
  map_.objects.retire_unused(in_use, regularizer_.named_slots());
}

const std::vector<std::shared_ptr<const MeshChunk>>& MapperParts::surface() {
  timed("mesh", [&] { mesher_.update(map_); });
  return mesher_.chunks();
}

Mesh MapperParts::mesh() {
  Mesh mesh;
  timed("mesh", [&] {
    mesher_.update(map_);
    mesh = mesher_.assemble(map_);
  });
  return mesh;
}

Mesh MapperParts::last_mesh() {
  if (!mesher_.chunks().empty()) return mesh();
  Mesh mesh;
  timed("mesh", [&] { mesh = surface_of(map_, mesher_.options()); });
  return mesh;
}

Vec3d MapperParts::up() const { return up_sum_.norm() > 0 ? Vec3d(up_sum_.normalized()) : Vec3d(-Vec3d::UnitY()); }

void MapperParts::StageTimer::restart() {
  stopwatch_ = Stopwatch();
  before_s_ = 0;
}

void MapperParts::StageTimer::done(const char* stage) {
  profile_.add(stage, stopwatch_.seconds() - before_s_);
  before_s_ = stopwatch_.seconds();
}

}  // namespace panoptic
