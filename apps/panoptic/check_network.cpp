// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <random>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/predict/class_names.h"
#include "panoptic/predict/model_guess.h"
#include "panoptic/predict/network_stage.h"
#include "panoptic/predict/preprocess.h"

namespace panoptic {
namespace {

struct Seen {
  Image<Rgb> picture;
  Findings findings;
  Image<ClassId> classes;
  Segmentation segmentation;
};

// Noise, for a network without a picture: the same in every run.
Image<Rgb> noise(int width, int height) {
  Image<Rgb> image(width, height);
  std::mt19937 random(1);
  const auto byte = [&] { return static_cast<std::uint8_t>(random() % 256); };
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = {byte(), byte(), byte()};
  return image;
}

bool is_description(const std::string& path) { return path.ends_with(".toml"); }

bool knows_any(const Model& model, const LabelSet& labels) {
  return std::any_of(model.classes.begin(), model.classes.end(),
                     [&](const std::string& name) { return counterpart_of(name, labels) != nullptr; });
}

// The network's own classes, where they are known by their numbers alone.
LabelSet own_labels(const Model& model) {
  std::vector<LabelClass> classes;
  for (std::size_t c = 0; c < model.classes.size(); ++c) {
    const auto shade = [&](std::size_t step) { return static_cast<std::uint8_t>((c + 1) * step % 256); };
    classes.push_back(
        {static_cast<ClassId>(c + 1), model.classes[c], model.task != "semantic", {shade(37), shade(91), shade(151)}});
  }
  return {"of the network itself", std::move(classes)};
}

Seen look(NetworkStage& stage, const Arguments& arguments, const LabelSet& labels, const NetworkOptions& options) {
  Seen seen;
  const InputFormat& input = stage.model().input;
  seen.picture = arguments.image.empty() ? noise(input.width, input.height) : read_rgb(arguments.image);
  seen.findings = stage.run(seen.picture);
  seen.classes = Image<ClassId>(seen.picture.width(), seen.picture.height());
  if (seen.findings.scores) {
    seen.classes =
        most_likely(average({*seen.findings.scores}, options.unknown_share), seen.picture.width(), seen.picture.height());
  }
  seen.segmentation = fuse(seen.classes, seen.findings.instances, labels, options.segmentation);
  return seen;
}

// Segments in their colours over the picture.
Image<Rgb> drawn(const Seen& seen, const LabelSet& labels) {
  Image<Rgb> picture = seen.picture;
  const auto blend = [](int a, int b) { return static_cast<std::uint8_t>((a + b) / 2); };
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const std::uint16_t segment = seen.segmentation.segment_at[i];
    if (segment == 0) continue;
    const Segment& s = seen.segmentation.segments[segment - 1U];
    const bool is_object = labels.is_thing(s.class_id) && !s.is_whole_class;
    const Rgb paint =
        is_object ? color_of(static_cast<PanopticId>(labels.first_thing() + segment), labels) : labels.find(s.class_id)->color;
    picture[i] = {blend(picture[i].r, paint.r), blend(picture[i].g, paint.g), blend(picture[i].b, paint.b)};
  }
  return picture;
}

std::map<std::string, double> shares_of(const Seen& seen, const LabelSet& labels) {
  std::map<std::string, double> shares;
  for (const std::uint16_t segment : seen.segmentation.segment_at.pixels()) {
    const ClassId id = segment == 0 ? ClassId::kUnknown : seen.segmentation.segments[segment - 1U].class_id;
    shares[std::string(labels.name_of(id))] += 1.0 / static_cast<double>(seen.segmentation.segment_at.size());
  }
  return shares;
}

// Nothing if the shapes differ.
std::optional<double> largest_difference(const std::vector<Tensor>& a, const std::vector<Tensor>& b) {
  if (a.size() != b.size()) return std::nullopt;
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].shape != b[i].shape) return std::nullopt;
    for (std::size_t k = 0; k < a[i].values.size(); ++k) {
      largest = std::max(largest, std::abs(static_cast<double>(a[i].values[k]) - b[i].values[k]));
    }
  }
  return largest;
}

// Whether the other engine gives the same numbers; empty if this build has none.
std::string compare_engines(const NetworkStage& stage, const Image<Rgb>& picture, Engine used) {
  for (const Engine other : built_in_engines()) {
    if (other == used) continue;
    try {
      const Tensor input = to_input(picture, stage.model().input);
      const std::vector<Tensor> a = stage.network().run(input);
      const std::vector<Tensor> b = Network(find_weights(stage.model(), other), other).run(input);
      const std::optional<double> largest = largest_difference(a, b);
      if (!largest) return fmt::format("{} gives outputs of other shapes: do not use it", name_of(other));
      return fmt::format("{} gives the same within {:.2g}", name_of(other), *largest);
    } catch (const Error& e) {
      return fmt::format("{} cannot be used: {}", name_of(other), e.what());
    }
  }
  return "";
}

