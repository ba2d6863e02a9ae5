// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/presence_notes.h"

#include <bit>
#include <cmath>
#include <utility>

#include "panoptic/map/space_cells.h"

namespace panoptic {
namespace {

void append(Bytes& bytes, std::int64_t number) { append_number(bytes, static_cast<std::uint64_t>(number)); }
void append(Bytes& bytes, double number) { append_number(bytes, std::bit_cast<std::uint64_t>(number)); }

void append(Bytes& bytes, const Vec3d& v) {
  for (Eigen::Index a = 0; a < 3; ++a) append(bytes, v[a]);
}

void append(Bytes& bytes, const CellIndex& cell) {
  for (const std::int32_t c : cell) append_number(bytes, static_cast<std::uint32_t>(c));
}

std::int64_t take_frame(ByteReader& reader) { return static_cast<std::int64_t>(reader.take<std::uint64_t>()); }
double take_real(ByteReader& reader) { return std::bit_cast<double>(reader.take<std::uint64_t>()); }

Vec3d take_vector(ByteReader& reader) {
  Vec3d v;
  for (Eigen::Index a = 0; a < 3; ++a) v[a] = take_real(reader);
  return v;
}

CellIndex take_cell(ByteReader& reader) {
  CellIndex cell{};
  for (std::int32_t& c : cell) c = static_cast<std::int32_t>(reader.take<std::uint32_t>());
  return cell;
}

// The smallest number of bytes that one of a list takes: a count that promises more than there is is a lie.
bool may_hold(const ByteReader& reader, std::uint64_t count, std::size_t least_bytes) {
  return !reader.is_short() && count <= reader.left() / least_bytes;
}

bool take_track(ByteReader& reader, MovingState::Followed& followed) {
  MovingTrack& track = followed.track;
  track.id = reader.take<std::uint32_t>();
  track.class_id = static_cast<ClassId>(reader.take<std::uint16_t>());
  const auto names = reader.take<std::uint16_t>();
  if (!may_hold(reader, names, 10)) return false;
  for (std::size_t n = 0; n < names; ++n) {
    const auto class_id = static_cast<ClassId>(reader.take<std::uint16_t>());
    followed.named[class_id] = reader.take<std::uint64_t>();
  }
  const auto boxes = reader.take<std::uint32_t>();
  if (boxes == 0 || !may_hold(reader, boxes, 64)) return false;
  for (std::size_t n = 0; n < boxes; ++n) {
    TrackedBox box;
    box.frame = take_frame(reader);
    box.time_s = take_real(reader);
    box.min_m = take_vector(reader);
    box.max_m = take_vector(reader);
    if (!std::isfinite(box.time_s) || !box.min_m.allFinite() || !box.max_m.allFinite()) return false;
    track.boxes.push_back(box);
  }
  return !reader.is_short();
}

}  // namespace

Bytes moving_bytes(const MovingState& state) {
  Bytes bytes;
  append_number(bytes, state.next_id);
  append_number(bytes, state.forgotten);
  for (const auto& [track, named] : state.followed) {
    append_number(bytes, track.id);
    append_number(bytes, number(track.class_id));
    append_number(bytes, static_cast<std::uint16_t>(named.size()));
    for (const auto& [class_id, frames] : named) {
      append_number(bytes, number(class_id));
      append_number(bytes, frames);
    }
    append_number(bytes, static_cast<std::uint32_t>(track.boxes.size()));
    for (const TrackedBox& box : track.boxes) {
      append(bytes, box.frame);
      append(bytes, box.time_s);
      append(bytes, box.min_m);
      append(bytes, box.max_m);
    }
  }
  return bytes;
}

std::optional<MovingState> moving_from(const Bytes& bytes) {
  MovingState state;
  ByteReader reader(bytes);
  state.next_id = reader.take<std::uint32_t>();
  state.forgotten = reader.take<std::uint64_t>();
  while (reader.left() > 0) {
    const std::uint32_t before = state.followed.empty() ? 0 : state.followed.back().track.id;
    if (!take_track(reader, state.followed.emplace_back())) return std::nullopt;
    const std::uint32_t id = state.followed.back().track.id;
    if (id <= before || id >= state.next_id) return std::nullopt;
  }
  if (reader.is_short()) return std::nullopt;
  return state;
}

Bytes presence_bytes(const PresenceState& state) {
  Bytes bytes;
  append_number(bytes, static_cast<std::uint32_t>(state.lost.size()));
  for (const auto& [id, lost] : state.lost) {
    append_number(bytes, number(id));
    append(bytes, lost.frame);
    append_number(bytes, lost.looked_at);
    append_number(bytes, static_cast<std::uint32_t>(lost.voxels.size()));
    for (const auto& [cell, bits] : lost.voxels) {
      append(bytes, cell);
      append_number(bytes, bits);
    }
  }
  append_number(bytes, static_cast<std::uint32_t>(state.came_up.size()));
  for (const auto& [cell, frame] : state.came_up) {
    append(bytes, cell);
    append(bytes, frame);
  }
  for (const auto& [cell, stay] : state.stays) {
    append(bytes, cell);
    append_number(bytes, stay.since);
    append_number(bytes, stay.last);
  }
  return bytes;
}

std::optional<PresenceState> presence_from(const Bytes& bytes) {
  PresenceState state;
  ByteReader reader(bytes);
  const auto objects = reader.take<std::uint32_t>();
  if (!may_hold(reader, objects, 24)) return std::nullopt;
  for (std::size_t n = 0; n < objects; ++n) {
    LostSurface& lost = state.lost[static_cast<PanopticId>(reader.take<std::uint32_t>())];
    lost.frame = take_frame(reader);
    lost.looked_at = reader.take<std::uint64_t>();
    const auto cells = reader.take<std::uint32_t>();
    if (!may_hold(reader, cells, 20)) return std::nullopt;
    for (std::size_t c = 0; c < cells; ++c) {
      const CellIndex cell = take_cell(reader);
      lost.voxels[cell] = reader.take<std::uint64_t>();
      if (!in_range(block_of(cell))) return std::nullopt;
    }
  }
  const auto cells = reader.take<std::uint32_t>();
  if (!may_hold(reader, cells, 20)) return std::nullopt;
  for (std::size_t n = 0; n < cells; ++n) {
    const CellIndex cell = take_cell(reader);
    state.came_up[cell] = take_frame(reader);
  }
  while (reader.left() > 0) {
    Stay& stay = state.stays[take_cell(reader)];
    stay.since = reader.take<std::uint64_t>();
    stay.last = reader.take<std::uint64_t>();
    if (stay.since > stay.last) return std::nullopt;
  }
  if (reader.is_short()) return std::nullopt;
  return state;
}

}  // namespace panoptic
