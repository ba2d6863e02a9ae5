// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/decoders.h"

#include <fmt/format.h>

#include <span>
#include <string>
#include <string_view>

#include "panoptic/error.h"

namespace panoptic {
namespace {

template <typename Decoder>
struct Entry {
  std::string_view name;
  Decoder decode;
};

constexpr Entry<SemanticDecoder> kSemantic[] = {{"semantic_logits", decode_semantic_logits}};
constexpr Entry<InstanceDecoder> kInstance[] = {{"yolo_seg", decode_yolo_seg}};

template <typename Decoder>
Decoder find_decoder(std::span<const Entry<Decoder>> table, const Model& model, std::string_view task) {
  if (model.task != task) {
    throw Error(fmt::format("{}: its task is '{}', but it is used as the {} network", model.path.string(), model.task, task));
  }
  std::string names;
  for (const Entry<Decoder>& entry : table) {
    if (entry.name == model.decoder) return entry.decode;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", entry.name);
  }
  throw Error(fmt::format("{}: there is no decoder '{}' for {} networks; use one of: {}", model.path.string(), model.decoder,
                          task, names));
}

}  // namespace

SemanticDecoder semantic_decoder(const Model& model) { return find_decoder<SemanticDecoder>(kSemantic, model, "semantic"); }
InstanceDecoder instance_decoder(const Model& model) { return find_decoder<InstanceDecoder>(kInstance, model, "instance"); }

}  // namespace panoptic
