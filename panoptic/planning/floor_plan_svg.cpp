// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The floor plan. One unit of the drawing is a centimetre; y runs down, so that the plan is seen from above.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "panoptic/base/polygon.h"
#include "panoptic/home_plan.h"
#include "panoptic/planning/furniture_symbols.h"

namespace panoptic {
namespace {

constexpr double kOuterWall_cm = 14;  // drawn beyond the faces; who is inside does not see how thick a wall is
constexpr double kMargin_cm = 90;
constexpr const char* kStyle =
    "text{font-family:Helvetica,Arial,sans-serif;fill:#222;text-anchor:middle}"
    ".wall{fill:#2b2b2b;stroke:#2b2b2b;stroke-linejoin:miter;stroke-miterlimit:3}"
    ".floor{fill:#fbfaf7}.gap{fill:#fbfaf7}"
    ".wet{fill:#eef4f6}"
    ".thing{fill:#fff;stroke:#555;stroke-width:1.4;stroke-linejoin:round}"
    ".detail{fill:none;stroke:#777;stroke-width:1}"
    ".high{fill:none;stroke:#999;stroke-width:1;stroke-dasharray:5 4}"
    ".leaf{stroke:#222;stroke-width:3}.swing{fill:none;stroke:#777;stroke-width:1}"
    ".lintel{stroke:#999;stroke-width:1;stroke-dasharray:6 5}"
    ".pane{fill:#fff;stroke:#2b2b2b;stroke-width:1.2}"
    ".name{font-size:9px;fill:#555}.room{font-size:19px;letter-spacing:1px}.area{font-size:14px;fill:#555}"
    ".measure{stroke:#888;stroke-width:1}.small{font-size:12px;fill:#555}"
    ".halo{paint-order:stroke;stroke:#fbfaf7;stroke-width:3px}";

class PlanSheet {
 public:
  explicit PlanSheet(const Eigen::AlignedBox2d& area_m) : area_m_(area_m) {}
  Vec2d at(const Vec2d& p) const {
    return Vec2d(p.x() - area_m_.min().x(), area_m_.max().y() - p.y()) * 100 + Vec2d::Constant(kMargin_cm);
  }
  Vec2d size_cm() const { return area_m_.sizes() * 100 + Vec2d(2 * kMargin_cm, 2 * kMargin_cm + 40); }
  std::string points(const Polygon& polygon) const {
    std::string text;
    for (const Vec2d& corner : polygon) text += fmt::format("{:.1f},{:.1f} ", at(corner).x(), at(corner).y());
    if (!text.empty()) text.pop_back();
    return text;
  }

