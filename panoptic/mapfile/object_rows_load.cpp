// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/mapfile/object_rows.h"

namespace panoptic {
namespace {

constexpr const char* kSelect =
    "SELECT id, slot, first_frame, last_frame, observations, score_sum, evidence, ruled_out, votes, best_views, parts "
    "FROM objects ORDER BY id";
// Until format 1 the slot was the id, and merged objects were rows without content.
constexpr const char* kSelectFormat1 =
    "SELECT id, id, first_frame, last_frame, observations, score_sum, evidence, ruled_out, votes, best_views, parts "
    "FROM objects WHERE merged_into IS NULL ORDER BY id";
constexpr const char* kSelectMerged = "SELECT id, merged_into FROM merged ORDER BY id";
constexpr const char* kSelectMergedFormat1 = "SELECT id, merged_into FROM objects WHERE merged_into IS NOT NULL ORDER BY id";
constexpr const char* kUseAnother = "the file is damaged: use another copy";
constexpr std::size_t kMostText = 1 << 20;
constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();

// Reads the JSON of one row. What is not as it was written throws std::exception, whatever it is: the caller says which row.
struct RowError : std::exception {};

void require(bool condition) {
  if (!condition) throw RowError();
}

std::int64_t whole(const Json& json, std::int64_t min, std::int64_t max) {
  require(json.is_number_integer());
  require(!json.is_number_unsigned() || json.get<std::uint64_t>() <= static_cast<std::uint64_t>(kMost));
  const auto value = json.get<std::int64_t>();
  require(value >= min && value <= max);
  return value;
}

double finite(const Json& json) {
  require(json.is_number());
  const auto value = json.get<double>();
  require(std::isfinite(value) && value >= 0);
  return value;
}

float finite_float(const Json& json) {
  const double value = finite(json);
  require(value <= static_cast<double>(std::numeric_limits<float>::max()));
  return static_cast<float>(value);
}

ClassId class_from(const std::string& text) {
  std::uint16_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  require(error == std::errc() && end == text.data() + text.size());
  return ClassId{id};
}

Json json_from(std::string_view text) {
  require(text.size() <= kMostText);
  std::optional<Json> json = json_in(text);
  require(json.has_value());
  return std::move(*json);
}

VoteHistory votes_from(const Json& json) {
  require(json.is_object() && json.contains("log2") && json.contains("bins") && json["bins"].is_array());
  require(json["bins"].size() <= VoteHistory::kMostBins);
  std::vector<VoteHistory::Bin> bins;
  for (const Json& entry : json["bins"]) {
    require(entry.is_array() && entry.size() == 2 && entry[1].is_object() && !entry[1].empty());
    VoteHistory::Bin bin{whole(entry[0], std::numeric_limits<std::int64_t>::min(), kMost), {}};
    require(bins.empty() || bins.back().number < bin.number);
    for (const auto& [key, count] : entry[1].items()) {
      bin.votes[class_from(key)] = static_cast<std::uint64_t>(whole(count, 1, kMost));
    }
    bins.push_back(std::move(bin));
  }
  return {std::move(bins), static_cast<int>(whole(json["log2"], 0, VoteHistory::kMostLog2))};
}

BestViews views_from(const Json& json) {
  constexpr std::int64_t kMostPixels = 1 << 30;
  require(json.is_array() && json.size() <= BestViews::kMost);
  BestViews best;
  for (const Json& v : json) {
    require(v.is_array() && v.size() == 8);
    const auto pixel = [&](std::size_t i) { return static_cast<int>(whole(v[i], -kMostPixels, kMostPixels)); };
    best.add({.frame = whole(v[0], std::numeric_limits<std::int64_t>::min(), kMost),
              .class_id = static_cast<ClassId>(whole(v[1], 0, 65535)),
              .score = finite_float(v[2]),
              .visible_px = static_cast<std::uint32_t>(whole(v[3], 0, std::numeric_limits<std::uint32_t>::max())),
              .box = {pixel(4), pixel(5), pixel(6), pixel(7)}});
  }
  return best;
}

// Until format 1 there was only a list, of all of them.
PartHistory parts_from(const Json& json) {
  require(json.is_array() || json.is_object());
  const Json list = json.is_array() ? json : json.value("latest", Json());
  require(list.is_array());
  PartHistory parts;
  for (const Json& part : list) {
    require(part.is_array() && part.size() == 2);
    parts.add({static_cast<PanopticId>(whole(part[0], 1, std::numeric_limits<std::uint32_t>::max())),
               whole(part[1], std::numeric_limits<std::int64_t>::min(), kMost)});
  }
  if (json.is_array()) return parts;
  const auto count = static_cast<std::uint64_t>(whole(json.value("count", Json()), 0, kMost));
  require(count >= list.size() && list.size() == std::min<std::uint64_t>(count, PartHistory::kMost));
  return {count, parts.latest()};
}

Object object_from(const Statement& row) {
  Object object;
  object.id = static_cast<PanopticId>(row.integer(0));
  object.slot = static_cast<LabelSlot>(row.integer(1));
  object.first_frame = row.integer(2);
  object.last_frame = row.integer(3);
  object.observations = static_cast<std::uint64_t>(row.integer(4, 0, kMost));
  object.score_sum = row.real(5);
  require(std::isfinite(object.score_sum) && object.score_sum >= 0);
  const Json evidence = json_from(row.text(6));
  require(evidence.is_object());
  for (const auto& [key, value] : evidence.items()) object.evidence[class_from(key)] = finite(value);
  const Json ruled_out = json_from(row.text(7));
  require(ruled_out.is_array());
  for (const Json& id : ruled_out) object.ruled_out.insert(static_cast<ClassId>(whole(id, 0, 65535)));
  object.votes = votes_from(json_from(row.text(8)));
  object.best_views = views_from(json_from(row.text(9)));
  object.parts = parts_from(json_from(row.text(10)));
  return object;
}

// Reads the three tables and checks that they fit together.
class ObjectReader {
 public:
  ObjectReader(Database& database, std::int64_t format, std::uint16_t first_thing, GivenCounts given)
      : database_(database),
        format_(format),
        first_(first_thing),
        last_id_(std::int64_t{first_thing} + given.ids - 1),
        last_slot_(std::int64_t{first_thing} + given.slots - 1) {
    state_.objects.resize(given.slots);
  }

