// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/decoders.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/predict/output_shapes.h"

namespace panoptic {
namespace {

struct Decoder {
  std::string_view name;
  std::string_view task;
  Match (*recognise)(const std::vector<Tensor>& outputs, const Model& model);
  Findings (*decode)(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context);
};

constexpr Decoder kDecoders[] = {{"semantic_logits", "semantic", recognise_semantic, decode_semantic},
                                 {"yolo_seg", "instance", recognise_yolo, decode_yolo},
                                 {"mask_rcnn", "instance", recognise_mask_rcnn, decode_mask_rcnn},
                                 {"mask_queries", "panoptic", recognise_queries, decode_queries}};

bool serves(std::string_view decoder_task, std::string_view task) {
  return decoder_task == task || decoder_task == "panoptic" || task == "panoptic";
}

void require_decoder(const Model& model) {
  if (model.decoder.empty()) return;
  std::vector<std::string_view> names;
  for (const Decoder& decoder : kDecoders) names.push_back(decoder.name);
  if (std::find(names.begin(), names.end(), model.decoder) != names.end()) return;
  throw Error(fmt::format("{}: there is no decoder '{}'; leave it out, or use one of: {}", model.path.string(), model.decoder,
                          fmt::join(names, ", ")));
}

[[noreturn]] void nothing_fits(const std::vector<Tensor>& outputs, const Model& model, const std::vector<std::string>& reasons) {
  throw Error(fmt::format("{}: the network's outputs are not understood: it gives {}; {}", model.path.string(),
                          outputs_text(outputs), fmt::join(reasons, "; ")));
}

void require_task(const Reading& reading, const Model& model, std::string_view task, const std::vector<std::string>& reasons) {
  if (serves(reading.task, task)) return;
  throw Error(fmt::format("{}: the network gives {}: its task is '{}', but it is used as the {} network (--{}){}{}",
                          model.path.string(), reading.text, reading.task, task, task, reasons.empty() ? "" : "; ",
                          fmt::join(reasons, "; ")));
}

// A description of an earlier version names a decoder that is not the one for what the network gives.
std::string better_decoder(const std::vector<Tensor>& outputs, Model model, std::string_view task) {
  const std::string named = std::exchange(model.decoder, "");
  try {
    return fmt::format("leave out decoder = \"{}\": they are {}", named, recognise(outputs, model, task).text);
  } catch (const Error&) {  // there is none
    return "";
  }
}

}  // namespace

Reading recognise(const std::vector<Tensor>& outputs, const Model& model, std::string_view task) {
  require_decoder(model);
  std::vector<Reading> readings;
  std::vector<std::string> reasons;
  std::string choices;
  for (const Decoder& decoder : kDecoders) {
    if (!model.decoder.empty() && model.decoder != decoder.name) continue;
    Match match = decoder.recognise(outputs, model);
    if (match.reading) {
      match.reading->decoder = decoder.name;
      match.reading->task = decoder.task;
      readings.push_back(std::move(*match.reading));
    } else if (!match.choices.empty()) {
      choices = match.choices;
    } else if (serves(decoder.task, task) || !model.decoder.empty()) {
      reasons.push_back(fmt::format("not {}: {}", decoder.name, match.why_not));
    }
  }
  // A network that detects has planes of classes, or numbers of classes, too.
  if (readings.size() > 1 || !choices.empty()) {
    std::erase_if(readings, [](const Reading& reading) { return reading.task == "semantic"; });
  }
  if (readings.size() > 1) std::erase_if(readings, [&](const Reading& reading) { return !serves(reading.task, task); });
  if (readings.size() == 1) {
    require_task(readings[0], model, task, reasons);
    return readings[0];
  }
  if (readings.size() > 1) {
    choices = fmt::format("they may be {} or {}: name one with decoder = \"{}\" or \"{}\"", readings[0].text, readings[1].text,
                          readings[0].decoder, readings[1].decoder);
  }
  if (!choices.empty()) {
    throw Error(fmt::format("{}: the network's outputs can be read in several ways: it gives {}; {}", model.path.string(),
                            outputs_text(outputs), choices));
  }
  if (!model.decoder.empty()) {
    if (std::string better = better_decoder(outputs, model, task); !better.empty()) reasons.push_back(std::move(better));
  }
  nothing_fits(outputs, model, reasons);
}

Findings decode(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context) {
  const auto* decoder =
      std::find_if(std::begin(kDecoders), std::end(kDecoders), [&](const Decoder& d) { return d.name == reading.decoder; });
  PANOPTIC_ASSERT(decoder != std::end(kDecoders));
  return decoder->decode(std::move(outputs), reading, context);
}

}  // namespace panoptic