 private:
  Eigen::AlignedBox2d area_m_;
};

Eigen::AlignedBox2d area_of(const HomePlan& plan) {
  Eigen::AlignedBox2d area;
  for (const MappedRoom& room : plan.rooms) {
    for (const Vec2d& corner : room.polygon) area.extend(corner);
  }
  if (!area.isEmpty()) return area;
  for (const ThingFootprint& print : plan.furniture) {
    for (const Vec2d& corner : print.polygon) area.extend(corner);
  }
  return area.isEmpty() ? Eigen::AlignedBox2d(Vec2d::Zero(), Vec2d::Ones()) : area;
}

std::string line_svg(const PlanSheet& sheet, const Vec2d& a, const Vec2d& b, const char* style) {
  const Vec2d p = sheet.at(a);
  const Vec2d q = sheet.at(b);
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>\n", p.x(), p.y(), q.x(), q.y(),
                     style);
}

// Walls are the rooms' edges drawn thick; between two rooms the two edges meet and fill the wall.
std::string walls_svg(const PlanSheet& sheet, const HomePlan& plan) {
  std::string text;
  for (const MappedRoom& room : plan.rooms) {
    text += fmt::format("<polygon points=\"{}\" class=\"wall\" stroke-width=\"{}\"/>\n", sheet.points(room.polygon),
                        2 * kOuterWall_cm);
  }
  for (const MappedRoom& room : plan.rooms) {
    const bool is_wet = room.class_name == "bathroom" || room.class_name == "kitchen";
    text += fmt::format("<polygon points=\"{}\" class=\"{}\"/>\n", sheet.points(room.polygon), is_wet ? "wet" : "floor");
  }
  return text;
}

// The leaf and the quarter of a circle in which it swings.
std::string swing_svg(const PlanSheet& sheet, const Vec2d& hinge, const Vec2d& tip, const Vec2d& shut) {
  const Vec2d a = sheet.at(tip);
  const Vec2d b = sheet.at(shut);
  const double radius_cm = (shut - hinge).norm() * 100;
  const bool sweep = cross(tip - hinge, shut - hinge) < 0;
  return line_svg(sheet, hinge, tip, "leaf") +
         fmt::format("<path d=\"M{:.1f} {:.1f}A{:.1f} {:.1f} 0 0 {} {:.1f} {:.1f}\" class=\"swing\"/>\n", a.x(), a.y(), radius_cm,
                     radius_cm, sweep ? 1 : 0, b.x(), b.y());
}

// Into the one room that a closed door belongs to, or to the left.
Vec2d into_room(const HomePlan& plan, const Opening& door) {
  const Vec2d across = quarter_turn(door.along.head<2>());
  const Vec2d beside = door.center.head<2>() + across * 0.4;
  const bool is_inside =
      std::any_of(plan.rooms.begin(), plan.rooms.end(), [&](const MappedRoom& r) { return contains(r.polygon, beside); });
  return is_inside ? across : Vec2d(-across);
}

std::string door_svg(const PlanSheet& sheet, const HomePlan& plan, const Opening& door) {
  const Vec2d center = door.center.head<2>();
  const Vec2d along = door.along.head<2>();
  const Vec2d across = quarter_turn(along);
  const double wall_m = std::max(door.wall_m, kOuterWall_cm / 100) + 0.01;
  const Vec2d left = center - along * door.width_m / 2;
  const Vec2d right = center + along * door.width_m / 2;
  const double outward_m = door.wall_m > 0 ? wall_m / 2 : wall_m;
  const Polygon gap = {left - across * outward_m, right - across * outward_m, right + across * outward_m,
                       left + across * outward_m};
  std::string text = fmt::format("<polygon points=\"{}\" class=\"gap\"/>\n", sheet.points(gap));
  if (door.leaf == PanopticId::kUnknown || door.leaf_line.size() != 2) {
    text += line_svg(sheet, left - across * wall_m / 2, right - across * wall_m / 2, "lintel");
    return text + line_svg(sheet, left + across * wall_m / 2, right + across * wall_m / 2, "lintel");
  }
  if (!door.is_open) {
    const Vec2d inward = into_room(plan, door);
    return text + line_svg(sheet, left, right, "lintel") + swing_svg(sheet, left, left + inward * door.width_m, right);
  }
  // The leaf hangs at the jamb that is nearest to one of its ends, and is drawn as it stands.
  const Vec2d a = door.leaf_line[0];
  const Vec2d b = door.leaf_line[1];
  const Vec2d middle = (a + b) / 2;
  const bool at_left = (middle - left).norm() < (middle - right).norm();
  const Vec2d& jamb = at_left ? left : right;
  const Vec2d tip = (a - jamb).norm() > (b - jamb).norm() ? a : b;
  const Vec2d face = across * (across.dot(middle - center) > 0 ? wall_m / 2 : -wall_m / 2);
  const Vec2d hinge = jamb + face;
  return text + swing_svg(sheet, hinge, hinge + (tip - hinge).normalized() * door.width_m, (at_left ? right : left) + face);
}

// A window is drawn through the wall where its footprint lies.
std::string window_svg(const PlanSheet& sheet, const ThingFootprint& print) {
  const FlatBox box = smallest_box(convex_hull(print.polygon));
  const Vec2d across = quarter_turn(box.axis) * kOuterWall_cm / 200;
  const Vec2d half = box.axis * box.size_m.x() / 2;
  const Polygon pane = {box.center - half - across, box.center + half - across, box.center + half + across,
                        box.center - half + across};
  return fmt::format("<polygon points=\"{}\" class=\"pane\"/>\n", sheet.points(pane)) +
         line_svg(sheet, box.center - half, box.center + half, "measure");
}

std::string text_svg(const Vec2d& at, const char* style, const std::string& text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"{}\">{}</text>\n", at.x(), at.y(), style, text);
}

// Whether a label of this size at that place would lie on furniture.
double crowding(const PlanSheet& sheet, const HomePlan& plan, const Vec2d& center_cm, const Vec2d& half_cm) {
  double hits = 0;
  for (const double dx : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    for (const double dy : {-1.0, 0.0, 1.0}) {
      const Vec2d probe_cm = center_cm + Vec2d(dx * half_cm.x(), dy * half_cm.y());
      for (const ThingFootprint& print : plan.furniture) {
        Polygon on_sheet;
        for (const Vec2d& corner : print.polygon) on_sheet.push_back(sheet.at(corner));
        if (contains(on_sheet, probe_cm)) hits += 1;
      }
    }
  }
  return hits;
}

// Where the room's name covers the least furniture, near the middle if it can.
Vec2d place_for_name(const PlanSheet& sheet, const HomePlan& plan, const MappedRoom& room) {
  constexpr double kStep_m = 0.2;
  const Vec2d half_cm(60, 20);
  Eigen::AlignedBox2d area;
  for (const Vec2d& corner : room.polygon) area.extend(corner);
  Vec2d best = sheet.at(centroid(room.polygon));
  double least = 1e9;
  for (double y = area.min().y() + 0.3; y < area.max().y() - 0.3; y += kStep_m) {
    for (double x = area.min().x() + 0.7; x < area.max().x() - 0.7; x += kStep_m) {
      if (!contains(room.polygon, {x, y})) continue;
      const double away_m = (Vec2d(x, y) - centroid(room.polygon)).norm();
      const double cost = crowding(sheet, plan, sheet.at({x, y}), half_cm) + 0.3 * away_m;
      if (cost < least) least = cost, best = sheet.at({x, y});
    }
  }
  return best;
}

