// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/catalogue.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "panoptic/base/config.h"
#include "panoptic/error.h"
#include "panoptic/sim/builtin_furniture.h"
#include "panoptic/sim/furniture_archive.h"
#include "panoptic/sim/model_asset.h"
#include "panoptic/sim/parametric.h"

namespace panoptic {
namespace {

constexpr const char* kParametric = "parametric";  // the archive that is none
constexpr double kMaxSize_m = 10;

// One [[furniture]] of the table, as it is written there.
struct Row {
  std::string archive;
  std::string id;
  std::string role;
  std::string class_name;
  std::string name;                   // empty = the archive's
  std::vector<double> size_m;         // empty = the archive's
  std::optional<double> elevation_m;  // absent = 0
  std::vector<double> color;          // parametric only
  int variant = 0;                    // parametric only
  int quarter_turns = 0;
};

Fields fields(Row& row) {
  return {{"archive", &row.archive, "the .sh3f file without its ending, or parametric", required()},
          {"id", &row.id, "the entry in the archive, or the shape", required()},
          {"role", &row.role, "what the placement rules call it", required()},
          {"class", &row.class_name, "a class of the label set scannet20", required()},
          {"name", &row.name, "for people; else the archive's", {}},
          {"size_m", &row.size_m, "width, depth, height; else the archive's", in_range(0.01, kMaxSize_m)},
          {"elevation_m", &row.elevation_m, "of its bottom above the floor or the surface it stands on", in_range(0, kMaxSize_m)},
          {"color", &row.color, "red, green, blue of a parametric shape", in_range(0, 255)},
          {"variant", &row.variant, "of a parametric shape", in_range(0, 1000)},
          {"quarter_turns", &row.quarter_turns, "anticlockwise from above, where the model faces elsewhere", in_range(0, 3)}};
}

std::vector<Row> parse_table(std::string_view text, const std::string& source) {
  std::vector<Row> rows;
  const auto append = [&]() -> Fields { return fields(rows.emplace_back()); };
  read_toml_text(text, source, {{"furniture", AppendTable(append), "what can stand in a home", required()}});
  return rows;
}

void require_count(const std::vector<double>& numbers, std::string_view key, const Row& row) {
  if (!numbers.empty() && numbers.size() != 3)
    throw Error(
        fmt::format("furniture table, {} of {}: {} needs three numbers, found {}", row.id, row.archive, key, numbers.size()));
}

Vec3f size_of(const Row& row, const ArchiveEntry* entry) {
  require_count(row.size_m, "size_m", row);
  if (!row.size_m.empty()) return Eigen::Map<const Vec3d>(row.size_m.data()).cast<float>();
  if (entry == nullptr) throw Error(fmt::format("furniture table: the parametric {} needs size_m", row.id));
  const Vec3f& size = entry->size_m;
  return row.quarter_turns % 2 == 0 ? size : Vec3f(size.y(), size.x(), size.z());
}

Rgb color_of_row(const Row& row) {
  require_count(row.color, "color", row);
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(std::lround(row.color[i])); };
  return row.color.empty() ? Rgb{200, 200, 200} : Rgb{byte(0), byte(1), byte(2)};
}

}  // namespace

struct Catalogue::State {
  std::vector<Row> rows;
  std::vector<Furniture> furniture;  // one per row
  std::map<std::string, FurnitureArchive> archives;
  std::vector<std::optional<ModelAsset>> loaded;  // one per row

  const ArchiveEntry& entry_of(const Row& row, const std::filesystem::path& folder);
  Furniture to_furniture(const Row& row, const LabelSet& labels, const std::filesystem::path& folder);
  ModelAsset load(std::size_t index) const;
};

const ArchiveEntry& Catalogue::State::entry_of(const Row& row, const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / (row.archive + ".sh3f");
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    throw Error(
        fmt::format("{}: no such file; the furniture comes with the Debian package sweethome3d-furniture: "
                    "sudo apt install sweethome3d-furniture",
                    path.string()));
  }
  const FurnitureArchive& archive = archives.try_emplace(row.archive, path).first->second;
  const ArchiveEntry* entry = archive.find(row.id);
  if (entry == nullptr) {
    throw Error(
        fmt::format("{}: no entry {}, which the furniture table names; is the package sweethome3d-furniture of another version?",
                    path.string(), row.id));
  }
  return *entry;
}

Furniture Catalogue::State::to_furniture(const Row& row, const LabelSet& labels, const std::filesystem::path& folder) {
  const LabelClass* label = labels.find(std::string_view(row.class_name));
  if (label == nullptr)
    throw Error(fmt::format("furniture table, {}: there is no class '{}' in scannet20", row.id, row.class_name));
  const ArchiveEntry* entry = row.archive == kParametric ? nullptr : &entry_of(row, folder);
  if (entry == nullptr) require_parametric_shape(row.id);
  color_of_row(row);
  std::string name = row.name;
  if (name.empty()) name = entry != nullptr ? entry->name : row.id;
  return {name, row.role, label->id, size_of(row, entry), static_cast<float>(row.elevation_m.value_or(0))};
}

ModelAsset Catalogue::State::load(std::size_t index) const {
  const Row& row = rows[index];
  const Vec3f& size_m = furniture[index].size_m;
  ModelAsset asset;
  if (row.archive == kParametric) {
    asset = make_parametric({row.id, size_m, color_of_row(row), row.variant});
  } else {
    const FurnitureArchive& archive = archives.at(row.archive);
    asset = archive.load(*archive.find(row.id));
  }
  fit_to_size(asset.model, row.quarter_turns, size_m);
  asset.model.name = furniture[index].name;
  return asset;
}

Catalogue::Catalogue(const std::filesystem::path& folder) : Catalogue(folder, builtin_furniture("furniture").value()) {}

Catalogue::Catalogue(const std::filesystem::path& folder, std::string_view table) : state_(std::make_unique<State>()) {
  const LabelSet labels = load_label_set("scannet20");
  state_->rows = parse_table(table, "furniture table");
  for (const Row& row : state_->rows) state_->furniture.push_back(state_->to_furniture(row, labels, folder));
  state_->loaded.resize(state_->rows.size());
}

Catalogue::~Catalogue() = default;

const std::vector<Furniture>& Catalogue::furniture() const { return state_->furniture; }

std::vector<std::size_t> Catalogue::with_role(std::string_view role) const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < state_->furniture.size(); ++i) {
    if (state_->furniture[i].role == role) found.push_back(i);
  }
  return found;
}

std::uint32_t Catalogue::add_model(std::size_t furniture, Scene& scene) const {
  PANOPTIC_ASSERT(furniture < state_->rows.size());
  std::optional<ModelAsset>& asset = state_->loaded[furniture];
  if (!asset) asset = state_->load(furniture);
  return append_asset(*asset, scene);
}

}  // namespace panoptic
