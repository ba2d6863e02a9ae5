// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/substitutes.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {
namespace {

// The true thing that most pixels of each segment show; 0 where most show none.
std::vector<std::uint16_t> majority_instances(const RegisteredFrame& registered, std::size_t segment_count,
                                              const Image<std::uint16_t>& true_instance) {
  std::vector<std::map<std::uint16_t, std::size_t>> counts(segment_count);
  for (std::size_t i = 0; i < registered.pixel_count(); ++i) {
    const std::uint16_t segment = registered.segment[i];
    if (segment != 0 && segment != RegisteredFrame::kNoSegment) ++counts[segment - 1U][true_instance[i]];
  }
  std::vector<std::uint16_t> result(segment_count, 0);
  for (std::size_t s = 0; s < segment_count; ++s) {
    const auto most = std::ranges::max_element(counts[s], {}, [](const auto& entry) { return entry.second; });
    if (most != counts[s].end()) result[s] = most->first;
  }
  return result;
}

}  // namespace

SubstituteMapper::SubstituteMapper(Options options, LabelSet labels, Substitutes substitutes)
    : substitutes_(substitutes), votes_(options.map.voxel_size_m) {
  options.objects.enabled = false;
  options.regularizer.enabled = false;
  ReplacedStages stages;
  if (substitutes.tracking) {
    stages.associate = [this](const FrameToLabel& to_label, PanopticMap& map) { return associate(to_label, map); };
  }
  if (substitutes.storage) {
    stages.labelled = [this](const FrameToLabel& to_label, std::span<const LabelSlot> given) {
      votes_.add(to_label.frame, to_label.registered, given);
    };
  }
  mapper_ = std::make_unique<MapperParts>(options, std::move(labels), std::move(stages));
}

Outcome SubstituteMapper::add(const Frame& frame, const Segmentation& segmentation, const Image<std::uint16_t>& true_instance) {
  PANOPTIC_ASSERT(true_instance.same_size(frame.depth.width(), frame.depth.height()));
  true_instance_ = &true_instance;
  return mapper_->add(frame, segmentation);
}

Association SubstituteMapper::associate(const FrameToLabel& to_label, PanopticMap& map) {
  const RegisteredFrame& registered = to_label.registered;
  const std::vector<Segment>& segments = to_label.segmentation.segments;
  const auto instances = majority_instances(registered, segments.size(), *true_instance_);
  segment_ids_.assign(segments.size(), LabelSlot::kUnknown);
  for (std::size_t s = 0; s < segments.size(); ++s) {
    if (map.labels.is_stuff(segments[s].class_id)) {
      segment_ids_[s] = LabelSet::of_class(segments[s].class_id);
    } else if (instances[s] != 0) {
      segment_ids_[s] = object_of(instances[s], map.objects);
      if (segment_ids_[s] != LabelSlot::kUnknown) map.objects.observe(segment_ids_[s], segments[s], to_label.frame.index);
    }
  }
  labels_.assign(registered.segment.size(), LabelSlot::kNoVote);
  segment_areas_px_.assign(segments.size(), 0);
  for (std::size_t i = 0; i < registered.pixel_count(); ++i) {
    const std::uint16_t segment = registered.segment[i];
    if (segment == RegisteredFrame::kNoSegment) continue;
    labels_[i] = segment == 0 ? LabelSlot::kUnknown : segment_ids_[segment - 1U];
    if (segment != 0) ++segment_areas_px_[segment - 1U];
  }
  return {labels_, segment_ids_, segment_areas_px_};
}

LabelSlot SubstituteMapper::object_of(std::uint16_t true_instance, ObjectRegistry& objects) {
  const auto [entry, is_new] = object_of_instance_.try_emplace(true_instance, LabelSlot::kUnknown);
  if (is_new || objects.find(entry->second) == nullptr) entry->second = objects.create().value_or(LabelSlot::kUnknown);
  return entry->second;
}

Mesh SubstituteMapper::mesh() {
  Mesh mesh = mapper_->mesh();
  if (!substitutes_.storage) return mesh;
  for (MeshVertex& vertex : mesh.vertices) {
    const std::optional<LabelSlot> winner = votes_.winner(vertex.position);
    if (!winner) continue;
    vertex.panoptic_id = map().objects.id_of(*winner);
    vertex.class_id = map().class_of(*winner);
  }
  return mesh;
}

}  // namespace panoptic
