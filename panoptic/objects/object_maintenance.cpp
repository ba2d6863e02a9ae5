// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/object_maintenance.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "panoptic/objects/object_contacts.h"
#include "panoptic/objects/object_support.h"
#include "panoptic/objects/relabelling.h"

namespace panoptic {
namespace {

constexpr float kSmallestPiece_m2 = 0.008F;  // a cup seen from one side
constexpr double kSure = 0.75;               // support from which on no rule overrules an object
constexpr const char* kOther = "other";      // the class of things of no other class, if the label set has it

// How many surface voxels an area of surface takes: the band around it is three voxels wide.
std::size_t voxels_of(float area_m2, const VoxelMap& map) {
  constexpr float kLayers = 3;
  const float edge_m = map.voxel_size_m();
  return static_cast<std::size_t>(kLayers * area_m2 / (edge_m * edge_m));
}

// The length of what the voxels fill, as if they filled it evenly: stray ones hardly count.
double length_m(const SurfaceVoxels& surface, const std::vector<std::uint32_t>& voxels, double voxel_m) {
  Vec3d sum = Vec3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const std::uint32_t i : voxels) {
    const Vec3d p = place_m(surface[i], voxel_m);
    sum += p;
    squares += p * p.transpose();
  }
  const auto n = static_cast<double>(voxels.size());
  const Eigen::Matrix3d covariance = squares / n - sum * sum.transpose() / (n * n);
  const double variance = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues()[2];
  constexpr double kOfEvenSpread = 12;  // length^2 / variance
  return std::sqrt(kOfEvenSpread * std::max(0.0, variance));
}

// Did a frame ever say what this voxel is, be it "unknown"?
bool was_voted_on(const VoxelBlock& block, int offset) { return block.vote_sum(offset) > 0; }

// The blocks that changed after this epoch, and those around them as far as that.
std::vector<bool> blocks_near_changes(std::uint64_t epoch, double reach_m, const VoxelMap& map, const SurfaceVoxels& surface) {
  std::vector<bool> near(surface.block_count(), false);
  for (Slot slot = 0; slot < surface.block_count(); ++slot) near[slot] = map.changed_at(slot) > epoch;
  const auto rings = static_cast<int>(std::ceil(reach_m / double{map.block_size_m()}));
  for (int ring = 0; ring < rings; ++ring) {
    const std::vector<bool> inner = near;
    for (Slot slot = 0; slot < surface.block_count(); ++slot) {
      if (!inner[slot]) continue;
      for (const Slot beside : surface.neighbours_of(slot)) {
        if (beside != VoxelMap::kNoSlot) near[beside] = true;
      }
    }
  }
  return near;
}

std::vector<bool> labels_in(const std::vector<bool>& near, const SurfaceVoxels& surface) {
  std::vector<bool> labels(kLabelSlots, false);
  for (Slot slot = 0; slot < surface.block_count(); ++slot) {
    const auto [first, end] = near[slot] ? surface.range_of(slot) : std::pair(0U, 0U);
    for (std::uint32_t i = first; i < end; ++i) labels[number(surface.label(i))] = true;
  }
  return labels;
}

LabelSlot most_frequent(const std::map<LabelSlot, std::size_t>& counts) {
  return std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
}

}  // namespace

