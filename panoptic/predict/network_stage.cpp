// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/network_stage.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "panoptic/predict/output_shapes.h"
#include "panoptic/predict/preprocess.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kSilentFrames = 10;    // of a network of instances: a frame without any is nothing unusual
constexpr std::uint64_t kFramesPerCount = 30;  // unmatched classes are counted in one of so many
constexpr std::size_t kMostUnmatchedNamed = 8;

Network load(const Model& model, const NetworkOptions& options) {
  const Engine engine = engine_from(options.engine);
  return {find_weights(model, engine), engine, options.threads};
}

// A cell in which a class of the label set wins.
bool says_known_class(const ClassScores& scores, std::size_t cell, float unknown_share) {
  const std::size_t count = scores.classes.size();
  const float* values = scores.values.data() + cell * count;
  float known = 0;
  float unknown = 0;
  for (std::size_t k = 0; k < count; ++k) {
    float& highest = scores.classes[k] == ClassId::kUnknown ? unknown : known;
    highest = std::max(highest, values[k]);
  }
  return known > unknown * unknown_share;
}

// Whether there is any, and cells differ at all: a network that says the same of every cell of a picture does not look at it.
bool says_anything(const ClassScores& scores, Numbers numbers, float unknown_share) {
  const std::size_t count = scores.classes.size();
  const std::size_t cells = scores.values.size() / count;
  std::size_t cell = 0;
  while (cell < cells && !says_known_class(scores, cell, unknown_share)) ++cell;
  if (cell == cells) return false;
  if (numbers == Numbers::kClassNumbers || cells == 1) return true;
  const auto differ = [&](std::size_t i) {
    return !std::equal(scores.values.begin(), scores.values.begin() + static_cast<std::ptrdiff_t>(count),
                       scores.values.begin() + static_cast<std::ptrdiff_t>(i * count));
  };
  for (std::size_t i = 1; i < cells; ++i) {
    if (differ(i)) return true;
  }
  return false;
}

std::size_t not_finite_in(const std::vector<Tensor>& outputs) {
  std::size_t count = 0;
  for (const Tensor& output : outputs) count += count_not_finite(output.values);
  return count;
}

// A network that takes bytes gets the pixels as they are: it scales them itself, if it does.
void take_pixels_as_they_are(InputFormat& input) {
  input.scale = 1;
  input.mean = {0, 0, 0};
  input.std = {1, 1, 1};
}

}  // namespace

NetworkStage::NetworkStage(Model model, std::string_view task, const NetworkOptions& options, const LabelSet& labels)
    : model_(std::move(model)),
      task_(task),
      labels_(labels),
      class_of_(map_classes(model_, labels)),
      things_(class_of_),
      likeliest_first_(options.likeliest_first),
      unknown_share_(options.unknown_share),
      network_(load(model_, options)),
      cells_of_class_(class_of_.size(), 0) {
  for (ClassId& id : things_) {
    if (!labels.is_thing(id)) id = ClassId::kUnknown;  // what is stuff in this label set has no instances
  }
  if (network_.input().type == OnnxType::kUint8) take_pixels_as_they_are(model_.input);
  warm_up();
}

void NetworkStage::warm_up() {
  const Image<Rgb> empty(model_.input.width, model_.input.height);
  std::vector<Tensor> outputs = network_.run(to_input(empty, model_.input));
  reading_ = recognise(outputs, model_, task_);
  read(std::move(outputs), empty);
}

Findings NetworkStage::read(std::vector<Tensor> outputs, const ImageView<Rgb>& color) const {
  const bool instances = reading_.task == "instance";
  const DecodeContext context{model_, instances ? things_ : class_of_, place(color.width(), color.height(), model_.input),
                              likeliest_first_, &labels_};
  return decode(std::move(outputs), reading_, context);
}

Findings NetworkStage::run(const ImageView<Rgb>& color) {
  std::vector<Tensor> outputs = network_.run(to_input(color, model_.input));
  const std::size_t not_finite = not_finite_in(outputs);
  if (not_finite > 0 && ++not_finite_ == 1) {
    warn(fmt::format("{}: {} of the numbers that the network gives are not finite; where they are, it says nothing",
                     model_.path.string(), not_finite));
  }
  reading_ = recognise(outputs, model_, task_);
  if (frames_ % kFramesPerCount == 0) count_unmatched(outputs, color);
  Findings findings = read(std::move(outputs), color);
  watch(findings);
  return findings;
}

