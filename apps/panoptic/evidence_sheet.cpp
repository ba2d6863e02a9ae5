// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/evidence_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "panoptic/error.h"
#include "panoptic/io/draw_text.h"
#include "panoptic/io/views.h"
#include "panoptic/sim/open_again.h"
#include "panoptic/simulation.h"

namespace panoptic {
namespace {

constexpr int kWidth_px = 1280;
constexpr int kHeight_px = 960;
constexpr int kMargin_px = 16;
constexpr int kTitleRows_px = 48;
constexpr int kTileWidth_px = 405;
constexpr int kTileHeight_px = 304;
constexpr int kTextTop_px = kTitleRows_px + kTileHeight_px + 48;
constexpr int kRenderTop_px = 520;
constexpr int kRenderWidth_px = 616;
constexpr int kRenderHeight_px = kHeight_px - kRenderTop_px - kMargin_px;
constexpr int kLineRows_px = 20;
constexpr double kTitleScale = 0.8;
constexpr double kTextScale = 0.45;
constexpr Rgb kPaper{250, 250, 250};
constexpr Rgb kInk{30, 30, 34};
constexpr Rgb kHighlight{235, 95, 10};
constexpr std::array kClassColors = {Rgb{235, 95, 10}, Rgb{30, 100, 200}, Rgb{40, 150, 70}, Rgb{150, 60, 170}};
constexpr Rgb kOther{190, 190, 190};

std::unique_ptr<Dataset> open_again(const RunReport& report, const std::filesystem::path& run) {
  if (report.recording.empty()) {
    throw Error(fmt::format("{}: the run did not write down its recording; map it again", run.string()));
  }
  constexpr const char* kOtherwise = "explain without --png needs no recording";
  std::unique_ptr<Dataset> dataset;
  try {
    dataset = panoptic::open_again(report.recording, report.calibration, report.pair_tolerance_s, report.tracked);
  } catch (const Error& e) {
    throw Error(fmt::format("the run's recording cannot be opened any more ({}); put it back, {}", e.what(), kOtherwise));
  }
  if (dataset->description() != report.dataset) {
    throw Error(fmt::format("{}: is another recording by now ({}; it was: {}); put the old one back, {}", report.recording,
                            dataset->description(), report.dataset, kOtherwise));
  }
  return dataset;
}

std::int64_t index_of(const ReadResult& read) { return read.frame ? read.frame->index : read.skipped.index; }

// Frames are in ascending order of their numbers.
ReadResult find_frame(const Dataset& dataset, std::int64_t index) {
  std::size_t low = 0;
  std::size_t high = dataset.size();
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    ReadResult read = dataset.read(middle);
    if (index_of(read) == index) return read;
    (index_of(read) < index ? low = middle + 1 : high = middle);
  }
  return {std::nullopt, {index, "is not in the recording"}};
}

struct Rect {
  double u0, v0, width, height;
};

// Around the box, half as large again, in the shape of a tile; it may reach beyond the image.
Rect around(const PixelBox& box) {
  constexpr double kLeast_px = 48;
  constexpr double kContext = 1.5;
  constexpr double kShape = static_cast<double>(kTileWidth_px) / kTileHeight_px;
  const double height = std::max({kContext * (box.v1 - box.v0), kContext * (box.u1 - box.u0) / kShape, kLeast_px});
  return {(box.u0 + box.u1) / 2.0 - height * kShape / 2, (box.v0 + box.v1) / 2.0 - height / 2, height * kShape, height};
}

// The mean of the four pixels around (u, v), weighted by nearness; paper outside of the image.
Rgb sample(const ImageView<Rgb>& image, double u, double v) {
  if (u < -0.5 || v < -0.5 || u > image.width() - 0.5 || v > image.height() - 0.5) return kPaper;
  const int u0 = std::clamp(static_cast<int>(std::floor(u)), 0, std::max(0, image.width() - 2));
  const int v0 = std::clamp(static_cast<int>(std::floor(v)), 0, std::max(0, image.height() - 2));
  const int u1 = std::min(u0 + 1, image.width() - 1);
  const int v1 = std::min(v0 + 1, image.height() - 1);
  const double a = std::clamp(u - u0, 0.0, 1.0);
  const double b = std::clamp(v - v0, 0.0, 1.0);
  const auto mix = [&](std::uint8_t Rgb::*channel) {
    const double top = image(u0, v0).*channel * (1 - a) + image(u1, v0).*channel * a;
    const double bottom = image(u0, v1).*channel * (1 - a) + image(u1, v1).*channel * a;
    return static_cast<std::uint8_t>(std::lround(top * (1 - b) + bottom * b));
  };
  return {mix(&Rgb::r), mix(&Rgb::g), mix(&Rgb::b)};
}

void draw_box(const PixelBox& box, const Rect& from, int left, int top, Image<Rgb>& sheet) {
  constexpr int kThick_px = 2;
  const double scale = kTileWidth_px / from.width;
  const auto column = [&](int u) { return left + static_cast<int>(std::lround((u - from.u0) * scale)); };
  const auto row = [&](int v) { return top + static_cast<int>(std::lround((v - from.v0) * scale)); };
  const PixelBox in = {column(box.u0), row(box.v0), column(box.u1), row(box.v1)};
  fill(sheet, {in.u0 - kThick_px, in.v0 - kThick_px, in.u1 + kThick_px, in.v0}, kHighlight);
  fill(sheet, {in.u0 - kThick_px, in.v1, in.u1 + kThick_px, in.v1 + kThick_px}, kHighlight);
  fill(sheet, {in.u0 - kThick_px, in.v0, in.u0, in.v1}, kHighlight);
  fill(sheet, {in.u1, in.v0, in.u1 + kThick_px, in.v1}, kHighlight);
}

void draw_view(const ReadResult& read, const RunObject::View& view, int left, Image<Rgb>& sheet) {
  const int caption = kTitleRows_px + kTileHeight_px + kLineRows_px;
  draw_text(sheet, fmt::format("frame {}: {} {:.2f}, {} px", view.frame, view.class_name, view.score, view.visible_px), left,
            caption, kInk, kTextScale);
  if (!read.frame) {
    draw_text(sheet, fmt::format("frame {} {}", view.frame, read.skipped.reason), left, kTitleRows_px + kLineRows_px, kHighlight,
              kTextScale);
    return;
  }
  const Rect from = around(view.box);
  for (int v = 0; v < kTileHeight_px; ++v) {
    for (int u = 0; u < kTileWidth_px; ++u) {
      const double scale = from.width / kTileWidth_px;
      sheet(left + u, kTitleRows_px + v) =
          sample(read.frame->color, from.u0 + (u + 0.5) * scale - 0.5, from.v0 + (v + 0.5) * scale - 0.5);
    }
  }
  draw_box(view.box, from, left, kTitleRows_px, sheet);
}

// Draws the text that to_text has before the votes, cut to half the width.
void draw_words(const Evidence& evidence, Image<Rgb>& sheet) {
  std::string text = to_text(evidence);
  text.resize(std::min(text.size(), text.find("  votes")));
  int v = kTextTop_px;
  for (std::size_t begin = 0; begin < text.size() && v + kLineRows_px < kRenderTop_px; v += kLineRows_px) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    while (text_size(line, kTextScale).width_px > kRenderWidth_px) line.pop_back();
    draw_text(sheet, line, kMargin_px, v, kInk, kTextScale);
    begin = end + 1;
  }
}

