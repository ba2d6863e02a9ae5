// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/segmentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "panoptic/base/config.h"

namespace panoptic {
namespace {

constexpr std::size_t kMaxInstances = 64000;  // segment_at is 16 bits wide, and up to 999 stuff classes follow

// Paints the mask over pixels that no instance has yet; returns whether it got any.
bool paint(const Instance& instance, std::uint16_t value, Image<std::uint16_t>& segment_at) {
  const std::int64_t begin = std::max<std::int64_t>(0, -std::int64_t{instance.x0});
  const std::int64_t end = std::min<std::int64_t>(instance.mask.width(), std::int64_t{segment_at.width()} - instance.x0);
  bool any = false;
  for (int y = 0; y < instance.mask.height(); ++y) {
    const std::int64_t v = std::int64_t{instance.y0} + y;
    if (v < 0 || v >= segment_at.height() || begin >= end) continue;
    const std::uint8_t* mask = instance.mask.row(y) + begin;
    std::uint16_t* pixels = segment_at.row(static_cast<int>(v)) + (instance.x0 + begin);
    for (std::int64_t x = 0; x < end - begin; ++x) {
      const bool gets_it = mask[x] != 0 && pixels[x] == 0;
      pixels[x] = gets_it ? value : pixels[x];
      any |= gets_it;
    }
  }
  return any;
}

// Which instance is painted first, that is, in front of the others.
std::vector<std::size_t> front_to_back(const std::vector<Instance>& instances, bool smaller_in_front) {
  std::vector<std::size_t> order;
  std::vector<std::int64_t> area(instances.size(), 0);
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (std::isnan(instances[i].segment.score)) continue;
    order.push_back(i);
    const auto pixels = instances[i].mask.pixels();
    if (smaller_in_front) area[i] = static_cast<std::int64_t>(pixels.size()) - std::count(pixels.begin(), pixels.end(), 0);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return area[a] != area[b] ? area[a] < area[b] : instances[a].segment.score > instances[b].segment.score;
  });
  return order;
}

// By the number of a class: whether the pixels of that class that no instance has become a segment.
std::vector<bool> classes_to_fill_with(const LabelSet& labels, bool keep_whole_classes) {
  std::vector<bool> wanted(labels.first_thing(), false);
  for (const LabelClass& c : labels.classes()) wanted[number(c.id)] = !c.is_thing || keep_whole_classes;
  return wanted;
}

}  // namespace

Segmentation fuse(const Image<ClassId>& semantic, const std::vector<Instance>& instances, const LabelSet& labels,
                  const SegmentationOptions& options) {
  Segmentation result{Image<std::uint16_t>(semantic.width(), semantic.height()), {}};
  for (const std::size_t i : front_to_back(instances, options.smaller_in_front)) {
    if (result.segments.size() >= kMaxInstances) break;
    if (!labels.is_thing(instances[i].segment.class_id)) continue;
    if (paint(instances[i], static_cast<std::uint16_t>(result.segments.size() + 1), result.segment_at)) {
      result.segments.push_back(instances[i].segment);
    }
  }
  const std::vector<bool> wanted = classes_to_fill_with(labels, options.keep_whole_classes);
  std::vector<std::uint16_t> segment_of_class(wanted.size(), 0);
  for (std::size_t i = 0; i < semantic.size(); ++i) {
    const ClassId id = semantic[i];
    if (result.segment_at[i] != 0 || number(id) >= wanted.size() || !wanted[number(id)]) continue;
    std::uint16_t& segment = segment_of_class[number(id)];
    if (segment == 0) {
      result.segments.push_back({id, 1.0F, {}, labels.is_thing(id)});
      segment = static_cast<std::uint16_t>(result.segments.size());
    }
    result.segment_at[i] = segment;
  }
  return result;
}

Outcome check(const Segmentation& segmentation, int width, int height) {
  if (segmentation.segment_at.empty()) return {};
  if (!segmentation.segment_at.same_size(width, height)) return Outcome::refused("segmentation and colour image differ in size");
  std::uint16_t highest = 0;
  for (const std::uint16_t segment : segmentation.segment_at.pixels()) highest = std::max(highest, segment);
  if (highest > segmentation.segments.size()) return Outcome::refused("segmentation names a segment that does not exist");
  const auto sound = [](float value) { return std::isfinite(value) && value >= 0; };
  for (const Segment& segment : segmentation.segments) {
    const auto& probabilities = segment.class_probabilities;
    const bool all_sound = sound(segment.score) && std::all_of(probabilities.begin(), probabilities.end(),
                                                               [&](const ClassProbability& p) { return sound(p.probability); });
    if (!all_sound) return Outcome::refused("segmentation has a score or probability that is negative or not finite");
  }
  return {};
}

Outcome check_classes(const Segmentation& segmentation, const LabelSet& labels) {
  const auto refused = [&](ClassId id) {
    return Outcome::refused(
        fmt::format("segmentation has class {}, which the label set '{}' has not", number(id), labels.name()));
  };
  for (const Segment& segment : segmentation.segments) {
    if (segment.class_id != ClassId::kUnknown && labels.find(segment.class_id) == nullptr) return refused(segment.class_id);
    for (const ClassProbability& p : segment.class_probabilities) {
      if (labels.find(p.class_id) == nullptr) return refused(p.class_id);
    }
  }
  return {};
}

}  // namespace panoptic
