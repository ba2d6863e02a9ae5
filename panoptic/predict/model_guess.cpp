// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/model_guess.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <set>

#include "panoptic/error.h"
#include "panoptic/predict/class_names.h"
#include "panoptic/predict/preprocess.h"

namespace panoptic {
namespace {

constexpr int kDefaultSide_px = 640;
constexpr std::size_t kMostGuessedClasses = 999;  // of a label set

// Ultralytics writes {0: 'person', 1: "driver's seat"}.
std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t at = text.find(':'); at != std::string::npos; at = text.find(':', at)) {
    const std::size_t quote = text.find_first_not_of(' ', at + 1);
    if (quote == std::string::npos || (text[quote] != '\'' && text[quote] != '"')) return {};
    const std::size_t end = text.find(text[quote], quote + 1);
    if (end == std::string::npos) return {};
    names.push_back(text.substr(quote + 1, end - quote - 1));
    at = end;
  }
  const std::set<std::string> unique(names.begin(), names.end());
  return unique.size() == names.size() ? names : std::vector<std::string>();
}

std::vector<std::string> numbered(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back(fmt::format("class {}", i));
  return names;
}

// Numbers of classes that the extents of the outputs allow: all of them, with a "no object", or with boxes and 32 masks.
std::vector<std::size_t> counts_in(const std::vector<Tensor>& outputs) {
  std::vector<std::size_t> counts;
  for (const int less : {0, 1, 36, 37}) {
    for (const Tensor& output : outputs) {
      for (const int extent : output.shape) {
        const int count = extent - less;
        if (count < 2 || count > static_cast<int>(kMostGuessedClasses)) continue;
        if (std::find(counts.begin(), counts.end(), static_cast<std::size_t>(count)) == counts.end())
          counts.push_back(static_cast<std::size_t>(count));
      }
    }
  }
  return counts;
}

// The lists worth trying, well-known ones first.
std::vector<std::vector<std::string>> class_guesses(const Network& network, const std::vector<Tensor>& outputs) {
  const auto names = network.file().metadata.find("names");
  if (names != network.file().metadata.end()) {
    if (std::vector<std::string> own = names_in(names->second); !own.empty()) return {own};
  }
  std::vector<std::vector<std::string>> guesses;
  const std::vector<std::size_t> counts = counts_in(outputs);
  for (const std::size_t count : counts) {
    for (ClassList& list : class_lists_of(count)) guesses.push_back(std::move(list.classes));
  }
  guesses.push_back(class_lists_of(80).front().classes);  // a network of instances does not show how many it has
  for (const std::size_t count : counts) guesses.push_back(numbered(count));
  return guesses;
}

std::optional<Reading> reading_with(const Model& model, const std::vector<Tensor>& outputs) {
  try {
    return recognise(outputs, model, "panoptic");
  } catch (const Error&) {  // another list may do better
    return std::nullopt;
  }
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

}  // namespace

Model guess_model(const std::filesystem::path& onnx, Engine engine) {
  const Network network(onnx, engine);
  Model model;
  model.path = onnx;
  model.name = onnx.stem().string();
  model.weights = onnx.filename().string();
  model.input.width = network.input().width > 0 ? network.input().width : kDefaultSide_px;
  model.input.height = network.input().height > 0 ? network.input().height : kDefaultSide_px;
  const Image<Rgb> grey(model.input.width, model.input.height, Rgb{128, 128, 128});
  const std::vector<Tensor> outputs = network.run(to_input(grey, model.input));
  for (std::vector<std::string>& guess : class_guesses(network, outputs)) {
    model.classes = std::move(guess);
    const std::optional<Reading> reading = reading_with(model, outputs);
    if (!reading) continue;
    model.task = reading->task;
    if (reading->task == "instance") model.input.resize = "letterbox";
    return model;
  }
  recognise(outputs, model, "panoptic");  // says why not
  return model;
}

std::string to_toml(const Model& model, const Reading& reading) {
  std::vector<std::string> classes;
  for (const std::string& name : model.classes) classes.push_back(quoted(name));
  const InputFormat& input = model.input;
  std::string text = fmt::format(
      "# Outputs: {}\nname = {}\ntask = {}\nweights = {}\n# Check that these are the network's classes, in its order.\nclasses = "
      "[{}]\n",
      reading.text, quoted(model.name), quoted(std::string(reading.task)), quoted(model.weights), fmt::join(classes, ", "));
  if (!model.decoder.empty()) text += fmt::format("decoder = {}\n", quoted(model.decoder));
  text += fmt::format(
      "\n[input]\nwidth = {}\nheight = {}\n# Check against the preprocessing that the network was trained with:\nchannels = "
      "{}\nresize = {}\n"
      "pad_value = {}\nscale = {}\nmean = [{}]\nstd = [{}]\n",
      input.width, input.height, quoted(input.channels), quoted(input.resize), input.pad_value, input.scale,
      fmt::join(input.mean, ", "), fmt::join(input.std, ", "));
  if (!model.outputs.empty()) text += "\n[outputs]\n";
  for (const auto& [role, output] : model.outputs) text += fmt::format("{} = {}\n", role, quoted(output));
  for (const auto& [label_set, table] : model.class_maps) {
    text += fmt::format("\n[class_map.{}]\n", quoted(label_set));
    for (const auto& [from, to] : table) text += fmt::format("{} = {}\n", quoted(from), quoted(to));
  }
  return text;
}

}  // namespace panoptic