void NetworkStage::watch(const Findings& findings) {
  ++frames_;
  const bool by_scores = findings.scores && gives_scores && says_anything(*findings.scores, reading_.numbers, unknown_share_);
  const bool by_instances = gives_instances && !findings.instances.empty();
  if (by_scores || by_instances) return;
  ++silent_;
  const std::uint64_t patience = findings.scores ? 1 : kSilentFrames;
  if (silent_ != patience || frames_ != patience) return;
  warn(fmt::format("{}: the network has given no label that counts in the first {}; panoptic check-network shows what it sees",
                   model_.path.string(),
                   patience == 1 ? "frame, or the same for every pixel" : fmt::format("{} frames", patience)));
}

// The network's own likeliest class of each cell, where it gives any.
void NetworkStage::count_unmatched(const std::vector<Tensor>& outputs, const ImageView<Rgb>& color) {
  if (reading_.task == "instance" || !gives_scores) return;
  std::vector<ClassId> own(class_of_.size());
  for (std::size_t c = 0; c < own.size(); ++c) own[c] = static_cast<ClassId>(c + 1);
  const Findings findings = decode(outputs, reading_, {model_, own, place(color.width(), color.height(), model_.input), true});
  const ClassScores& scores = *findings.scores;
  const std::size_t count = scores.classes.size();
  for (std::size_t i = 0; i < scores.values.size(); i += count) {
    const auto best = std::max_element(scores.values.begin() + static_cast<std::ptrdiff_t>(i),
                                       scores.values.begin() + static_cast<std::ptrdiff_t>(i + count));
    const ClassId id = scores.classes[static_cast<std::size_t>(best - scores.values.begin()) - i];
    if (*best > 0 && id != ClassId::kUnknown) ++cells_of_class_[number(id) - 1U];
  }
}

void NetworkStage::warn(std::string what) {
  const std::lock_guard lock(mutex_);
  warnings_.push_back(std::move(what));
}

std::vector<std::string> NetworkStage::take_warnings() {
  const std::lock_guard lock(mutex_);
  return std::exchange(warnings_, {});
}

std::string NetworkStage::trouble() const {
  if (not_finite_ > 0) {
    return fmt::format("{}: the network gave numbers that are not finite in {} of {} frames", model_.path.string(), not_finite_,
                       frames_);
  }
  if (frames_ == 0 || silent_ < frames_) return "";
  return fmt::format("{}: in {} frames the network never gave a label that counted{}; panoptic check-network shows what it sees",
                     model_.path.string(), frames_, reading_.task == "instance" ? "" : ", or the same for every pixel");
}

std::string NetworkStage::unmatched() const {
  const auto total = static_cast<double>(std::accumulate(cells_of_class_.begin(), cells_of_class_.end(), std::uint64_t{0}));
  std::vector<std::size_t> missing;
  for (std::size_t c = 0; c < class_of_.size(); ++c) {
    if (class_of_[c] == ClassId::kUnknown && cells_of_class_[c] > 0) missing.push_back(c);
  }
  if (missing.empty()) return "";
  std::stable_sort(missing.begin(), missing.end(),
                   [&](std::size_t a, std::size_t b) { return cells_of_class_[a] > cells_of_class_[b]; });
  std::uint64_t cells = 0;
  std::vector<std::string> names;
  for (const std::size_t c : missing) {
    cells += cells_of_class_[c];
    const double percent = 100 * static_cast<double>(cells_of_class_[c]) / total;
    if (names.size() < kMostUnmatchedNamed) names.push_back(fmt::format("{} {:.1f} %", model_.classes[c], percent));
  }
  if (names.size() < missing.size()) names.push_back(fmt::format("{} more", missing.size() - names.size()));
  return fmt::format("{}: {:.1f} % of the pixels are classes that the label set '{}' lacks: {}", model_.name,
                     100 * static_cast<double>(cells) / total, labels_.name(), fmt::join(names, ", "));
}

}  // namespace panoptic