Fields fields(MaintenanceOptions& o) {
  constexpr int kMany = 1000000;
  return {{"enabled", &o.enabled, "object maintenance, between frames and at the end", {}},
          {"every_frames", &o.every_frames, "frames from one time to the next", in_range(1, kMany)},
          {"merge_share", &o.merge_share, "objects of a class are one if more than this share of the smaller is near the larger",
           in_range(0, 1)},
          {"merge_distance_m", &o.merge_distance_m, "how near that is", in_range(0, 1)},
          {"together_share", &o.together_share,
           "but not if both were seen at once in more than this share of the frames of the one seen less", in_range(0, 1)},
          {"carve", &o.carve, "what stands on a table is a thing of its own, also where no network knows it", {}},
          {"carve_height_m", &o.carve_height_m, "height above the table top from which on it is", in_range(0, 1)},
          {"floor_height_m", &o.floor_height_m, "level surface this near to the floor's plane is floor; 0 = off", in_range(0, 1)},
          {"min_observations", &o.min_observations,
           "objects seen in fewer frames are dropped at the end (in short recordings: in less than 1 of 35 labelled frames)",
           in_range(0, kMany)},
          {"min_certainty", &o.min_certainty, "unless it is as probable that any of their detections was right", in_range(0, 1)},
          {"min_thing_m2", &o.min_thing_m2, "things of no class with less surface are dropped at the end", in_range(0, 100)},
          {"min_region_m2", &o.min_region_m2, "unknown regions with at least this surface become things at the end",
           in_range(0, 10000)},
          {"stray_share", &o.stray_share, "pieces of an object below this share of its largest piece are dropped at the end",
           in_range(0, 1)},
          {"size_margin", &o.size_margin,
           "how much longer than its class can be an object may seem before it is of another class", in_range(1, 100)}};
}

void ObjectMaintenance::saw_together(std::span<const PanopticId> objects) {
  if (!options_.enabled) return;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) ++state_.covisible[std::minmax(objects[i], objects[j])];
  }
}

bool ObjectMaintenance::is_voted_on(const Pass& pass, std::uint32_t i) {
  const auto [slot, voxel] = pass.surface.place_of(i);
  return was_voted_on(pass.map.voxels.block(slot), voxel);
}

VoxelsByLabel ObjectMaintenance::objects_of(const Pass& pass) {
  return pass.surface.by_label([&](LabelSlot id) { return pass.map.objects.find(id) != nullptr; });
}

ObjectMaintenance::Pass ObjectMaintenance::begin(PanopticMap& map, FrameVotes& votes, const SoFar& so_far) {
  std::erase_if(state_.covisible, [&](const auto& entry) {  // of objects that are no more
    return map.objects.find(entry.first.first) == nullptr || map.objects.find(entry.first.second) == nullptr;
  });
  surface_.update(map.voxels);
  const double reach_m = std::max(kHighest_m, double{options_.merge_distance_m});
  std::vector<bool> changed = labels_in(blocks_near_changes(state_.epoch, reach_m, map.voxels, surface_), surface_);
  state_.epoch = map.voxels.epoch();
  map.voxels.begin_epoch();
  return {map, votes, surface_, vertical(map.voxels, surface_, so_far.up), so_far.frame, 0, std::move(changed)};
}

void ObjectMaintenance::run(PanopticMap& map, FrameVotes& votes, const SoFar& so_far) {
  if (!options_.enabled || so_far.labelled_frames == 0) return;
  Pass pass = begin(map, votes, so_far);
  merge(pass);
  if (options_.carve) carve_supports(pass);
  pass.surface.write_labels(map.voxels, votes);
}

void ObjectMaintenance::finish(PanopticMap& map, FrameVotes& votes, const SoFar& so_far) {
  constexpr std::uint64_t kFramesPerObservation = 35;
  if (!options_.enabled || so_far.labelled_frames == 0) return;
  Pass pass = begin(map, votes, so_far);
  pass.changed.assign(kLabelSlots, true);  // what waited for all evidence is due everywhere
  pass.min_observations = std::min(static_cast<std::uint64_t>(options_.min_observations),
                                   (so_far.labelled_frames + kFramesPerObservation - 1) / kFramesPerObservation);
  while (merge(pass)) {
  }
  drop_strays(pass);
  rule_out_by_size(pass);
  if (options_.floor_height_m > 0) level_floor(pass);
  drop_faint(pass, Judged::kAll);  // what stands on a table comes back as a thing without a class
  if (options_.carve) {
    carve_supports(pass);
    drop_faint(pass, Judged::kUnobserved);
  }
  name_unknown_regions(pass);
  name_others(pass);
  pass.surface.write_labels(map.voxels, votes);
  surface_ = SurfaceVoxels();  // hardly ever is there another time
}

bool ObjectMaintenance::are_apart(const Object& a, const Object& b) const {
  const auto found = state_.covisible.find(std::minmax(a.id, b.id));
  if (found == state_.covisible.end()) return false;
  const std::uint64_t seen = std::min(a.observations, b.observations);
  return static_cast<double>(found->second) > options_.together_share * static_cast<double>(seen);
}