Json to_json(const OnnxValue& value) {
  return {{"name", value.name}, {"shape", shape_text(value.shape)}, {"type", std::string(text_of(value.type))}};
}

Json to_json(const NetworkStage& stage, const Seen& seen, const LabelSet& labels) {
  const OnnxFile& file = stage.network().file();
  Json json = {{"network", stage.model().name},
               {"task", std::string(stage.reading().task)},
               {"decoder", std::string(stage.reading().decoder)},
               {"reading", stage.reading().text},
               {"operator_set", file.operator_set},
               {"inputs", Json::array()},
               {"outputs", Json::array()}};
  for (const OnnxValue& value : file.inputs) json["inputs"].push_back(to_json(value));
  for (const OnnxValue& value : file.outputs) json["outputs"].push_back(to_json(value));
  json["classes"] = Json::array();
  for (std::size_t c = 0; c < stage.model().classes.size(); ++c) {
    const ClassId id = stage.class_of()[c];
    json["classes"].push_back({{"name", stage.model().classes[c]},
                               {"counterpart", id == ClassId::kUnknown ? Json() : Json(std::string(labels.name_of(id)))}});
  }
  json["shares"] = Json::object();
  for (const auto& [name, share] : shares_of(seen, labels)) json["shares"][name] = share;
  json["instances"] = Json::array();
  for (const Instance& instance : seen.findings.instances) {
    json["instances"].push_back({{"class", std::string(labels.name_of(instance.segment.class_id))},
                                 {"score", instance.segment.score},
                                 {"x", instance.x0},
                                 {"y", instance.y0},
                                 {"width", instance.mask.width()},
                                 {"height", instance.mask.height()}});
  }
  return json;
}

void print(const NetworkStage& stage, const Seen& seen, const LabelSet& labels) {
  const OnnxFile& file = stage.network().file();
  const OnnxValue& input = file.inputs.front();
  fmt::print("network   {} (operator set {})\n", stage.model().name, file.operator_set);
  fmt::print("input     '{}' {}, {}\n", input.name, shape_text(input.shape), text_of(input.type));
  for (const OnnxValue& output : file.outputs) {
    fmt::print("output    '{}' {}, {}\n", output.name, shape_text(output.shape), text_of(output.type));
  }
  fmt::print("read as   {}: {} [decoder {}]\n", stage.reading().task, stage.reading().text, stage.reading().decoder);
  const auto known =
      std::count_if(stage.class_of().begin(), stage.class_of().end(), [](ClassId id) { return id != ClassId::kUnknown; });
  fmt::print("classes   {} of {} have a counterpart in the label set '{}'\n", known, stage.class_of().size(), labels.name());
  if (stage.reading().task != "semantic") fmt::print("instances {}\n", seen.findings.instances.size());
  std::vector<std::string> parts;
  for (const auto& [name, share] : shares_of(seen, labels)) parts.push_back(fmt::format("{} {:.1f} %", name, 100 * share));
  fmt::print("pixels    {}\n", fmt::join(parts, ", "));
  if (const std::string unmatched = stage.unmatched(); !unmatched.empty()) fmt::print("note      {}\n", unmatched);
}

}  // namespace

int check_network(const Arguments& arguments) {
  set_thread_count(arguments.threads);
  NetworkOptions options;
  options.engine = arguments.engine;
  const Engine engine = engine_from(options.engine);
  const bool is_described = is_description(arguments.network);
  Model model = is_described ? load_model(arguments.network) : guess_model(arguments.network, engine);
  LabelSet labels = load_label_set(arguments.labels.empty() ? "indoor" : arguments.labels);
  if (!is_described && !knows_any(model, labels)) labels = own_labels(model);
  const std::string task = model.task.empty() ? "panoptic" : model.task;
  const Model described = model;
  NetworkStage stage(std::move(model), task, options, labels);
  const Seen seen = look(stage, arguments, labels, options);
  print(stage, seen, labels);
  if (const std::string engines = compare_engines(stage, seen.picture, engine); !engines.empty())
    fmt::print("engines   {}\n", engines);
  if (!arguments.json.empty()) write_json_file(arguments.json, to_json(stage, seen, labels));
  if (!arguments.png.empty()) write_png(arguments.png, drawn(seen, labels));
  if (!arguments.written_description.empty()) write_file(arguments.written_description, to_toml(described, stage.reading()));
  std::fflush(stdout);
  for (const std::string& warning : stage.take_warnings()) tell(fmt::format("warning: {}\n", warning));
  if (arguments.image.empty()) return kDone;  // noise holds nothing
  if (const std::string trouble = stage.trouble(); !trouble.empty()) throw Error(trouble);
  return kDone;
}

}  // namespace panoptic
