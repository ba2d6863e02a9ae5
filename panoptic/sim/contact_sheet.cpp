// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/contact_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "panoptic/io/draw_text.h"
#include "panoptic/labels.h"
#include "panoptic/sim/visible_things.h"

namespace panoptic {
namespace {

constexpr int kTileWidth = 320;
constexpr int kTileHeight = 240;
constexpr int kGap = 4;
constexpr int kCandidates = 16;  // frames looked at per home
constexpr Rgb kBackground{24, 24, 28};

bool is_mover(ClassId class_id) { return class_id == kPersonClass || class_id == kCatClass || class_id == kDogClass; }

// The candidate that shows the most things of some size; people above all.
SimulatedFrame best_frame(const Simulation& simulation) {
  constexpr int kLeast_px = 800;
  SimulatedFrame best;
  std::ptrdiff_t most = -1;
  for (std::size_t i = 0; i < kCandidates; ++i) {
    SimulatedFrame frame =
        simulation.simulate(std::min(simulation.size() - 1, (2 * i + 1) * simulation.size() / (2 * kCandidates)));
    const auto things = visible_things(frame.rendering, simulation.camera());
    const auto count =
        std::count_if(things.begin(), things.end(), [](const VisibleThing& thing) { return thing.area_px >= kLeast_px; });
    constexpr std::ptrdiff_t kWorthOfMover = 20;
    const auto movers = std::count_if(things.begin(), things.end(), [&](const VisibleThing& thing) {
      return thing.area_px >= kLeast_px && is_mover(thing.class_id);
    });
    const std::ptrdiff_t worth = count + kWorthOfMover * movers;
    if (worth <= most) continue;
    most = worth;
    best = std::move(frame);
  }
  return best;
}

Image<Rgb> depth_picture(const ImageView<float>& depth) {
  constexpr float kFar_m = 6;
  Image<Rgb> picture(depth.width(), depth.height());
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const float share = depth[i] > 0 ? 1 - std::min(depth[i] / kFar_m, 1.0F) : 0;
    const auto grey = static_cast<std::uint8_t>(255 * share);
    picture[i] = {grey, grey, grey};
  }
  return picture;
}

Image<Rgb> class_picture(const Image<ClassId>& class_id, const LabelSet& labels) {
  Image<Rgb> picture(class_id.width(), class_id.height());
  for (std::size_t i = 0; i < class_id.size(); ++i) {
    const LabelClass* found = labels.find(class_id[i]);
    if (found != nullptr) picture[i] = found->color;
  }
  return picture;
}

// Stuff in the colour of its class.
Image<Rgb> instance_picture(const Rendering& rendering, const LabelSet& labels) {
  Image<Rgb> picture = class_picture(rendering.class_id, labels);
  for (std::size_t i = 0; i < picture.size(); ++i) {
    if (rendering.instance[i] == 0) continue;
    picture[i] = color_of(static_cast<PanopticId>(labels.first_thing() + rendering.instance[i]), labels);
  }
  return picture;
}

// Shrunk to a tile (the nearest pixel of each) at column, row of the sheet.
void paste(const Image<Rgb>& picture, int column, int row, Image<Rgb>& sheet) {
  const int u0 = kGap + column * (kTileWidth + kGap);
  const int v0 = kGap + row * (kTileHeight + kGap);
  for (int v = 0; v < kTileHeight; ++v) {
    for (int u = 0; u < kTileWidth; ++u) {
      sheet(u0 + u, v0 + v) = picture(u * picture.width() / kTileWidth, v * picture.height() / kTileHeight);
    }
  }
}

}  // namespace

Image<Rgb> contact_sheet(const SimulationOptions& first, int homes) {
  constexpr double kTextScale = 0.45;
  constexpr int kColumns = 4;
  Image<Rgb> sheet(kGap + kColumns * (kTileWidth + kGap), kGap + homes * (kTileHeight + kGap), kBackground);
  for (int row = 0; row < homes; ++row) {
    SimulationOptions options = first;
    options.seed += static_cast<std::uint64_t>(row);
    const Simulation simulation(options);
    const SimulatedFrame shown = best_frame(simulation);
    const LabelSet& labels = simulation.labels();
    const std::array<Image<Rgb>, kColumns> pictures = {shown.frame.color.copied(), depth_picture(shown.frame.depth),
                                                       class_picture(shown.rendering.class_id, labels),
                                                       instance_picture(shown.rendering, labels)};
    for (int column = 0; column < kColumns; ++column) paste(pictures[static_cast<std::size_t>(column)], column, row, sheet);
    draw_text(sheet, fmt::format("sim:{}", options.seed), 2 * kGap, (row + 1) * (kTileHeight + kGap) - kGap, {255, 255, 255},
              kTextScale);
  }
  return sheet;
}

}  // namespace panoptic