std::string upper_case(std::string text) {
  for (char& c : text) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  return text;
}

std::string names_svg(const PlanSheet& sheet, const HomePlan& plan) {
  std::string text;
  for (const MappedRoom& room : plan.rooms) {
    const Vec2d at = place_for_name(sheet, plan, room);
    text += text_svg(at, "room halo", upper_case(room.class_name));
    text += text_svg(at + Vec2d(0, 18), "area halo", fmt::format("{:.1f} m²", room.area_m2));
  }
  return text;
}

// Outer measures with ticks, and a scale of two metres.
std::string measures_svg(const PlanSheet& sheet, const Eigen::AlignedBox2d& area) {
  const Vec2d low = sheet.at({area.min().x(), area.max().y()});
  const Vec2d high = sheet.at({area.max().x(), area.min().y()});
  const Vec2d size_m = area.sizes();
  const double y = low.y() - 45;
  const double x = low.x() - 45;
  std::string text =
      fmt::format("<path d=\"M{0:.1f} {2:.1f}H{1:.1f}M{0:.1f} {3:.1f}v12M{1:.1f} {3:.1f}v12\" class=\"measure\"/>\n", low.x(),
                  high.x(), y, y - 6);
  text += fmt::format("<path d=\"M{2:.1f} {0:.1f}V{1:.1f}M{3:.1f} {0:.1f}h12M{3:.1f} {1:.1f}h12\" class=\"measure\"/>\n", low.y(),
                      high.y(), x, x - 6);
  text += text_svg({(low.x() + high.x()) / 2, y - 8}, "small", fmt::format("{:.2f} m", size_m.x()));
  const double middle_y = (low.y() + high.y()) / 2;
  text += fmt::format(
      "<text x=\"{0:.1f}\" y=\"{1:.1f}\" class=\"small\" transform=\"rotate(-90 {0:.1f} {1:.1f})\">{2:.2f} m</text>\n", x - 8,
      middle_y, size_m.y());
  const double scale_y = high.y() + 60;
  text += fmt::format(
      "<path d=\"M{0:.1f} {1:.1f}h100v6h-100z\" fill=\"#2b2b2b\"/><path d=\"M{2:.1f} {1:.1f}h100v6h-100z\" fill=\"#fff\" "
      "stroke=\"#2b2b2b\"/>\n",
      low.x(), scale_y, low.x() + 100);
  for (int metres = 0; metres <= 2; ++metres)
    text += text_svg({low.x() + 100.0 * metres, scale_y + 20}, "small", fmt::format("{}{}", metres, metres == 2 ? " m" : ""));
  return text;
}

// The turn that makes most walls run along the sheet; four times its angle is the same for all walls of a house.
Eigen::Matrix2d upright_turn(const std::vector<WallLine>& walls) {
  std::complex<double> sum = 0;
  for (const WallLine& wall : walls) {
    const Vec2d along = wall.to - wall.from;
    sum += along.norm() * std::polar(1.0, 4 * std::atan2(along.y(), along.x()));
  }
  const double angle = std::abs(sum) > 0 ? -std::arg(sum) / 4 : 0;
  return Eigen::Rotation2Dd(angle).toRotationMatrix();
}

// The plan with everything that is drawn turned about the vertical.
HomePlan turned_plan(HomePlan plan, const Eigen::Matrix2d& turn) {
  const auto flat = [&](Vec2d& v) { v = turn * v; };
  const auto upright = [&](Vec3d& v) { v.head<2>() = turn * Vec2d(v.head<2>()); };
  for (MappedRoom& room : plan.rooms) std::for_each(room.polygon.begin(), room.polygon.end(), flat);
  for (ThingFootprint& print : plan.furniture) std::for_each(print.polygon.begin(), print.polygon.end(), flat);
  for (Seat& seat : plan.seats) upright(seat.facing);
  for (LyingPlace& place : plan.lying_places) upright(place.axis);
  for (Opening& door : plan.doors) {
    upright(door.center);
    upright(door.along);
    std::for_each(door.leaf_line.begin(), door.leaf_line.end(), flat);
  }
  return plan;
}

}  // namespace

std::string floor_plan_svg(const HomePlan& as_it_lies, const LabelSet& labels) {
  const HomePlan plan = turned_plan(as_it_lies, upright_turn(as_it_lies.walls));
  const Eigen::AlignedBox2d area = area_of(plan);
  const PlanSheet sheet(area);
  const Vec2d size = sheet.size_cm();
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\">\n<style>{2}</style>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      size.x(), size.y(), kStyle);
  text += walls_svg(sheet, plan);
  for (const ThingFootprint& print : plan.furniture) {
    if (labels.name_of(print.class_id) == "window") text += window_svg(sheet, print);
  }
  for (const Opening& door : plan.doors) text += door_svg(sheet, plan, door);
  const auto to_sheet = [&](const Vec2d& p) { return sheet.at(p); };
  text += furniture_svg(plan, labels, to_sheet);
  text += names_svg(sheet, plan);
  return text + measures_svg(sheet, area) + "</svg>\n";
}

}  // namespace panoptic
