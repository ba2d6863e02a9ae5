// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/relabelling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <unordered_map>
#include <utility>

#include "panoptic/objects/support_planes.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr double kFrayed_voxels = 3;  // from the rim: whatever lies there is taken for a frayed border
constexpr double kFlush_voxels = 1;   // from the plane of the rim
constexpr double kAlike = 0.8;        // cosine between normals of one plane; where things meet they are bent
constexpr double kSlope = 0.05;       // of a normal that is known to three degrees

// A place on the surface near a voxel, in voxels, and the normal there; zero where it is not known.
struct Facet {
  Vec3d place = Vec3d::Zero();
  Vec3d normal = Vec3d::Zero();
};

Facet facet_of(const VoxelMap& map, const SurfaceVoxel& voxel) {
  const Vec3d normal = normal_of(map, voxel);
  const double distance = double{map.block(voxel.slot).distance(voxel.voxel)} / double{map.voxel_size_m()};
  return {place_m(voxel, 1) - normal * distance, normal};
}

// Filling in progress.
struct Filling {
  const VoxelMap& map;
  const SurfaceVoxels& surface;
  std::vector<bool> open;                         // by surface voxel: a hole
  std::unordered_map<std::uint32_t, Facet> rims;  // of holes that were filled: where the label came from

  // The rim that a neighbour of a hole stands for.
  Facet rim_of(std::uint32_t neighbour) const {
    const auto found = rims.find(neighbour);
    return found != rims.end() ? found->second : facet_of(map, surface[neighbour]);
  }

  bool reaches(const Facet& rim, const Facet& hole) const {
    const Vec3d from = hole.place - rim.place;
    if (from.cwiseAbs().maxCoeff() <= kFrayed_voxels) return true;
    const bool turned = hole.normal.squaredNorm() > 0 && hole.normal.dot(rim.normal) < kAlike;
    return rim.normal.squaredNorm() > 0 && !turned && std::abs(from.dot(rim.normal)) <= kFlush_voxels + kSlope * from.norm();
  }
};

struct Fill {
  std::uint32_t hole = 0;
  LabelSlot label = LabelSlot::kNoVote;
  Facet rim;
};

// A label around a hole, how often it is there, and the first rim that it comes from.
struct Candidate {
  LabelSlot label;
  int count;
  Facet rim;
};

// The most frequent label around a hole whose rim reaches it, other holes left out; kNoVote where there is none. `candidates` is
// for reuse.
Fill fill_of(std::uint32_t hole, const Filling& filling, std::vector<Candidate>& candidates) {
  candidates.clear();
  const Facet place = facet_of(filling.map, filling.surface[hole]);
  filling.surface.visit_near(hole, 1, [&](std::uint32_t neighbour) {
    if (filling.open[neighbour]) return;
    const Facet rim = filling.rim_of(neighbour);
    if (!filling.reaches(rim, place)) return;
    const LabelSlot label = filling.surface.label(neighbour);
    const auto known = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) { return c.label == label; });
    if (known == candidates.end()) {
      candidates.push_back({label, 1, rim});
    } else {
      ++known->count;
    }
  });
  const auto best = std::max_element(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::pair(a.count, -int{number(a.label)}) < std::pair(b.count, -int{number(b.label)});
  });
  return best == candidates.end() ? Fill{hole} : Fill{hole, best->label, best->rim};
}

// The holes next to these voxels, each once. `listed` has no voxel before and after.
std::vector<std::uint32_t> holes_around(std::span<const Fill> filled, const Filling& filling, std::vector<bool>& listed) {
  std::vector<std::uint32_t> holes;
  for (const Fill& fill : filled) {
    filling.surface.visit_near(fill.hole, 1, [&](std::uint32_t neighbour) {
      if (!filling.open[neighbour] || listed[neighbour]) return;
      listed[neighbour] = true;
      holes.push_back(neighbour);
    });
  }
  for (const std::uint32_t hole : holes) listed[hole] = false;
  return holes;
}

}  // namespace

Renaming::Renaming() : new_label_(kLabelSlots) { std::iota(new_label_.begin(), new_label_.end(), std::uint16_t{0}); }

void Renaming::apply(VoxelMap& map, FrameVotes& votes, SurfaceVoxels& surface) const {
  votes.rename(new_label_, map);
  LabelBits before;
  LabelBits after;
  for (std::size_t label = 0; label < kLabelSlots; ++label) {
    if (new_label_[label] == label) continue;
    add_to(before, static_cast<std::uint16_t>(label));
    add_to(after, new_label_[label]);
  }
  std::vector<char> changed(map.block_count(), 0);
  parallel_for(changed.size(), [&](std::size_t i) {
    const auto slot = static_cast<Slot>(i);
    // Most blocks hold none of them; to know it saves reading their labels.
    if ((surface.label_bits(slot) & before).none()) return;
    changed[slot] = map.block(slot).rename_labels(new_label_) ? 1 : 0;
    const auto [first, end] = surface.range_of(slot);
    for (std::uint32_t v = first; v < end; ++v) surface.relabel(v, of(surface.label(v)));
    surface.add_label_bits(slot, after);
  });
  for (std::size_t slot = 0; slot < changed.size(); ++slot) {
    if (changed[slot] != 0) map.mark_changed(static_cast<Slot>(slot));
  }
}

void fill_from_neighbours(std::vector<std::uint32_t> holes, const VoxelMap& map, SurfaceVoxels& surface) {
  Filling filling{map, surface, std::vector<bool>(surface.size(), false), {}};
  std::vector<bool> listed(surface.size(), false);
  for (const std::uint32_t hole : holes) {
    filling.open[hole] = true;
    surface.relabel(hole, LabelSlot::kUnknown);
  }
  std::vector<Candidate> candidates;
  while (!holes.empty()) {
    std::vector<Fill> filled;
    for (const std::uint32_t hole : holes) {
      Fill fill = fill_of(hole, filling, candidates);
      if (fill.label != LabelSlot::kNoVote) filled.push_back(fill);
    }
    for (const Fill& fill : filled) {
      surface.relabel(fill.hole, fill.label);
      filling.open[fill.hole] = false;
      filling.rims.emplace(fill.hole, fill.rim);
    }
    // Only there is anything new to see.
    holes = holes_around(filled, filling, listed);
  }
}

}  // namespace panoptic
