// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Two maps of one place: how they lie to each other, what changed from one to the other, and both as one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/map_file.h"
#include "panoptic/query.h"

namespace panoptic {

// A map file in memory, whole.
struct MapWithFrames {
  SavedMap saved;
  std::vector<FrameRecord> frames;
};
MapWithFrames load_map_with_frames(const std::filesystem::path& path);

// How map b lies in map a.
struct MapAlignment {
  Pose a_from_b = Pose::Identity();
  // The share of the surface of either map, but for what is horizontal, that is surface in the other map, too, within two voxels;
  // of what the other one looked at.
  double agreement = 0;
  double common_m2 = 0;     // of it, surface that both have
  std::size_t objects = 0;  // that lie where the other map has one of their class, in the map that has fewer of those
};

// Finds out by the objects of both maps and by their surfaces. They may lie in any way to each other, and what stands in the
// rooms may have changed in part. Throws Error, naming the maps and what speaks against it, if they are not comparable (see
// diff_maps), if one has no free space, or if no pose is good enough, or two are: it is not certain then that they are of one
// place.
MapAlignment align_maps(const MapWithFrames& a, const MapWithFrames& b, const std::string& name_a, const std::string& name_b);

// The map in another world. Voxels are interpolated: details of a voxel are softened.
// Free space shrinks by up to a cell, doubts and the history of objects are left out, and so is what a run would need to go on.
// Throws Error if the pose is not finite, or takes the map farther than a map reaches.
MapWithFrames moved_map(const MapWithFrames& map, const Pose& new_from_old);

enum class ChangeKind : std::uint8_t {
  kVanished,    // in A, and B saw that its place is empty
  kAppeared,    // in B, and A saw that its place was empty
  kMoved,       // vanished in one place and there in another, same class, similar size and shape
  kOtherLabel,  // the surface is there in both maps, but is another class or no object of its own in one of them
  kNotSeenInB,  // in A; B did not look there
  kNotSeenInA   // in B; A had not looked there
};
std::string_view name_of(ChangeKind kind);  // "vanished", "appeared", "moved", "other_label", "not_seen_in_b", "not_seen_in_a"

struct ObjectChange {
  ChangeKind kind = ChangeKind::kVanished;
  std::optional<FoundObject> before;  // in A
  std::optional<FoundObject> after;   // in B
  double empty_share = 0;             // of the object's surface, where the other map saw empty space; of kMoved: the old place
  double moved_m = 0;                 // kMoved: from centre to centre
};

// How far the surfaces of two maps of one world lie apart: by drift of their poses, or by worlds that are not one.
struct SurfaceShift {
  double common = 0;    // the share of b's surface that a has, too: facing the same way, at most kFarthestShift_m off
  double median_m = 0;  // along the normals; 0 if they have nothing in common, as p95_m
  double p95_m = 0;
};
inline constexpr double kFarthestShift_m = 0.3;

struct MapDiff {
  std::vector<ObjectChange> changes;  // ascending by kind, then by the ids before and after
  std::size_t unchanged = 0;          // objects of A that are at their place in B, parts included
  std::size_t too_small = 0;          // objects without counterpart that are too small to say anything about
  SurfaceShift shift;
  std::vector<std::string> notes;  // what had to be guessed, and what speaks of drift, a line each
};

// Objects with fewer voxels near the surface are not compared.
inline constexpr std::uint64_t kLeastComparedVoxels = 30;
// The share of an object's surface that the other map must have seen, as surface or as empty, to say what became of the object;
// the greater part of what was seen decides.
inline constexpr double kLeastSeenShare = 0.5;
// Similar: the standard deviations of the surface along its principal axes differ by no more than this factor, give or take half
// a voxel; it is the same however the object was turned.
inline constexpr double kSimilarSpread = 1.6;

// REQUIRES maps in one world. Throws Error, naming the maps as `name_a` and `name_b`, unless they are comparable: of one voxel
// size, truncation and label set, whatever its colours.
MapDiff diff_maps(const MapWithFrames& a, const MapWithFrames& b, const std::string& name_a, const std::string& name_b);

struct MergedFiles {
  std::size_t objects_a = 0;
  std::size_t objects_b = 0;
  std::size_t objects = 0;
  std::size_t same = 0;   // objects that both maps have
  std::size_t parts = 0;  // objects that are parts of one in the other map
  std::size_t blocks = 0;
  std::optional<MapAlignment> alignment;  // if the maps were aligned
  std::vector<std::string> notes;         // what a file of an older format lacks, and what was left out, a line each
};

// Merges and writes the result, whole or not at all. It is a finished map: info, mesh, query, eval, view,
// merge, diff and regularize work on it, a run cannot go on from it. `align`: b is brought into the world of a first
// (align_maps); else they must lie in one. Regularizing starts from the labels as merged: what the regularizer overruled in the
// two maps is not kept. Options are those of `a`. Throws Error: not comparable, or `merged` is there.
MergedFiles merge_map_files(const std::filesystem::path& a, const std::filesystem::path& b, const std::filesystem::path& merged,
                            bool align = false);

}  // namespace panoptic
