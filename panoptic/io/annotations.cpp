// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/annotations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "panoptic/io/draw_text.h"
#include "panoptic/io/viewpoints.h"

namespace panoptic {
namespace {

constexpr Rgb kUnknownColor = {168, 168, 164};
constexpr Rgb kInk = {45, 48, 54};
constexpr double kLegendScale = 0.5;
constexpr double kNameScale = 0.45;
constexpr std::int64_t kSmallestNamed_px = 250;

struct Rectangle {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;

  PixelBox box() const { return {left, top, left + width, top + height}; }
  bool overlaps(const Rectangle& other) const {
    return left < other.left + other.width && other.left < left + width && top < other.top + other.height &&
           other.top < top + height;
  }
};

// The visible part of one label.
struct Visible {
  std::uint32_t label = 0;
  std::int64_t pixels = 0;
  double u_sum = 0;
  double v_sum = 0;
  int u = 0;  // of its pixel that is nearest to its middle
  int v = 0;
  double nearest = std::numeric_limits<double>::infinity();
};

template <typename Body>
void for_each_covered(const Picture& picture, const Body& body) {
  for (int v = 0; v < picture.label.height(); ++v) {
    for (int u = 0; u < picture.label.width(); ++u) {
      if (picture.covered(u, v) != 0) body(u, v, picture.label(u, v));
    }
  }
}

// The labels in the picture, the largest first.
std::vector<Visible> visible_labels(const Picture& picture) {
  std::unordered_map<std::uint32_t, Visible> all;
  for_each_covered(picture, [&](int u, int v, std::uint32_t label) {
    Visible& visible = all[label];
    visible.label = label;
    visible.pixels++;
    visible.u_sum += u;
    visible.v_sum += v;
  });
  for_each_covered(picture, [&](int u, int v, std::uint32_t label) {
    Visible& visible = all[label];
    const auto count = static_cast<double>(visible.pixels);
    const double away = std::hypot(u - visible.u_sum / count, v - visible.v_sum / count);
    if (away < visible.nearest) visible.nearest = away, visible.u = u, visible.v = v;
  });
  std::vector<Visible> present;
  for (const auto& [label, visible] : all) present.push_back(visible);
  std::sort(present.begin(), present.end(),
            [](const Visible& a, const Visible& b) { return std::pair(-a.pixels, a.label) < std::pair(-b.pixels, b.label); });
  return present;
}

struct LegendEntry {
  std::string name;
  Rgb color;
};

// Swatches and names in up to two rows at the bottom; what does not fit is counted.
void draw_legend(Image<Rgb>& image, const std::vector<LegendEntry>& entries) {
  constexpr int kRow_px = 24;
  constexpr int kSwatch_px = 14;
  constexpr int kGap_px = 7;
  constexpr int kRoomForMore_px = 90;
  if (entries.empty()) return;
  const int top = image.height() - kLegendRows_px;
  fill(image, {0, top, image.width(), image.height()}, {255, 255, 255}, 0.6);
  int u = 2 * kGap_px;
  int row = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const TextSize size = text_size(entries[i].name, kLegendScale);
    const int width = kSwatch_px + kGap_px + size.width_px + 2 * kGap_px;
    if (u + width > image.width() - (row == 1 ? kRoomForMore_px : 0) && u > 2 * kGap_px) {
      ++row;
      u = row < 2 ? 2 * kGap_px : u;
    }
    const int baseline = top + 4 + std::min(row, 1) * kRow_px + (kRow_px + size.height_px) / 2;
    if (row == 2) {
      draw_text(image, fmt::format("+ {} more", entries.size() - i), u, baseline, kInk, kLegendScale);
      return;
    }
    const int swatch = baseline - (size.height_px + kSwatch_px) / 2;
    fill(image, {u, swatch, u + kSwatch_px, swatch + kSwatch_px}, entries[i].color);
    draw_text(image, entries[i].name, u + kSwatch_px + kGap_px, baseline, kInk, kLegendScale);
    u += width;
  }
}

// Near (u, v), but clear of the names that are there already; nothing if there is no room.
bool place(Rectangle& area, const std::vector<Rectangle>& taken, int rows) {
  const Rectangle wanted = area;
  for (const int shift : {0, -1, 1, -2, 2}) {
    area.top = wanted.top + shift * (wanted.height + 1);
    const bool is_inside = area.top >= 0 && area.top + area.height <= rows;
    if (is_inside && std::none_of(taken.begin(), taken.end(), [&](const Rectangle& other) { return area.overlaps(other); }))
      return true;
  }
  return false;
}

void draw_name(Image<Rgb>& image, const std::string& name, const Visible& visible, std::vector<Rectangle>& taken) {
  constexpr int kPad_px = 4;
  const TextSize size = text_size(name, kNameScale);
  Rectangle area{visible.u - size.width_px / 2 - kPad_px, visible.v - size.height_px / 2 - kPad_px, size.width_px + 2 * kPad_px,
                 size.height_px + 2 * kPad_px + 2};
  area.left = std::clamp(area.left, 0, std::max(0, image.width() - area.width));
  if (!place(area, taken, image.height() - kLegendRows_px)) return;
  taken.push_back(area);
  fill(image, area.box(), {20, 22, 26}, 0.62);
  draw_text(image, name, area.left + kPad_px, area.top + kPad_px + size.height_px, {255, 255, 255}, kNameScale);
}

std::map<PanopticId, ClassId> classes_of(const Mesh& mesh) {
  std::map<PanopticId, ClassId> classes;
  auto last = classes.end();  // neighbours mostly bear the same id
  for (const MeshVertex& vertex : mesh.vertices) {
    if (last == classes.end() || last->first != vertex.panoptic_id) last = classes.try_emplace(vertex.panoptic_id).first;
    last->second = vertex.class_id;
  }
  return classes;
}

}  // namespace