// Every object takes part in one merge at most; the next time comes soon.
bool ObjectMaintenance::merge(Pass& pass) {
  const auto class_of = [&](LabelSlot id) {
    return pass.map.labels.is_object(id) ? pass.map.objects.class_of(id) : ClassId::kUnknown;
  };
  std::set<ClassId> due;
  for (std::size_t id = 0; id < kLabelSlots; ++id) {
    if (pass.changed[id]) due.insert(class_of(static_cast<LabelSlot>(id)));
  }
  std::map<ClassId, std::vector<LabelSlot>> by_class;
  const VoxelsByLabel voxels = pass.surface.by_label([&](LabelSlot id) {
    const ClassId class_id = class_of(id);
    const bool is_due = class_id != ClassId::kUnknown && due.contains(class_id);
    if (is_due) by_class[class_id].push_back(id);
    return is_due;
  });
  const int reach = std::max(1, static_cast<int>(std::lround(options_.merge_distance_m / pass.map.voxels.voxel_size_m())));
  Renaming renaming;
  std::set<LabelSlot> taken;
  for (const auto& [class_id, ids] : by_class) {
    for (const Contact& contact : contacts_between(ids, voxels, pass.surface, reach, options_.merge_share, pass.changed)) {
      if (taken.contains(contact.smaller) || taken.contains(contact.larger)) continue;
      if (are_apart(*pass.map.objects.find(contact.smaller), *pass.map.objects.find(contact.larger))) continue;
      taken.insert({contact.smaller, contact.larger});
      renaming.add(contact.smaller, contact.larger);
      pass.map.objects.merge(contact.smaller, contact.larger, pass.frame);
    }
  }
  if (taken.empty()) return false;
  Covisibility together;
  for (const auto& [pair, count] : state_.covisible) {
    const auto renamed = std::pair(pass.map.objects.survivor(pair.first), pass.map.objects.survivor(pair.second));
    if (renamed.first != renamed.second) together[std::minmax(renamed.first, renamed.second)] += count;
  }
  state_.covisible = std::move(together);
  renaming.apply(pass.map.voxels, pass.votes, pass.surface);
  return true;
}

void ObjectMaintenance::carve_supports(Pass& pass) const {
  // For every label, whether its object may be a part of something on a table; objects made here may.
  std::vector<bool> unnamed(kLabelSlots, true);
  for (std::size_t id = 1; id < pass.map.labels.first_thing(); ++id) unnamed[id] = false;
  const VoxelsByLabel supports = pass.surface.by_label([&](LabelSlot label) {
    const ClassId class_id = pass.map.class_of(label);
    if (class_id != ClassId::kUnknown) unnamed[number(label)] = false;
    return pass.map.labels.is_support(class_id);
  });
  for (const auto& [label, voxels] : supports) {
    if (voxels.size() < kFewestOfTop || !pass.changed[number(label)]) continue;
    for (const auto& part : pass.surface.components(voxels, 2)) {
      const auto top = fit_top(pass.map.voxels, pass.surface, part, pass.up);
      if (!top) continue;
      for (const auto& piece : pass.surface.components(things_on(pass, *top, label, unnamed), 1)) carve(pass, piece, label);
    }
  }
}

bool ObjectMaintenance::is_sure_part(const Pass& pass, std::uint32_t i) {
  const Object* object = pass.map.objects.find(pass.surface.label(i));
  return object != nullptr && is_sure(pass, *object, std::array{i});
}