// The classes with the most votes, the most frequent first.
std::vector<std::string> main_classes(const std::vector<RunObject::Votes>& bins) {
  std::map<std::string, std::uint64_t> sums;
  for (const RunObject::Votes& bin : bins) {
    for (const auto& [name, votes] : bin.of_class) sums[name] += votes;
  }
  std::vector<std::pair<std::string, std::uint64_t>> ordered(sums.begin(), sums.end());
  std::stable_sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(ordered.size(), kClassColors.size()); ++i) names.push_back(ordered[i].first);
  return names;
}

// A bar for each stretch of time that has votes: how they divide between classes; what is left over is grey.
void draw_votes(const std::vector<RunObject::Votes>& bins, Image<Rgb>& sheet) {
  constexpr int kBar_px = 34;
  constexpr int kBarTop_px = kTextTop_px + 8;
  constexpr int kBarBottom_px = kRenderTop_px - 10;
  const std::vector<std::string> classes = main_classes(bins);
  int left = 2 * kMargin_px + kRenderWidth_px;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    draw_text(sheet, classes[i], left, kTextTop_px, kClassColors[i], kTextScale);
    left += text_size(classes[i] + "  ", kTextScale).width_px;
  }
  left = 2 * kMargin_px + kRenderWidth_px;
  for (const RunObject::Votes& bin : bins) {
    double total = 0;
    for (const auto& [name, votes] : bin.of_class) total += static_cast<double>(votes);
    double below = 0;
    int bottom = kBarBottom_px;
    for (std::size_t i = 0; i <= classes.size(); ++i) {
      const bool rest = i == classes.size();
      for (const auto& [name, votes] : bin.of_class) below += !rest && name == classes[i] ? static_cast<double>(votes) : 0;
      const double share = rest || total <= 0 ? 1 : below / total;
      const int top = kBarBottom_px - static_cast<int>(std::lround(share * (kBarBottom_px - kBarTop_px)));
      fill(sheet, {left, top, left + kBar_px, bottom}, rest ? kOther : kClassColors[i]);
      bottom = top;
    }
    left += kBar_px + 2;
    if (left + kBar_px > sheet.width()) break;
  }
}

