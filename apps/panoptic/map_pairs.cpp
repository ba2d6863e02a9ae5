// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// merge and diff: what can be done with two map files.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "apps/panoptic/commands.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "panoptic/io/draw_text.h"
#include "panoptic/io/views.h"
#include "panoptic/map_pairs.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mesh.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

Json to_json(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }

Json to_json(const std::optional<FoundObject>& o, const LabelSet& labels) {
  if (!o) return nullptr;
  return {{"id", number(o->id)},
          {"class", labels.name_of(o->class_id)},
          {"center_m", to_json(o->box.center_m)},
          {"box", {{"min_m", to_json(o->box.min_m)}, {"max_m", to_json(o->box.max_m)}}},
          {"voxels", o->voxels}};
}

Json to_json(const std::optional<MapAlignment>& alignment) {
  if (!alignment) return nullptr;
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < 4; ++row) {
    const Eigen::Vector4d r = alignment->a_from_b.matrix().row(row);
    rows.push_back(Json::array({r[0], r[1], r[2], r[3]}));
  }
  return {{"a_from_b", rows},
          {"agreement", alignment->agreement},
          {"common_m2", alignment->common_m2},
          {"objects", alignment->objects}};
}

Json to_json(const MapDiff& diff, const std::optional<MapAlignment>& alignment, const Arguments& a, const LabelSet& labels) {
  Json json = {{"a", a.map}, {"b", a.other_map}, {"unchanged", diff.unchanged}, {"too_small", diff.too_small}};
  json["alignment"] = to_json(alignment);
  json["surfaces"] = {{"common", diff.shift.common}, {"apart_median_m", nullptr}, {"apart_p95_m", nullptr}};
  if (diff.shift.common > 0) {
    json["surfaces"]["apart_median_m"] = diff.shift.median_m;
    json["surfaces"]["apart_p95_m"] = diff.shift.p95_m;
  }
  json["changes"] = Json::array();
  for (const ObjectChange& c : diff.changes) {
    json["changes"].push_back({{"kind", name_of(c.kind)},
                               {"before", to_json(c.before, labels)},
                               {"after", to_json(c.after, labels)},
                               {"empty_share", c.empty_share},
                               {"moved_m", c.moved_m}});
  }
  return json;
}

const char* words_of(ChangeKind kind) {
  switch (kind) {
    case ChangeKind::kVanished:
      return "vanished";
    case ChangeKind::kAppeared:
      return "appeared";
    case ChangeKind::kMoved:
      return "moved";
    case ChangeKind::kOtherLabel:
      return "other label";
    case ChangeKind::kNotSeenInB:
      return "not seen in B";
    default:
      return "not seen in A";
  }
}

std::string place_text(const Vec3d& p) { return fmt::format("{:7.2f} {:7.2f} {:7.2f}", p.x(), p.y(), p.z()); }

std::string line_of(const ObjectChange& c, const LabelSet& labels) {
  const FoundObject& object = c.before ? *c.before : *c.after;
  const Vec3d size = object.box.max_m - object.box.min_m;
  std::string line =
      fmt::format("{:<14} {:<16} {:>6} at {}  size {:5.2f} {:5.2f} {:5.2f} m", words_of(c.kind), labels.name_of(object.class_id),
                  number(object.id), place_text(object.box.center_m), size.x(), size.y(), size.z());
  if (c.kind == ChangeKind::kMoved) {
    line += fmt::format("  to {} ({:.2f} m), {} there", place_text(c.after->box.center_m), c.moved_m, number(c.after->id));
  } else if (c.before && c.after) {
    line += fmt::format("  {} {} now", labels.name_of(c.after->class_id), number(c.after->id));
  } else if (c.kind == ChangeKind::kVanished || c.kind == ChangeKind::kAppeared) {
    line += fmt::format("  {:.0f} % of its place seen empty in {}", 100 * c.empty_share, c.before ? "B" : "A");
  } else if (c.kind == ChangeKind::kOtherLabel) {
    line += fmt::format("  its surface is in {} too", c.before ? "B" : "A");
  }
  return line;
}

std::string diff_text(const MapDiff& diff, const LabelSet& labels) {
  std::string text = fmt::format("{} objects are where they were, {} changes\n", diff.unchanged, diff.changes.size());
  for (const ObjectChange& c : diff.changes) text += line_of(c, labels) + "\n";
  if (diff.shift.common > 0) {
    text += fmt::format("{:.0f} % of B's surface is in A, too; there they lie {:.1f} cm apart (median; 95 %: {:.1f} cm)\n",
                        100 * diff.shift.common, 100 * diff.shift.median_m, 100 * diff.shift.p95_m);
  } else {
    text += "nothing of B's surface is in A\n";
  }
  if (diff.too_small > 0) text += fmt::format("{} objects are too small to compare\n", diff.too_small);
  return text;
}

