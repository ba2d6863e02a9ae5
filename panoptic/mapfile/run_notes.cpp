// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/run_notes.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "panoptic/base/bytes.h"
#include "panoptic/base/compression.h"
#include "panoptic/base/config.h"
#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/mapfile/presence_notes.h"

namespace panoptic {
namespace {

constexpr const char* kTogether = "together";
constexpr const char* kOverruled = "overruled";
constexpr const char* kRegularized = "regularized";
constexpr const char* kSession = "session";
constexpr const char* kMoving = "moving";
constexpr const char* kPresence = "presence";

[[noreturn]] void refuse(const std::string& what) {
  throw Error("the map file's state '" + what + "' does not belong to its map; the file is damaged: use another copy");
}

Bytes covisibility_bytes(const Covisibility& covisibility) {
  Bytes bytes;
  for (const auto& [pair, frames] : covisibility) {
    append_number(bytes, number(pair.first));
    append_number(bytes, number(pair.second));
    append_number(bytes, frames);
  }
  return bytes;
}

// `Id`: what ids were in that format.
template <typename Id>
Covisibility covisibility_from(const Bytes& bytes) {
  Covisibility together;
  ByteReader reader(bytes);
  while (reader.left() > 0) {
    const auto first = static_cast<PanopticId>(reader.take<Id>());
    const auto second = static_cast<PanopticId>(reader.take<Id>());
    const auto frames = reader.take<std::uint32_t>();
    const std::pair pair(first, second);
    if (reader.is_short() || !(first < second) || together.contains(pair)) refuse(kTogether);
    together.emplace_hint(together.end(), pair, frames);
  }
  return together;
}

Bytes overruled_bytes(const std::vector<std::vector<OverruledVote>>& votes) {
  Bytes bytes;
  for (const std::vector<OverruledVote>& of_block : votes) {
    append_number(bytes, static_cast<std::uint16_t>(of_block.size()));  // a block has 4096 voxels
    for (const OverruledVote& vote : of_block) {
      append_number(bytes, vote.voxel);
      append_number(bytes, vote.voted.label);
      append_number(bytes, vote.voted.weight);
      append_number(bytes, vote.written.label);
      append_number(bytes, vote.written.weight);
    }
  }
  return bytes;
}

OverruledVote take_vote(ByteReader& reader) {
  OverruledVote vote{};
  vote.voxel = reader.take<std::uint16_t>();
  vote.voted.label = reader.take<std::uint16_t>();
  vote.voted.weight = reader.take<float>();
  vote.written.label = reader.take<std::uint16_t>();
  vote.written.weight = reader.take<float>();
  return vote;
}

std::vector<std::vector<OverruledVote>> overruled_from(const Bytes& bytes, const SavedMap& saved) {
  const auto may_be = [&](const VoxelLabel& l) {
    const bool names =
        l.label < saved.map.objects.first_thing() || saved.map.objects.named_by(LabelSlot{l.label}) != PanopticId::kUnknown;
    return names && std::isfinite(l.weight) && l.weight >= 0;
  };
  std::vector<std::vector<OverruledVote>> votes;
  ByteReader reader(bytes);
  while (reader.left() > 0) {
    const auto count = reader.take<std::uint16_t>();
    if (reader.is_short() || count > kBlockVoxels || votes.size() == saved.map.voxels.block_count()) refuse(kOverruled);
    std::vector<OverruledVote>& of_block = votes.emplace_back();
    for (std::size_t i = 0; i < count; ++i) {
      const OverruledVote vote = take_vote(reader);
      const bool ascends = of_block.empty() || of_block.back().voxel < vote.voxel;
      if (reader.is_short() || vote.voxel >= kBlockVoxels || !ascends || !may_be(vote.voted) || !may_be(vote.written)) {
        refuse(kOverruled);
      }
      of_block.push_back(vote);
    }
  }
  return votes;
}

Bytes epochs_bytes(const std::vector<std::uint64_t>& epochs) {
  Bytes bytes;
  for (const std::uint64_t epoch : epochs) append_number(bytes, epoch);
  return bytes;
}

std::vector<std::uint64_t> epochs_from(const Bytes& bytes, const VoxelMap& map) {
  std::vector<std::uint64_t> epochs;
  ByteReader reader(bytes);
  while (reader.left() > 0) epochs.push_back(reader.take<std::uint64_t>());
  if (reader.is_short() || epochs.size() > map.block_count()) refuse(kRegularized);
  for (const std::uint64_t epoch : epochs) {
    if (epoch > map.epoch()) refuse(kRegularized);
  }
  return epochs;
}

const Bytes& state_bytes(const SavedMap& saved, const char* name) {
  const auto found = saved.notes.states.find(name);
  if (found == saved.notes.states.end()) refuse(name);
  return found->second;
}

void read_counters(const SavedMap& saved, SavedState& state) {
  const auto text = saved.notes.texts.find(kSession);
  if (text == saved.notes.texts.end()) refuse(kSession);
  const std::optional<Json> json = json_in(text->second);
  if (!json) refuse(kSession);
  const auto whole = [&](const char* key) -> const Json& {
    const Json& value = json->at(key);
    if (!value.is_number_integer()) refuse(kSession);  // get() would take 1e300 for an integer
    return value;
  };
  try {
    state.label_frames = whole("label_frames").get<std::uint64_t>();
    state.labelled = whole("labelled").get<std::uint64_t>();
    state.last_frame = whole("last_frame").get<std::int64_t>();
    // Older files do not say: then all counts as changed.
    if (json->contains("maintained_epoch")) state.maintenance.epoch = whole("maintained_epoch").get<std::uint64_t>();
    if (state.maintenance.epoch > saved.map.voxels.epoch()) refuse(kSession);
    for (Eigen::Index a = 0; a < 3; ++a) state.up_sum[a] = json->at("up_sum").at(static_cast<std::size_t>(a)).get<double>();
  } catch (const Json::exception&) {
    refuse(kSession);
  }
}

}  // namespace

std::string note_or_empty(const SavedMap& saved, const std::string& name) {
  const auto found = saved.notes.texts.find(name);
  return found == saved.notes.texts.end() ? "" : found->second;
}

bool is_complete(const SavedMap& saved) { return note_or_empty(saved, run_note::kComplete) == "1"; }

Vec3d up_of(const SavedMap& saved) {
  const Json json = json_in(note_or_empty(saved, run_note::kUp)).value_or(nullptr);
  Vec3d up = -Vec3d::UnitY();
  if (!json.is_array() || json.size() != 3) return up;
  for (std::size_t a = 0; a < 3; ++a) up[static_cast<Eigen::Index>(a)] = json[a].is_number() ? json[a].get<double>() : 0.0;
  return up.allFinite() && up.norm() > 0 ? Vec3d(up.normalized()) : Vec3d(-Vec3d::UnitY());
}

std::string up_text(const Vec3d& up) { return Json({up.x(), up.y(), up.z()}).dump(); }

std::optional<double> option_of(const SavedMap& saved, std::string_view key) {
  return number_in_toml(note_or_empty(saved, run_note::kOptions), "the map file's options", key);
}

MapNotes notes_of(const SavedState& state) {
  const Json counters = {{"label_frames", state.label_frames},
                         {"labelled", state.labelled},
                         {"last_frame", state.last_frame},
                         {"maintained_epoch", state.maintenance.epoch},
                         {"up_sum", {state.up_sum.x(), state.up_sum.y(), state.up_sum.z()}}};
  return {{{kSession, counters.dump()}},
          {{kTogether, covisibility_bytes(state.maintenance.covisible)},
           {kOverruled, overruled_bytes(state.regularizer.votes)},
           {kRegularized, epochs_bytes(state.regularizer.handled)},
           {kMoving, moving_bytes(state.moving)},
           {kPresence, presence_bytes(state.presence)}}};
}

SavedState saved_state(const SavedMap& saved) {
  SavedState state;
  read_counters(saved, state);
  const Bytes& together = state_bytes(saved, kTogether);
  state.maintenance.covisible =
      saved.format == 1 ? covisibility_from<std::uint16_t>(together) : covisibility_from<std::uint32_t>(together);
  state.regularizer.votes = overruled_from(state_bytes(saved, kOverruled), saved);
  state.regularizer.handled = epochs_from(state_bytes(saved, kRegularized), saved.map.voxels);
  if (saved.format < 5) return state;  // nothing was known of what moves
  std::optional<MovingState> moving = moving_from(state_bytes(saved, kMoving));
  if (!moving) refuse(kMoving);
  state.moving = std::move(*moving);
  std::optional<PresenceState> presence = presence_from(state_bytes(saved, kPresence));
  if (!presence) refuse(kPresence);
  state.presence = std::move(*presence);
  return state;
}

}  // namespace panoptic
