// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/history_rows.h"

#include <cmath>
#include <limits>

namespace panoptic {
namespace {

constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMostIds = std::numeric_limits<std::uint32_t>::max();

PanopticId id_in(const Statement& row, int column) { return static_cast<PanopticId>(row.integer(column, 0, kMostIds)); }

Vec3d vector_in(const Statement& row, int column) { return {row.real(column), row.real(column + 1), row.real(column + 2)}; }

PastObject past_in(const Statement& row) {
  PastObject past;
  past.id = id_in(row, 0);
  past.class_id = static_cast<ClassId>(row.integer(1, 0, 65535));
  past.probability = row.real(2);
  past.first_frame = row.integer(3);
  past.last_frame = row.integer(4);
  past.observations = static_cast<std::uint64_t>(row.integer(5, 0, kMost));
  past.gone_frame = row.integer(6);
  past.moved_to = id_in(row, 7);
  past.voxels = static_cast<std::uint64_t>(row.integer(8, 0, kMost));
  past.box = {.min_m = vector_in(row, 12), .max_m = vector_in(row, 15), .center_m = vector_in(row, 9)};
  return past;
}

bool is_sound(const PastObject& past, const LabelSet& labels) {
  return labels.is_object(past.id) && std::isfinite(past.probability) && past.box.min_m.allFinite() &&
         past.box.max_m.allFinite() && past.box.center_m.allFinite();
}

}  // namespace

void put_history(Database& database, const ObjectHistory& history) {
  database.execute("DELETE FROM past_objects; DELETE FROM arrivals;");
  Statement put(database,
                "INSERT INTO past_objects(number, id, class_id, probability, first_frame, last_frame, observations, gone_frame, "
                "moved_to, voxels, x_m, y_m, z_m, min_x_m, min_y_m, min_z_m, max_x_m, max_y_m, max_z_m) "
                "VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  std::int64_t count = 0;
  for (const PastObject& past : history.past) {
    put.bind(count++).bind(std::int64_t{number(past.id)}).bind(std::int64_t{number(past.class_id)}).bind(past.probability);
    put.bind(past.first_frame).bind(past.last_frame).bind(static_cast<std::int64_t>(past.observations)).bind(past.gone_frame);
    put.bind(std::int64_t{number(past.moved_to)}).bind(static_cast<std::int64_t>(past.voxels));
    for (const Vec3d& v : {past.box.center_m, past.box.min_m, past.box.max_m}) {
      for (const double coordinate : {v.x(), v.y(), v.z()}) put.bind(coordinate);
    }
    put.run();
  }
  Statement arrive(database, "INSERT INTO arrivals(id, moved_from, confidence) VALUES(?, ?, ?)");
  for (const auto& [id, arrival] : history.arrivals) {
    arrive.bind(std::int64_t{number(id)}).bind(std::int64_t{number(arrival.moved_from)}).bind(arrival.confidence).run();
  }
}

ObjectHistory read_history(Database& database, const LabelSet& labels) {
  ObjectHistory history;
  Statement row(
      database,
      "SELECT id, class_id, probability, first_frame, last_frame, observations, gone_frame, moved_to, voxels, x_m, y_m, "
      "z_m, min_x_m, min_y_m, min_z_m, max_x_m, max_y_m, max_z_m FROM past_objects ORDER BY number");
  while (row.step()) {
    history.past.push_back(past_in(row));
    if (!is_sound(history.past.back(), labels)) database.refuse("a past object cannot be; the file is damaged: use another copy");
  }
  Statement arrival(database, "SELECT id, moved_from, confidence FROM arrivals ORDER BY id");
  while (arrival.step()) history.arrivals[id_in(arrival, 0)] = {id_in(arrival, 1), arrival.real(2)};
  return history;
}

}  // namespace panoptic
