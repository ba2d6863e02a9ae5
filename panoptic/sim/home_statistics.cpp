// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/home_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "panoptic/labels.h"
#include "panoptic/sim/clearance_map.h"

namespace panoptic {
namespace {

constexpr double kScale = 60;  // pixels per metre
constexpr double kMargin_m = 0.3;
constexpr Rgb kPaper{255, 255, 255};
constexpr Rgb kFloor{238, 232, 220};
constexpr Rgb kInk{40, 40, 40};
constexpr Rgb kPath{220, 30, 30};
constexpr Rgb kGaze{250, 170, 40};

// A picture of the floor: world metres in, pixels out.
class Sheet {
 public:
  explicit Sheet(const Eigen::AlignedBox2d& area) : area_(area) {
    const Eigen::Vector2d size_px = area.sizes() * kScale;
    image_ = Image<Rgb>(static_cast<int>(size_px.x()), static_cast<int>(size_px.y()), kPaper);
  }

  void dot(const Eigen::Vector2d& point, const Rgb& color) {
    const int u = static_cast<int>(std::floor((point.x() - area_.min().x()) * kScale));
    const int v = static_cast<int>(std::floor((area_.max().y() - point.y()) * kScale));
    if (u >= 0 && v >= 0 && u < image_.width() && v < image_.height()) image_(u, v) = color;
  }

  void line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Rgb& color) {
    const int steps = static_cast<int>((to - from).norm() * kScale * 2) + 1;
    for (int i = 0; i <= steps; ++i) dot(from + (to - from) * i / steps, color);
  }

  void fill(const FloorRect& rect, const Rgb& color) {
    const Eigen::Vector2d steps = (rect.half_m * kScale * 4).array().ceil().max(1);
    for (int y = 0; y <= steps.y(); ++y) {
      for (int x = 0; x <= steps.x(); ++x) {
        const Eigen::Vector2d at = rect.half_m.cwiseProduct(Eigen::Vector2d(2 * x / steps.x() - 1, 2 * y / steps.y() - 1));
        dot(rect.center + rect.axis * at.x() + rect.across() * at.y(), color);
      }
    }
  }

  void outline(const FloorRect& rect, const Rgb& color) {
    const Eigen::Vector2d right = rect.axis * rect.half_m.x();
    const Eigen::Vector2d back = rect.across() * rect.half_m.y();
    const Eigen::Vector2d& c = rect.center;
    line(c - right - back, c + right - back, color);
    line(c + right - back, c + right + back, color);
    line(c + right + back, c - right + back, color);
    line(c - right + back, c - right - back, color);
  }

  Image<Rgb> image() && { return std::move(image_); }

 private:
  Eigen::AlignedBox2d area_;
  Image<Rgb> image_;
};

void draw_thing(const ThingBox& thing, const Rgb& color, Sheet& sheet) {
  sheet.fill(thing.base, color);
  sheet.outline(thing.base, kInk);
  const Eigen::Vector2d front = thing.base.center - thing.base.across() * thing.base.half_m.y();
  sheet.line(thing.base.center, front, kInk);
}

void draw_path(const std::vector<Pose>& path, Sheet& sheet) {
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Eigen::Vector2d eye = path[i].translation().head<2>();
    if (i % 45 == 0) sheet.line(eye, eye + path[i].linear().col(2).head<2>() * 0.4, kGaze);
    sheet.fill({eye, {0.02, 0.02}, Eigen::Vector2d::UnitX()}, kPath);
  }
}

}  // namespace

HomeStatistics statistics(const Home& home) {
  const LabelSet labels = load_label_set("scannet20");
  HomeStatistics numbers;
  for (const Room& room : home.rooms) numbers.floor_m2 += room.floor.volume();
  for (const SceneObject& object : home.scene.objects) {
    numbers.triangles += home.scene.models[object.model].triangles.size();
    if (object.instance == 0) continue;
    ++numbers.objects;
    ++numbers.objects_of[std::string(labels.name_of(object.class_id))];
  }
  return numbers;
}

std::string to_text(const HomeStatistics& statistics, const Home& home) {
  std::string text = fmt::format("{:.1f} m2 in {} rooms, {} objects, {} triangles\n", statistics.floor_m2, home.rooms.size(),
                                 statistics.objects, statistics.triangles);
  for (const auto& [name, count] : statistics.objects_of) text += fmt::format("  {:<16}{:>4}\n", name, count);
  return text;
}

Image<Rgb> draw_plan(const Home& home, const std::vector<Pose>& path) {
  const LabelSet labels = load_label_set("scannet20");
  Eigen::AlignedBox2d area;
  for (const Room& room : home.rooms) area.extend(room.floor);
  Sheet sheet(Eigen::AlignedBox2d(area.min().array() - kMargin_m, area.max().array() + kMargin_m));
  for (const Room& room : home.rooms) sheet.fill(rect_of(room.floor), kFloor);
  for (const FloorRect& wall : wall_rects(home)) sheet.fill(grown(wall, 0.03), kInk);
  std::vector<ThingBox> things = thing_boxes(home.scene);
  std::stable_sort(things.begin(), things.end(), [](const ThingBox& a, const ThingBox& b) { return a.top_m < b.top_m; });
  std::map<std::uint16_t, Rgb> color_of;
  for (const SceneObject& object : home.scene.objects) {
    const LabelClass* it = labels.find(object.class_id);
    color_of[object.instance] = it != nullptr ? it->color : Rgb{200, 200, 200};
  }
  for (const ThingBox& thing : things) draw_thing(thing, color_of[thing.instance], sheet);
  draw_path(path, sheet);
  return std::move(sheet).image();
}

}  // namespace panoptic
