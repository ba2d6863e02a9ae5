// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/map_schema.h"

#include <fmt/format.h>

#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {
namespace {

// Small pages: what the last page of a block leaves empty would else be a fifth of the file.
constexpr const char* kPages = "PRAGMA page_size = 1024; PRAGMA auto_vacuum = NONE;";

constexpr const char* kTables = R"sql(
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) STRICT, WITHOUT ROWID;

CREATE TABLE classes (id INTEGER PRIMARY KEY, name TEXT NOT NULL, is_thing INTEGER NOT NULL,
  red INTEGER NOT NULL, green INTEGER NOT NULL, blue INTEGER NOT NULL,
  max_size_m REAL NOT NULL, is_support INTEGER NOT NULL, is_mobile INTEGER NOT NULL) STRICT;

CREATE TABLE blocks (slot INTEGER PRIMARY KEY, x INTEGER NOT NULL, y INTEGER NOT NULL, z INTEGER NOT NULL,
  changed_at INTEGER NOT NULL, checksum INTEGER NOT NULL, voxels BLOB NOT NULL) STRICT;

CREATE TABLE objects (id INTEGER PRIMARY KEY, slot INTEGER NOT NULL, class_id INTEGER NOT NULL, probability REAL NOT NULL,
  first_frame INTEGER NOT NULL, last_frame INTEGER NOT NULL, observations INTEGER NOT NULL,
  score_sum REAL NOT NULL, evidence TEXT NOT NULL, ruled_out TEXT NOT NULL, votes TEXT NOT NULL,
  best_views TEXT NOT NULL, parts TEXT NOT NULL, voxels INTEGER NOT NULL,
  x_m REAL, y_m REAL, z_m REAL,
  min_x_m REAL, min_y_m REAL, min_z_m REAL, max_x_m REAL, max_y_m REAL, max_z_m REAL) STRICT;

CREATE TABLE frames (position INTEGER PRIMARY KEY, frame INTEGER NOT NULL, time_s REAL, labelled INTEGER NOT NULL,
  unused_because TEXT, x_m REAL, y_m REAL, z_m REAL, qw REAL, qx REAL, qy REAL, qz REAL) STRICT;

CREATE TABLE state (name TEXT PRIMARY KEY, size INTEGER NOT NULL, checksum INTEGER NOT NULL,
  bytes BLOB NOT NULL) STRICT, WITHOUT ROWID;

CREATE VIEW object_summary AS
  SELECT objects.id AS id, ifnull(classes.name, 'unknown') AS class,
    round(probability, 3) AS probability,
    round(x_m, 3) AS x_m, round(y_m, 3) AS y_m, round(z_m, 3) AS z_m,
    round(max_x_m - min_x_m, 3) AS size_x_m, round(max_y_m - min_y_m, 3) AS size_y_m,
    round(max_z_m - min_z_m, 3) AS size_z_m, observations, first_frame, last_frame
  FROM objects LEFT JOIN classes ON classes.id = objects.class_id
  WHERE voxels > 0 ORDER BY class, objects.id;

CREATE VIEW class_summary AS
  SELECT class, count(*) AS objects, group_concat(id, ' ') AS ids FROM object_summary GROUP BY class ORDER BY class;

CREATE VIEW frame_summary AS
  SELECT ifnull(unused_because, 'used') AS outcome, count(*) AS frames, sum(labelled) AS labelled
  FROM frames GROUP BY outcome ORDER BY frames DESC;
)sql";

// Tables that format 1 lacks.
constexpr const char* kTablesOfIds = R"sql(
CREATE TABLE merged (id INTEGER PRIMARY KEY, merged_into INTEGER NOT NULL) STRICT;

CREATE TABLE left_slots (slot INTEGER PRIMARY KEY, id INTEGER NOT NULL) STRICT;
)sql";

// The table that formats 1 and 2 lack.
constexpr const char* kTableOfSpace = R"sql(
CREATE TABLE free_space (x INTEGER NOT NULL, y INTEGER NOT NULL, z INTEGER NOT NULL, checksum INTEGER NOT NULL,
  cells BLOB NOT NULL, PRIMARY KEY (x, y, z)) STRICT, WITHOUT ROWID;
)sql";

// The table that formats 1 to 3 lack.
constexpr const char* kTableOfLog = R"sql(
CREATE TABLE frame_log (number INTEGER PRIMARY KEY, frame INTEGER NOT NULL, time_s REAL NOT NULL, pose BLOB NOT NULL,
  size INTEGER NOT NULL, labels BLOB NOT NULL, checksum INTEGER NOT NULL) STRICT;
)sql";

// The tables that formats 1 to 4 lack.
constexpr const char* kTablesOfHistory = R"sql(
CREATE TABLE past_objects (number INTEGER PRIMARY KEY, id INTEGER NOT NULL, class_id INTEGER NOT NULL, probability REAL NOT NULL,
  first_frame INTEGER NOT NULL, last_frame INTEGER NOT NULL, observations INTEGER NOT NULL, gone_frame INTEGER NOT NULL,
  moved_to INTEGER NOT NULL, voxels INTEGER NOT NULL, x_m REAL NOT NULL, y_m REAL NOT NULL, z_m REAL NOT NULL,
  min_x_m REAL NOT NULL, min_y_m REAL NOT NULL, min_z_m REAL NOT NULL,
  max_x_m REAL NOT NULL, max_y_m REAL NOT NULL, max_z_m REAL NOT NULL) STRICT;

CREATE TABLE arrivals (id INTEGER PRIMARY KEY, moved_from INTEGER NOT NULL, confidence REAL NOT NULL) STRICT;