Rgb tinted(const Rgb& c) {
  const auto mix = [](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>((a + b) / 2); };
  return {mix(c.r, kHighlight.r), mix(c.g, kHighlight.g), mix(c.b, kHighlight.b)};
}

// The object tinted, everything else pale and grey.
Mesh with_one_object_in_color(Mesh mesh, PanopticId id) {
  for (MeshVertex& vertex : mesh.vertices) {
    if (vertex.panoptic_id == id) {
      vertex.color = tinted(vertex.color);
      continue;
    }
    const int luma = (54 * vertex.color.r + 183 * vertex.color.g + 19 * vertex.color.b) >> 8;
    vertex.color.r = vertex.color.g = vertex.color.b = static_cast<std::uint8_t>(170 + luma / 4);
  }
  return mesh;
}

Mesh object_alone(const Mesh& mesh, PanopticId id) {
  Mesh object;
  object.vertices = mesh.vertices;
  for (const auto& t : mesh.triangles) {
    const auto is_of_it = [&](std::uint32_t vertex) { return mesh.vertices[vertex].panoptic_id == id; };
    if (is_of_it(t[0]) && is_of_it(t[1]) && is_of_it(t[2])) object.triangles.push_back(t);
  }
  return object;
}

// The view of the object, from farther away, so that what is around it is seen, too.
View from_farther(View view, const Vec3d& center, int width, int height) {
  constexpr double kFarther = 1.8;
  constexpr double kLeastWidth_m = 1.5;
  const double nearest = kLeastWidth_m * view.camera.fx / view.camera.width;
  Vec3d from_center = view.world_from_camera.translation() - center;
  const double distance = std::max(from_center.norm(), 1e-6);
  from_center *= std::max(kFarther * distance, nearest) / distance;
  view.world_from_camera.translation() = center + from_center;
  const double focal = view.camera.fx * width / view.camera.width;
  view.camera = {width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0};
  return view;
}

void draw_renders(const Mesh& mesh, const RunObject& object, const Vec3d& up, Image<Rgb>& sheet) {
  const Mesh shown = with_one_object_in_color(mesh, object.id);
  const std::vector<View> views = default_views(object_alone(mesh, object.id), up);
  const Vec3d center = (object.min_m + object.max_m) / 2;
  int left = kMargin_px;
  for (const View& view : {views.front(), views.back()}) {
    const Image<Rgb> picture =
        render(shown, from_farther(view, center, kRenderWidth_px, kRenderHeight_px), ColorMode::kColor, LabelSet());
    for (int v = 0; v < picture.height(); ++v) std::copy_n(picture.row(v), picture.width(), sheet.row(kRenderTop_px + v) + left);
    left += kRenderWidth_px + kMargin_px;
  }
}

}  // namespace

Image<Rgb> draw_evidence(const std::filesystem::path& run, const Evidence& evidence) {
  const RunObject& object = evidence.object;
  const RunReport report = read_run_report(run);
  const std::unique_ptr<Dataset> dataset = open_again(report, run);
  const Mesh mesh = read_run_mesh(run);
  Image<Rgb> sheet(kWidth_px, kHeight_px, kPaper);
  draw_text(sheet, fmt::format("{} {}", object.class_name, number(object.id)), kMargin_px, kTitleRows_px - kMargin_px, kInk,
            kTitleScale);
  int left = kMargin_px;
  for (const RunObject::View& view : object.best_views) {
    if (left + kTileWidth_px > kWidth_px) break;
    draw_view(find_frame(*dataset, view.frame), view, left, sheet);
    left += kTileWidth_px + kMargin_px;
  }
  draw_words(evidence, sheet);
  draw_votes(object.votes, sheet);
  draw_renders(mesh, object, report.up, sheet);
  return sheet;
}

}  // namespace panoptic