std::vector<std::uint32_t> ObjectMaintenance::things_on(const Pass& pass, const SupportTop& top, LabelSlot support,
                                                        const std::vector<bool>& unnamed) const {
  const double voxel_m = pass.map.voxels.voxel_size_m();
  std::vector<std::uint32_t> things;
  for (Slot slot = 0; slot < pass.surface.block_count(); ++slot) {
    const auto [first, end] = pass.surface.range_of(slot);
    const auto corner = pass.surface.corner_of(slot);
    if (first == end || !may_stand_on(top, corner, voxel_m, options_.carve_height_m)) continue;
    const bool over = may_be_over(top, corner, voxel_m);
    for (std::uint32_t i = first; i < end; ++i) {
      const LabelSlot label = pass.surface.label(i);
      if (label != support && (!over || !unnamed[number(label)])) continue;
      if (label == LabelSlot::kUnknown && !is_voted_on(pass, i)) continue;
      const Vec3d p = place_m(pass.surface[i], voxel_m);
      if (!stands_on(top, p, options_.carve_height_m, label != support)) continue;
      if (label != support || !is_sure_part(pass, i)) things.push_back(i);
    }
  }
  return things;
}

// The piece joins the unnamed object that it holds most of, or becomes one.
void ObjectMaintenance::carve(Pass& pass, const std::vector<std::uint32_t>& piece, LabelSlot support) const {
  std::map<LabelSlot, std::size_t> owners;
  for (const std::uint32_t i : piece) {
    const LabelSlot label = pass.surface[i].label;
    if (pass.map.labels.is_object(label) && label != support) ++owners[label];
  }
  LabelSlot id = support;
  if (!owners.empty()) {
    id = most_frequent(owners);
  } else if (piece.size() >= voxels_of(kSmallestPiece_m2, pass.map.voxels)) {
    id = pass.map.objects.create(pass.frame).value_or(support);
  }
  for (const std::uint32_t i : piece) pass.surface.relabel(i, id);
}

void ObjectMaintenance::drop_strays(Pass& pass) const {
  std::vector<std::uint32_t> strays;
  for (const auto& [id, voxels] : objects_of(pass)) {
    const Object& object = *pass.map.objects.find(id);
    const auto pieces = pass.surface.components(voxels, 2);
    std::size_t largest = 0;
    for (const auto& piece : pieces) largest = std::max(largest, piece.size());
    for (const auto& piece : pieces) {
      if (static_cast<float>(piece.size()) >= options_.stray_share * static_cast<float>(largest)) continue;
      if (is_sure(pass, object, piece)) continue;
      strays.insert(strays.end(), piece.begin(), piece.end());
    }
  }
  fill_from_neighbours(std::move(strays), pass.map.voxels, pass.surface);
}

// Only where the evidence knows another class that fits: a wrong size alone may as well be a wrong outline.
void ObjectMaintenance::rule_out_by_size(Pass& pass) const {
  constexpr double kFaint = 0.03;
  constexpr double kAbsurd = 1.5;
  for (const auto& [id, voxels] : objects_of(pass)) {
    const Object* object = pass.map.objects.find(id);
    if (object->observations == 0 || is_sure(pass, *object, voxels)) continue;
    const double length = length_m(pass.surface, voxels, pass.map.voxels.voxel_size_m()) / options_.size_margin;
    std::set<ClassId> too_small;
    double most_that_fits = 0;
    for (const auto& [class_id, evidence] : object->evidence) {
      const LabelClass* c = pass.map.labels.find(class_id);
      if (c != nullptr && c->max_size_m > 0 && length > c->max_size_m) {
        too_small.insert(class_id);
      } else {
        most_that_fits = std::max(most_that_fits, evidence);
      }
    }
    const LabelClass* likeliest = pass.map.labels.find(pass.map.objects.class_of(id));
    const bool absurd = likeliest != nullptr && likeliest->max_size_m > 0 && length > kAbsurd * likeliest->max_size_m;
    if (absurd || most_that_fits >= kFaint * object->score_sum) pass.map.objects.rule_out(id, std::move(too_small));
  }
}

void ObjectMaintenance::level_floor(Pass& pass) const {
  constexpr double kLevel = 0.85;  // cosine of the slope
  const LabelClass* floor = pass.map.labels.find("floor");
  if (floor == nullptr) return;
  const LabelSlot id = LabelSet::of_class(floor->id);
  const VoxelsByLabel own = pass.surface.by_label([&](LabelSlot label) { return label == id; });
  const auto plane = own.empty() ? std::nullopt : fit_top(pass.map.voxels, pass.surface, own.at(id), pass.up);
  if (!plane) return;
  const std::vector<bool> sure = sure_objects(pass);
  for (std::uint32_t i = 0; i < pass.surface.size(); ++i) {
    if (sure[number(pass.surface.label(i))]) continue;
    const double height = plane->height_above(place_m(pass.surface[i], pass.map.voxels.voxel_size_m()));
    if (std::abs(height) > options_.floor_height_m) continue;
    if (normal_of(pass.map.voxels, pass.surface[i]).dot(pass.up) > kLevel) pass.surface.relabel(i, id);
  }
}