CREATE VIEW object_history AS
  SELECT objects.id AS id, ifnull(classes.name, 'unknown') AS class, 'present' AS state, first_frame, last_frame,
    NULL AS gone_frame, nullif(arrivals.moved_from, 0) AS moved_from, NULL AS moved_to, arrivals.id IS NOT NULL AS appeared
  FROM objects LEFT JOIN classes ON classes.id = objects.class_id LEFT JOIN arrivals ON arrivals.id = objects.id
  WHERE voxels > 0
  UNION ALL
  SELECT past_objects.id, ifnull(classes.name, 'unknown'), CASE WHEN moved_to = 0 THEN 'gone' ELSE 'moved' END, first_frame,
    last_frame, gone_frame, NULL, nullif(moved_to, 0), 0
  FROM past_objects LEFT JOIN classes ON classes.id = past_objects.class_id
  ORDER BY 1;
)sql";

// The table that formats 1 to 5 lack.
constexpr const char* kTableOfImages = R"sql(
CREATE TABLE frame_images (number INTEGER PRIMARY KEY, checksum INTEGER NOT NULL, images BLOB NOT NULL) STRICT;
)sql";

// Name -> kind and text. Names that begin with sqlite_ are SQLite's own, and nobody else can make one.
using Schema = std::map<std::string, std::pair<std::string, std::string>>;

Schema schema_of(Database& database) {
  Statement rows(database, "SELECT name, type, sql FROM sqlite_schema WHERE name NOT LIKE 'sqlite\\_%' ESCAPE '\\' LIMIT 1000");
  Schema schema;
  while (rows.step()) {
    schema[std::string(rows.text(0))] = {std::string(rows.text(1)), rows.is_null(2) ? "" : std::string(rows.text(2))};
  }
  return schema;
}

void replace(std::string& text, std::string_view what, std::string_view by) {
  const std::size_t at = text.find(what);
  PANOPTIC_ASSERT(at != std::string::npos);
  text.replace(at, what.size(), by);
}

// The statements that make the tables of a format. In format 1 ids were slots, and merged objects were rows like others.
std::string tables_of(std::int64_t format) {
  std::string tables = kTables;
  if (format > 5) tables += kTableOfImages;
  if (format > 4) tables += kTablesOfHistory;
  if (format < 5) replace(tables, ", is_mobile INTEGER NOT NULL", "");
  if (format > 3) tables += kTableOfLog;
  if (format > 2) tables += kTableOfSpace;
  if (format > 1) return tables + kTablesOfIds;
  replace(tables, "slot INTEGER NOT NULL, class_id", "merged_into INTEGER, class_id");
  replace(tables, "WHERE voxels > 0", "WHERE merged_into IS NULL AND voxels > 0");
  return tables;
}

Schema known_schema(std::int64_t format) {
  Database fresh(":memory:", DatabaseAccess::kCreate);
  fresh.execute(tables_of(format).c_str());
  return schema_of(fresh);
}

void require_tables(Database& database, std::int64_t format) {
  const Schema found = schema_of(database);
  const Schema known = known_schema(format);
  for (const auto& [name, entry] : known) {
    const auto at = found.find(name);
    if (at == found.end())
      database.refuse(fmt::format("{} {} is missing; the file is damaged: use another copy", entry.first, name));
    if (at->second != entry) {
      database.refuse(fmt::format("{} {} is not as format {} has it; the file was changed by another program: use another copy",
                                  entry.first, name, format));
    }
  }
  for (const auto& [name, entry] : found) {
    if (known.contains(name)) continue;
    database.refuse(
        fmt::format("it holds the {} '{}', which no map has; remove it, or keep it in a database of its own", entry.first, name));
  }
}

}  // namespace

void set_page_size(Database& database) { database.execute(kPages); }

void create_map_tables(Database& database) {
  database.execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {};", kMapApplicationId, kMapFormat).c_str());
  database.execute(tables_of(kMapFormat).c_str());
}

std::int64_t require_map(Database& database) {
  if (database.integer("PRAGMA application_id") != kMapApplicationId) {
    database.refuse("this is not a map of panoptic; give a file that run --map wrote");
  }
  const std::int64_t format = database.integer("PRAGMA user_version");
  if (format > kMapFormat) {
    database.refuse(fmt::format("it has format {}, and this program knows {}; use a newer panoptic", format, kMapFormat));
  }
  if (format < 1) database.refuse(fmt::format("it has format {}, which never was; use another copy", format));
  const std::string verdict = database.text("PRAGMA quick_check(1)");
  if (verdict == "ok") {
    require_tables(database, format);
    return format;
  }
  database.require_disk(verdict.substr(0, 200));
  database.refuse(fmt::format("it is damaged ({}); use another copy", verdict.substr(0, 200)));
}

std::vector<std::string> lacks_of(std::int64_t format) {
  std::vector<std::string> lacks;
  if (format < 2) {
    lacks.emplace_back("the sum of votes (the weight of the distance is taken)");
    lacks.emplace_back("map.max_weight (weights had no limit)");
    lacks.emplace_back("ids apart from slots (the slots are taken)");
  }
  if (format < 3) lacks.emplace_back("free space (what was seen to be empty is unknown)");
  if (format < 4) lacks.emplace_back("the log of its frames (it cannot follow corrected poses)");
  if (format < 5) lacks.emplace_back("what moved or is gone (neither is known)");
  if (format < 6) lacks.emplace_back("copies of its frames (corrections of poses need the recording)");
  return lacks;
}

}  // namespace panoptic