std::string alignment_text(const MapAlignment& alignment) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  return fmt::format("aligned   turned by {:.1f} degrees and moved by {:.2f} m; {:.0f} % of {:.1f} m2 and {} objects agree\n",
                     kDegrees * Eigen::AngleAxisd(alignment.a_from_b.linear()).angle(), alignment.a_from_b.translation().norm(),
                     100 * alignment.agreement, alignment.common_m2 / alignment.agreement, alignment.objects);
}

Rgb marker_color(ChangeKind kind) {
  switch (kind) {
    case ChangeKind::kVanished:
      return {214, 39, 40};
    case ChangeKind::kAppeared:
      return {44, 160, 44};
    case ChangeKind::kMoved:
      return {31, 119, 180};
    default:
      return {150, 150, 150};
  }
}

// A ring of 3 px around the place, and the class beside it.
void draw_marker(Image<Rgb>& image, const View& view, const FoundObject& object, const Rgb& color, const LabelSet& labels) {
  const Vec3d p = view.world_from_camera.inverse() * object.box.center_m;
  if (!(p.z() > 0)) return;
  const double u = view.camera.fx * p.x() / p.z() + view.camera.cx;
  const double v = view.camera.fy * p.y() / p.z() + view.camera.cy;
  constexpr double kLeast_px = 10;
  const double radius_px = std::max(kLeast_px, view.camera.fx * (object.box.max_m - object.box.min_m).norm() / 2 / p.z());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (std::abs(std::hypot(x - u, y - v) - radius_px) < 1.5) image(x, y) = color;
    }
  }
  draw_text(image, std::string(labels.name_of(object.class_id)), static_cast<int>(u + radius_px + 4), static_cast<int>(v), color,
            0.5);
}

// Both maps from above, A on the left, with rings around what changed in each.
void write_picture(const std::string& path, const MapDiff& diff, const MapWithFrames& a, const MapWithFrames& b) {
  const Mesh before = mesh_of(a.saved);
  const Mesh after = mesh_of(b.saved);
  const View view = default_views(before.vertices.empty() ? after : before, up_of(a.saved)).back();
  const LabelSet& labels = a.saved.map.labels;
  Image<Rgb> left = render(before, view, ColorMode::kColor, labels);
  Image<Rgb> right = render(after, view, ColorMode::kColor, labels);
  for (const ObjectChange& c : diff.changes) {
    if (c.before) draw_marker(left, view, *c.before, marker_color(c.kind), labels);
    if (c.after) draw_marker(right, view, *c.after, marker_color(c.kind), labels);
  }
  Image<Rgb> both(left.width() + right.width(), left.height());
  for (int v = 0; v < left.height(); ++v) {
    for (int u = 0; u < left.width(); ++u) {
      both(u, v) = left(u, v);
      both(left.width() + u, v) = right(u, v);
    }
  }
  write_png(path, both);
}

}  // namespace

int map_merge(const Arguments& a) {
  set_thread_count(a.threads);
  const MergedFiles m = merge_map_files(a.map, a.other_map, a.output, a.align);
  for (const std::string& note : m.notes) tell_note(note);
  if (m.alignment) fmt::print("{}", alignment_text(*m.alignment));
  fmt::print("{}: {} objects ({} and {}; {} are the same, {} parts of another), {} blocks\n", a.output, m.objects, m.objects_a,
             m.objects_b, m.same, m.parts, m.blocks);
  return kDone;
}

int map_diff(const Arguments& a) {
  set_thread_count(a.threads);
  const MapWithFrames before = load_map_with_frames(a.map);
  MapWithFrames after = load_map_with_frames(a.other_map);
  tell_note(note_of_format(before.saved, a.map));
  tell_note(note_of_format(after.saved, a.other_map));
  std::optional<MapAlignment> alignment;
  if (a.align) {
    alignment = align_maps(before, after, a.map, a.other_map);
    after = moved_map(after, alignment->a_from_b);
    fmt::print("{}", alignment_text(*alignment));
  }
  const MapDiff diff = diff_maps(before, after, a.map, a.other_map);
  for (const std::string& note : diff.notes) tell_note(note);
  const LabelSet& labels = before.saved.map.labels;
  if (!a.json.empty()) write_json_file(a.json, to_json(diff, alignment, a, labels));
  if (!a.png.empty()) write_picture(a.png, diff, before, after);
  fmt::print("{}", diff_text(diff, labels));
  return kDone;
}

}  // namespace panoptic