bool ObjectMaintenance::is_sure(const Pass& pass, const Object& object, std::span<const std::uint32_t> voxels) {
  return support(object, votes_in(pass.map.voxels, pass.surface, voxels)) >= kSure;
}

std::vector<bool> ObjectMaintenance::sure_objects(const Pass& pass) {
  std::vector<bool> sure(kLabelSlots, false);
  for (const auto& [id, voxels] : objects_of(pass)) sure[number(id)] = is_sure(pass, *pass.map.objects.find(id), voxels);
  return sure;
}

bool ObjectMaintenance::is_faint(const Pass& pass, const Object& object, std::span<const std::uint32_t> voxels) const {
  if (object.observations == 0) return voxels.size() < voxels_of(options_.min_thing_m2, pass.map.voxels);
  if (pass.map.objects.class_of(object.slot) == ClassId::kUnknown) return true;
  const Votes votes = votes_in(pass.map.voxels, pass.surface, voxels);
  if (object.observations < pass.min_observations && certainty(object, votes) < options_.min_certainty) return true;
  return voxels.size() < voxels_of(kSmallestPiece_m2, pass.map.voxels) && support(object, votes) < kSure;
}

// Objects that are left of none but votes, or of voxels behind the surface, go too.
void ObjectMaintenance::drop_faint(Pass& pass, Judged judged) const {
  Renaming renaming;
  std::vector<std::uint32_t> dropped;
  const VoxelsByLabel at_surface = objects_of(pass);
  std::vector<bool> in_use = ids_in_use(pass.map.voxels);
  pass.votes.add_in_use(in_use);
  for (std::size_t n = pass.map.labels.first_thing(); n < kLabelSlots; ++n) {
    const auto id = static_cast<LabelSlot>(n);
    if (in_use[n] && pass.map.objects.find(id) != nullptr && !at_surface.contains(id)) renaming.add(id, LabelSlot::kUnknown);
  }
  for (const auto& [id, voxels] : at_surface) {
    const Object& object = *pass.map.objects.find(id);
    if (judged == Judged::kUnobserved && object.observations > 0) continue;
    if (!is_faint(pass, object, voxels)) continue;
    renaming.add(id, LabelSlot::kUnknown);
    dropped.insert(dropped.end(), voxels.begin(), voxels.end());
  }
  renaming.apply(pass.map.voxels, pass.votes, pass.surface);
  fill_from_neighbours(std::move(dropped), pass.map.voxels, pass.surface);
}

void ObjectMaintenance::name_unknown_regions(Pass& pass) const {
  VoxelsByLabel by_label = pass.surface.by_label([](LabelSlot label) { return label == LabelSlot::kUnknown; });
  std::vector<std::uint32_t>& unknown = by_label[LabelSlot::kUnknown];
  std::erase_if(unknown, [&](std::uint32_t i) { return !is_voted_on(pass, i); });
  for (const auto& region : pass.surface.components(unknown, 1)) {
    if (region.size() < voxels_of(options_.min_region_m2, pass.map.voxels)) continue;
    const LabelSlot id = pass.map.objects.create(pass.frame).value_or(LabelSlot::kUnknown);
    for (const std::uint32_t i : region) pass.surface.relabel(i, id);
  }
}

void ObjectMaintenance::name_others(Pass& pass) const {
  const LabelClass* other = pass.map.labels.find(kOther);
  if (other == nullptr) return;
  for (const auto& [id, voxels] : objects_of(pass)) {
    if (pass.map.objects.class_of(id) == ClassId::kUnknown) pass.map.objects.assume(id, other->id);
  }
}

}  // namespace panoptic