  RegistryState read() {
    read_rows();
    read_merged();
    if (format_ == 1) {
      leave_the_rest();
    } else {
      read_left();
    }
    return std::move(state_);
  }

 private:
  Object& at(std::int64_t slot) { return state_.objects[static_cast<std::size_t>(slot - first_)]; }
  PanopticId id_in(const Statement& row, int column) const {
    return static_cast<PanopticId>(row.integer(column, first_, last_id_));
  }

  void read_rows() {
    Statement row(database_, format_ == 1 ? kSelectFormat1 : kSelect);
    while (row.step()) {
      const PanopticId id = id_in(row, 0);
      const std::int64_t slot = row.integer(1, first_, last_slot_);
      if (at(slot).id != PanopticId::kUnknown) {
        database_.refuse(fmt::format("objects {} and {} have one slot; {}", number(at(slot).id), number(id), kUseAnother));
      }
      try {
        at(slot) = object_from(row);
      } catch (const RowError&) {
        database_.refuse(fmt::format("object {} holds what no object can; {}", number(id), kUseAnother));
      }
      living_.emplace(id, &at(slot));
    }
  }

  void read_merged() {
    Statement row(database_, format_ == 1 ? kSelectMergedFormat1 : kSelectMerged);
    while (row.step()) state_.merged.push_back({id_in(row, 0), id_in(row, 1)});
    if (format_ == 1) shorten_chains();
    for (const MergedObject& merged : state_.merged) {
      const auto whole = living_.find(merged.into);
      const bool counted = whole == living_.end() || whole->second->parts.count() > 0;
      if (living_.contains(merged.id) || into_of(merged.into) != nullptr || !counted) {
        database_.refuse(
            fmt::format("object {} cannot have been merged into {}; {}", number(merged.id), number(merged.into), kUseAnother));
      }
    }
  }

  const MergedObject* into_of(PanopticId id) const {
    const auto found = std::ranges::lower_bound(state_.merged, id, {}, &MergedObject::id);
    return found == state_.merged.end() || found->id != id ? nullptr : &*found;
  }

  // Format 1 says what an object was merged into at the time. None may be a part of itself, by whatever way round.
  void shorten_chains() {
    for (MergedObject& merged : state_.merged) {
      std::size_t steps = 0;
      for (const MergedObject* next = into_of(merged.into); next != nullptr; next = into_of(merged.into)) {
        merged.into = next->into;
        if (++steps > state_.merged.size()) database_.refuse(fmt::format("objects are merged in a circle; {}", kUseAnother));
      }
    }
  }

  void read_left() {
    Statement row(database_, "SELECT slot, id FROM left_slots ORDER BY slot");
    while (row.step()) {
      const std::int64_t slot = row.integer(0, first_, last_slot_);
      const PanopticId id = id_in(row, 1);
      if (at(slot).id != PanopticId::kUnknown || living_.contains(id)) {
        database_.refuse(fmt::format("object {} has not left slot {}; {}", number(id), slot, kUseAnother));
      }
      state_.left.push_back({static_cast<LabelSlot>(slot), id});
    }
  }

  // Format 1 does not say whether anything still names the slot of an object that is no more.
  void leave_the_rest() {
    for (std::int64_t slot = first_; slot <= last_slot_; ++slot) {
      if (at(slot).id == PanopticId::kUnknown) state_.left.push_back({static_cast<LabelSlot>(slot), PanopticId(slot)});
    }
  }

  Database& database_;
  std::int64_t format_;
  std::int64_t first_;
  std::int64_t last_id_;
  std::int64_t last_slot_;
  RegistryState state_;
  std::unordered_map<PanopticId, const Object*> living_;
};

}  // namespace

RegistryState read_objects(Database& database, std::int64_t format, std::uint16_t first_thing, GivenCounts given) {
  return ObjectReader(database, format, first_thing, given).read();
}

}  // namespace panoptic
