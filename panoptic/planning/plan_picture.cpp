// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/plan_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/io/draw_text.h"
#include "panoptic/planning/mixed_color.h"

namespace panoptic {
namespace {

constexpr Rgb kPaper = {252, 252, 250};
constexpr Rgb kInk = {45, 45, 50};
constexpr Rgb kFloor = {235, 229, 219};
constexpr Rgb kWalkable = {213, 236, 209};
constexpr Rgb kWall = {92, 92, 98};
constexpr Rgb kUnnamed = {200, 200, 198};
constexpr Rgb kWay = {25, 95, 215};
constexpr Rgb kStart = {30, 150, 60};
constexpr Rgb kGoal = {205, 45, 45};
constexpr Rgb kWhite = {255, 255, 255};
constexpr int kRim_px = 24;
constexpr int kLine_px = 30;  // of the legend
constexpr int kLongest_px = 1400;
constexpr double kText = 0.5;

// Pixels per cell, and where cells lie in the picture.
struct Sheet {
  const GroundGrid& grid;
  int px = 1;

  Eigen::Vector2d pixel_of(const Vec3d& p) const {
    const double u = (p.x() / grid.cell_m - grid.low.x()) * px + kRim_px;
    const double v = (grid.low.y() + grid.size.y() - p.y() / grid.cell_m) * px + kRim_px;
    return {u, v};
  }
  Eigen::Vector2d place_m(int u, int v) const {
    return {(grid.low.x() + (u - kRim_px + 0.5) / px) * grid.cell_m,
            (grid.low.y() + grid.size.y() - (v - kRim_px + 0.5) / px) * grid.cell_m};
  }
};

Rgb color_of_class(ClassId id, const LabelSet& labels) {
  const std::string_view name = labels.name_of(id);
  if (name == "wall") return kWall;
  if (id == ClassId::kUnknown) return kUnnamed;
  constexpr double kPale = 0.35;
  return mixed(color_of(LabelSet::id_of_class(id), labels), kWhite, kPale);
}

bool is_walkable_at(const SolidColumns& columns, const Eigen::Vector2d& at_m) {
  const Eigen::Vector2i spot = columns.grid.around(at_m);
  if (!columns.grid.contains(spot)) return false;
  const auto spans = columns.of(columns.grid.index(spot));
  return std::any_of(spans.begin(), spans.end(), [](const SolidSpan& span) { return span.is_walkable; });
}

// The classes in the picture, the largest first.
std::vector<ClassId> classes_in(const SemanticGrid& semantic) {
  std::map<ClassId, std::size_t> cells;
  for (std::size_t i = 0; i < semantic.class_at.size(); ++i) {
    if (semantic.is_seen[i] != 0) ++cells[semantic.class_at[i]];
  }
  std::vector<std::pair<ClassId, std::size_t>> sorted(cells.begin(), cells.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::vector<ClassId> classes;
  for (const auto& [id, count] : sorted) classes.push_back(id);
  return classes;
}

void draw_ground(Image<Rgb>& image, const Sheet& sheet, const SemanticGrid& semantic, const LabelSet& labels,
                 const SolidColumns& columns) {
  const int u_end = std::min(image.width(), kRim_px + sheet.grid.size.x() * sheet.px);
  const int v_end = std::min(image.height(), kRim_px + sheet.grid.size.y() * sheet.px);
  const auto class_near = [&](int u, int v) {
    const Eigen::Vector2i spot = sheet.grid.around(sheet.place_m(u, v));
    if (!sheet.grid.contains(spot) || semantic.is_seen[sheet.grid.index(spot)] == 0) return -1;
    return int{number(semantic.class_at[sheet.grid.index(spot)])};
  };
  for (int v = kRim_px; v < v_end; ++v) {
    for (int u = kRim_px; u < u_end; ++u) {
      const int here = class_near(u, v);
      if (here < 0) continue;
      const ClassId id{static_cast<std::uint16_t>(here)};
      const bool is_floor = is_floor_class(labels, id);
      Rgb color = is_floor ? kFloor : color_of_class(id, labels);
      if (is_walkable_at(columns, sheet.place_m(u, v))) color = kWalkable;
      const bool is_edge = !is_floor && (class_near(u + 1, v) != here || class_near(u, v + 1) != here ||
                                         class_near(u - 1, v) != here || class_near(u, v - 1) != here);
      image(u, v) = is_edge ? mixed(color, kInk, 0.45) : color;
    }
  }
}

double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length = along.squaredNorm();
  const double share = length > 0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

// A smooth thick line; of no length, a disc.
void draw_line(Image<Rgb>& image, const Eigen::Vector2d& a, const Eigen::Vector2d& b, double half_px, const Rgb& color) {
  const Eigen::Vector2d low = a.cwiseMin(b).array() - half_px - 1;
  const Eigen::Vector2d high = a.cwiseMax(b).array() + half_px + 1;
  for (int v = std::max(0, static_cast<int>(low.y())); v < std::min<double>(image.height(), high.y() + 1); ++v) {
    for (int u = std::max(0, static_cast<int>(low.x())); u < std::min<double>(image.width(), high.x() + 1); ++u) {
      const double cover = std::clamp(half_px + 0.5 - distance_to_segment({u + 0.5, v + 0.5}, a, b), 0.0, 1.0);
      if (cover > 0) image(u, v) = mixed(image(u, v), color, cover);
    }
  }
}

void draw_way(Image<Rgb>& image, const Sheet& sheet, const Path& path, const std::vector<Vec3d>& ends_m) {
  constexpr double kHalf_px = 2.2;
  for (const auto& [color, more] : {std::pair(kWhite, 2.0), std::pair(kWay, 0.0)}) {
    for (std::size_t i = 1; i < path.points_m.size(); ++i) {
      draw_line(image, sheet.pixel_of(path.points_m[i - 1]), sheet.pixel_of(path.points_m[i]), kHalf_px + more, color);
    }
  }
  constexpr double kDisc_px = 7;
  for (std::size_t i = 0; i < ends_m.size(); ++i) {
    const Eigen::Vector2d at = sheet.pixel_of(ends_m[i]);
    draw_line(image, at, at, kDisc_px + 2, kWhite);
    draw_line(image, at, at, kDisc_px, i == 0 ? kStart : kGoal);
  }
}

// A box and a word, and where the next one goes.
void add_word(Image<Rgb>& image, int& u, int& v, const std::string& word, const Rgb& color) {
  constexpr int kBox_px = 14;
  constexpr int kGap_px = 8;
  const int width = kBox_px + kGap_px + text_size(word, kText).width_px + 3 * kGap_px;
  if (u + width > image.width() - kRim_px && u > kRim_px) {
    u = kRim_px;
    v += kLine_px;
  }
  fill(image, {u - 1, v - 1, u + kBox_px + 1, v + kBox_px + 1}, mixed(color, kInk, 0.45));
  fill(image, {u, v, u + kBox_px, v + kBox_px}, color);
  draw_text(image, word, u + kBox_px + kGap_px, v + kBox_px - 2, kInk, kText);
  u += width;
}

void draw_scale(Image<Rgb>& image, const Sheet& sheet, int v) {
  const double metre_px = sheet.px / sheet.grid.cell_m;
  const Eigen::Vector2d left(kRim_px + 2.0, v + 7.0);
  draw_line(image, left, left + Eigen::Vector2d(metre_px, 0), 1, kInk);
  for (const double end : {0.0, metre_px}) {
    draw_line(image, left + Eigen::Vector2d(end, -4), left + Eigen::Vector2d(end, 4), 1, kInk);
  }
  draw_text(image, "1 m", kRim_px + static_cast<int>(metre_px) + 12, v + 12, kInk, kText);
}

}  // namespace

Image<Rgb> draw_path(const SemanticGrid& semantic, const LabelSet& labels, const Ground& ground, const Path& path,
                     const std::vector<Vec3d>& ends_m) {
  constexpr int kMostPerCell_px = 8;
  constexpr int kNarrowest_px = 480;
  const GroundGrid& grid = semantic.grid;
  const int px = std::clamp(kLongest_px / std::max({grid.size.x(), grid.size.y(), 1}), 1, kMostPerCell_px);
  const Sheet sheet{grid, px};
  const std::vector<ClassId> classes = classes_in(semantic);
  const int width = std::max(kNarrowest_px, grid.size.x() * px + 2 * kRim_px);
  const int below = grid.size.y() * px + 2 * kRim_px;
  const int legend_lines = 2 + static_cast<int>(classes.size()) * 150 / width;
  Image<Rgb> image(width, below + legend_lines * kLine_px + kRim_px, kPaper);
  draw_ground(image, sheet, semantic, labels, ground.columns);
  draw_way(image, sheet, path, ends_m);
  draw_scale(image, sheet, below);
  const std::string words =
      path.found ? fmt::format("way of {:.2f} m, radius {:.2f} m", path.length_m, ground.agent.radius_m) : path.why_not;
  draw_text(image, words, kRim_px + static_cast<int>(px / grid.cell_m) + 70, below + 12, path.found ? kWay : kGoal, kText);
  int u = kRim_px;
  int v = below + kLine_px;
  add_word(image, u, v, "walkable", kWalkable);
  for (const ClassId id : classes) {
    const bool is_floor = is_floor_class(labels, id);
    add_word(image, u, v, std::string(labels.name_of(id)), is_floor ? kFloor : color_of_class(id, labels));
  }
  return image;
}

}  // namespace panoptic
