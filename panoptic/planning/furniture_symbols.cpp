// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/furniture_symbols.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "panoptic/planning/labelled_surface.h"

namespace panoptic {
namespace {

using ToSheet = std::function<Vec2d(const Vec2d&)>;

std::string points_of(const Polygon& polygon, const ToSheet& to_sheet) {
  std::string text;
  for (const Vec2d& corner : polygon) text += fmt::format("{:.1f},{:.1f} ", to_sheet(corner).x(), to_sheet(corner).y());
  if (!text.empty()) text.pop_back();
  return text;
}

std::string shape(const Polygon& polygon, const char* style, const ToSheet& to_sheet) {
  return fmt::format("<polygon points=\"{}\" class=\"{}\"/>\n", points_of(polygon, to_sheet), style);
}

// A thing's box with the direction that it faces.
struct Fronted {
  FlatBox box;
  Vec2d front = Vec2d::UnitX();

  // Points by shares of the box: -1 to 1 from left to right of who sits there, -1 to 1 from back to front.
  Vec2d at(double right, double forward) const {
    const double along = std::abs(box.axis.dot(front)) > 0.7 ? box.size_m.x() : box.size_m.y();
    const double across = std::abs(box.axis.dot(front)) > 0.7 ? box.size_m.y() : box.size_m.x();
    return box.center + front * forward * along / 2 - quarter_turn(front) * right * across / 2;
  }
  Polygon part(const Vec2d& low, const Vec2d& high) const {
    return {at(low.x(), low.y()), at(high.x(), low.y()), at(high.x(), high.y()), at(low.x(), high.y())};
  }
};

// The side of the box that is nearest to a direction.
Vec2d side_towards(const FlatBox& box, const Vec2d& direction) {
  const Vec2d across = quarter_turn(box.axis);
  const double a = box.axis.dot(direction);
  const double b = across.dot(direction);
  if (std::abs(a) > std::abs(b)) return a > 0 ? box.axis : Vec2d(-box.axis);
  return b > 0 ? across : Vec2d(-across);
}

std::optional<Vec2d> facing_of(const HomePlan& plan, PanopticId object) {
  for (const Seat& seat : plan.seats) {
    if (seat.object == object) return Vec2d(seat.facing.head<2>());
  }
  return std::nullopt;
}

// A back rest, and arm rests where the thing is wide.
std::string seat_svg(const HomePlan& plan, const ThingFootprint& print, const ToSheet& to_sheet) {
  const FlatBox box = smallest_box(convex_hull(print.polygon));
  const auto facing = facing_of(plan, print.object);
  if (!facing) return shape(print.polygon, "thing", to_sheet);
  const Fronted chair{box, side_towards(box, *facing)};
  const Polygon frame = chair.part({-1, -1}, {1, 1});
  std::string text = shape(frame, "thing", to_sheet) + shape(chair.part({-1, -1}, {1, -0.7}), "detail", to_sheet);
  const auto places =
      std::count_if(plan.seats.begin(), plan.seats.end(), [&](const Seat& s) { return s.object == print.object; });
  if (places < 2) return text;
  const double arm = 0.12;
  for (const double side : {-1.0, 1.0}) text += shape(chair.part({side, -0.7}, {side * (1 - arm), 1}), "detail", to_sheet);
  for (int i = 1; i < places; ++i) {
    const double x = -(1 - arm) + 2 * (1 - arm) * i / static_cast<double>(places);
    text += shape({chair.at(x, -0.7), chair.at(x, 1)}, "detail", to_sheet);
  }
  return text;
}

// Pillows at the head and a turned-down blanket.
std::string bed_svg(const HomePlan& plan, const ThingFootprint& print, const ToSheet& to_sheet) {
  const FlatBox box = smallest_box(convex_hull(print.polygon));
  Vec2d head = box.axis;
  for (const LyingPlace& place : plan.lying_places) {
    if (place.object == print.object) head = side_towards(box, place.axis.head<2>());
  }
  const Fronted bed{box, -head};
  std::string text =
      shape(bed.part({-1, -1}, {1, 1}), "thing", to_sheet) + shape({bed.at(-1, -0.45), bed.at(1, -0.45)}, "detail", to_sheet);
  const bool is_double = box.size_m.y() > 1.2;
  if (!is_double) return text + shape(bed.part({-0.75, -0.92}, {0.75, -0.58}), "detail", to_sheet);
  return text + shape(bed.part({-0.9, -0.92}, {-0.08, -0.58}), "detail", to_sheet) +
         shape(bed.part({0.08, -0.92}, {0.9, -0.58}), "detail", to_sheet);
}

// An ellipse within the box: bowls, tubs, pots.
std::string bowl_svg(const ThingFootprint& print, double share, const ToSheet& to_sheet) {
  const FlatBox box = smallest_box(convex_hull(print.polygon));
  Polygon ring;
  for (int i = 0; i < 24; ++i) {
    const double angle = i * 2 * std::numbers::pi / 24;
    ring.push_back(box.center + box.axis * std::cos(angle) * box.size_m.x() * share / 2 +
                   quarter_turn(box.axis) * std::sin(angle) * box.size_m.y() * share / 2);
  }
  return shape(ring, "detail", to_sheet);
}

// Shelves and cabinets have a diagonal, as do refrigerators.
std::string cross_svg(const ThingFootprint& print, const ToSheet& to_sheet) {
  const Polygon c = corners(smallest_box(convex_hull(print.polygon)));
  return shape({c[0], c[2]}, "detail", to_sheet) + shape({c[1], c[3]}, "detail", to_sheet);
}

bool is_built_in(std::string_view name) {
  return name == "window" || is_door_class(name) || name == "picture" || name == "curtain";
}

std::string symbol(const HomePlan& plan, const ThingFootprint& print, std::string_view name, const ToSheet& to_sheet) {
  constexpr double kAboveHeads_m = 1.2;
  if (is_seat_class(name)) return seat_svg(plan, print, to_sheet);
  if (name == "bed") return bed_svg(plan, print, to_sheet);
  if (print.low_m > kAboveHeads_m) return shape(print.polygon, "high", to_sheet);
  std::string text = shape(print.polygon, "thing", to_sheet);
  if (name == "toilet" || name == "bathtub" || name == "sink") text += bowl_svg(print, 0.8, to_sheet);
  if (name == "bookshelf" || name == "refrigerator") text += cross_svg(print, to_sheet);
  return text;
}

// Around a name on the sheet, upright or not.
Eigen::AlignedBox2d name_area(const Vec2d& at, double length_cm, double degrees) {
  constexpr double kHalfHeight_cm = 5;
  const double angle = degrees * std::numbers::pi / 180;
  const Vec2d half(length_cm / 2 * std::abs(std::cos(angle)), length_cm / 2 * std::abs(std::sin(angle)));
  return {at - half - Vec2d::Constant(kHalfHeight_cm), at + half + Vec2d::Constant(kHalfHeight_cm)};
}

// A name where it fits, and covers none of those that are there already: along the longer side of the thing if that runs up or
// down the sheet.
std::string name_svg(const ThingFootprint& print, std::string_view name, const ToSheet& to_sheet,
                     std::vector<Eigen::AlignedBox2d>& taken) {
  constexpr double kLetter_cm = 4.8;
  constexpr double kHeight_cm = 11;
  const FlatBox box = smallest_box(convex_hull(print.polygon));
  const double length_cm = kLetter_cm * static_cast<double>(name.size());
  const Vec2d size_cm = box.size_m * 100;
  if (size_cm.x() < length_cm || size_cm.y() < kHeight_cm) return "";
  const Vec2d at = to_sheet(box.center);
  const Vec2d along = to_sheet(box.center + box.axis) - at;
  double degrees = std::atan2(along.y(), along.x()) * 180 / std::numbers::pi;
  if (size_cm.y() > length_cm) degrees = 0;
  if (degrees > 90.5) degrees -= 180;
  if (degrees < -90.5) degrees += 180;
  const Eigen::AlignedBox2d area = name_area(at, length_cm, degrees);
  if (std::any_of(taken.begin(), taken.end(), [&](const Eigen::AlignedBox2d& other) { return other.intersects(area); }))
    return "";
  taken.push_back(area);
  return fmt::format(
      "<text x=\"{0:.1f}\" y=\"{1:.1f}\" class=\"name halo\" transform=\"rotate({2:.1f} {0:.1f} {1:.1f})\" dy=\"3\">{3}</text>\n",
      at.x(), at.y(), degrees, as_xml(name));
}

bool stands_on_another(const HomePlan& plan, const ThingFootprint& print) {
  return std::any_of(plan.furniture.begin(), plan.furniture.end(), [&](const ThingFootprint& other) {
    return other.object != print.object && other.high_m < print.low_m + 0.1 && print.low_m > 0.25 &&
           contains(other.polygon, centroid(print.polygon));
  });
}

}  // namespace

std::string as_xml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string furniture_svg(const HomePlan& plan, const LabelSet& labels, const ToSheet& to_sheet) {
  std::vector<const ThingFootprint*> by_height;
  for (const ThingFootprint& print : plan.furniture) {
    if (!is_built_in(labels.name_of(print.class_id))) by_height.push_back(&print);
  }
  // Chairs lie below the tables that they are pushed under.
  const auto height_m = [&](const ThingFootprint* print) {
    constexpr double kKnee_m = 0.5;
    return is_seat_class(labels.name_of(print->class_id)) ? std::min(kKnee_m, print->high_m) : print->high_m;
  };
  std::stable_sort(by_height.begin(), by_height.end(),
                   [&](const ThingFootprint* a, const ThingFootprint* b) { return height_m(a) < height_m(b); });
  std::string text;
  std::vector<const ThingFootprint*> named;  // from the lowest to the highest
  for (const ThingFootprint* print : by_height) {
    const std::string_view name = labels.name_of(print->class_id);
    text += symbol(plan, *print, name, to_sheet);
    const bool is_named = name != "otherfurniture" && name != "other" && name != "unknown" && !stands_on_another(plan, *print);
    if (is_named) named.push_back(print);
  }
  std::vector<Eigen::AlignedBox2d> taken;
  for (auto at = named.rbegin(); at != named.rend(); ++at) {
    const Vec2d middle = smallest_box(convex_hull((*at)->polygon)).center;
    const bool is_hidden =
        std::any_of(named.rbegin(), at, [&](const ThingFootprint* above) { return contains(above->polygon, middle); });
    if (!is_hidden) text += name_svg(**at, labels.name_of((*at)->class_id), to_sheet, taken);
  }
  return text;
}

}  // namespace panoptic