Rgb picture_color(PanopticId id, const LabelSet& labels) {
  return id == PanopticId::kUnknown ? kUnknownColor : color_of(id, labels);
}

void draw_class_legend(Picture& picture, const LabelSet& labels) {
  std::vector<LegendEntry> entries;
  for (const Visible& visible : visible_labels(picture)) {
    const auto class_id = static_cast<ClassId>(visible.label);
    entries.push_back({std::string(labels.name_of(class_id)), picture_color(LabelSet::id_of_class(class_id), labels)});
  }
  draw_legend(picture.color, entries);
}

void draw_object_names(Picture& picture, const Mesh& mesh, const LabelSet& labels) {
  const std::map<PanopticId, ClassId> classes = classes_of(mesh);
  std::vector<LegendEntry> stuff;
  std::vector<Rectangle> taken;
  std::size_t objects = 0;
  for (const Visible& visible : visible_labels(picture)) {
    const auto id = static_cast<PanopticId>(visible.label);
    if (!labels.is_object(id)) {
      stuff.push_back({std::string(labels.name_of(static_cast<ClassId>(visible.label))), picture_color(id, labels)});
      continue;
    }
    ++objects;
    if (visible.pixels < kSmallestNamed_px) continue;
    const auto class_id = classes.find(id);
    const std::string_view name = labels.name_of(class_id != classes.end() ? class_id->second : ClassId::kUnknown);
    draw_name(picture.color, fmt::format("{} {}", name, visible.label), visible, taken);
  }
  draw_legend(picture.color, stuff);
  const std::string count = fmt::format("{} {} in sight", objects, objects == 1 ? "object" : "objects");
  if (objects > 0) {
    const TextSize size = text_size(count, kLegendScale);
    draw_text(picture.color, count, picture.color.width() - size.width_px - 16, picture.color.height() - 14, kInk, kLegendScale);
  }
}

}  // namespace panoptic
