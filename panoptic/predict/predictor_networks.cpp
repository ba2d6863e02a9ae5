// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predictor.h"

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>

#include "panoptic/base/config.h"
#include "panoptic/base/memory.h"
#include "panoptic/error.h"
#include "panoptic/predict/network_stage.h"

namespace panoptic {
namespace {

std::unique_ptr<NetworkStage> load_stage(const std::string& description, std::string_view task, const NetworkOptions& options,
                                         const LabelSet& labels) {
  const LeftOutOfLimit network;
  Model model = load_model(description);
  if (options.score_threshold) model.thresholds.score = static_cast<float>(*options.score_threshold);
  return std::make_unique<NetworkStage>(std::move(model), task, options, labels);
}

// The findings of all networks in one image.
struct Found {
  std::vector<ClassScores> scores;
  std::vector<Instance> instances;
};

class NetworkPredictor final : public Predictor {
 public:
  NetworkPredictor(const NetworkOptions& options, LabelSet labels)
      : labels_(std::move(labels)), unknown_share_(options.unknown_share), segmentation_(options.segmentation) {
    for (const std::string& description : options.semantic) {
      const bool is_both = description == options.instance;
      semantic_.push_back(load_stage(description, is_both ? "panoptic" : "semantic", options, labels_));
      if (is_both) instance_ = semantic_.back().get();
    }
    if (!options.instance.empty() && instance_ == nullptr) {
      own_instance_ = load_stage(options.instance, "instance", options, labels_);
      instance_ = own_instance_.get();
    }
    share_out();
  }

  const LabelSet& labels() const override { return labels_; }

  // One network after the other, each on all threads: side by side on half of them was slower (docs/networks.md).
  Segmentation predict(const Frame& frame) override {
    if (frame.color.empty()) return {};
    Found found;
    for (NetworkStage* stage : stages()) add(*stage, frame.color, found);
    const Image<ClassId> classes = classes_of(std::move(found.scores), frame.color);
    return fuse(classes, found.instances, labels_, segmentation_);
  }

  std::optional<PredictorHalves> halves() override {
    const std::vector<NetworkStage*> all = stages();
    const bool apart =
        std::none_of(all.begin(), all.end(), [](const NetworkStage* s) { return s->gives_scores && s->gives_instances; });
    if (semantic_.empty() || instance_ == nullptr || !apart) return std::nullopt;
    return PredictorHalves{[this](const ImageView<Rgb>& color) {
                             Found found;
                             for (const auto& stage : semantic_) add(*stage, color, found);
                             return classes_of(std::move(found.scores), color);
                           },
                           [this](const ImageView<Rgb>& color) {
                             Found found;
                             add(*instance_, color, found);
                             return found.instances;
                           },
                           [this](const Image<ClassId>& classes, const std::vector<Instance>& found) {
                             return fuse(classes, found, labels_, segmentation_);
                           }};
  }

  std::vector<std::string> take_warnings() override {
    std::vector<std::string> all;
    for (NetworkStage* stage : stages()) {
      for (std::string& warning : stage->take_warnings()) all.push_back(std::move(warning));
    }
    return all;
  }

  PredictorReport report() const override {
    PredictorReport result;
    for (const NetworkStage* stage : stages()) {
      if (result.trouble.empty()) result.trouble = stage->trouble();
      if (std::string unmatched = stage->unmatched(); !unmatched.empty()) result.notes.push_back(std::move(unmatched));
    }
    return result;
  }

 private:
  // A network that finds both stands for the other one where that is not given.
  void share_out() {
    for (NetworkStage* stage : stages()) {
      const bool finds_both = stage->reading().task == "panoptic";
      stage->gives_scores = stage != own_instance_.get() || (finds_both && semantic_.empty());
      stage->gives_instances = stage == instance_ || (finds_both && instance_ == nullptr);
    }
  }

  std::vector<NetworkStage*> stages() const {
    std::vector<NetworkStage*> all;
    for (const auto& stage : semantic_) all.push_back(stage.get());
    if (own_instance_) all.push_back(own_instance_.get());
    return all;
  }

  static void add(NetworkStage& stage, const ImageView<Rgb>& color, Found& found) {
    Findings findings = stage.run(color);
    if (stage.gives_scores && findings.scores) found.scores.push_back(std::move(*findings.scores));
    if (!stage.gives_instances) return;
    for (Instance& instance : findings.instances) found.instances.push_back(std::move(instance));
  }

  Image<ClassId> classes_of(std::vector<ClassScores> scores, const ImageView<Rgb>& color) const {
    if (scores.empty()) return {color.width(), color.height()};
    return most_likely(average(std::move(scores), unknown_share_), color.width(), color.height());
  }

  LabelSet labels_;
  float unknown_share_;
  SegmentationOptions segmentation_;
  std::vector<std::unique_ptr<NetworkStage>> semantic_;
  std::unique_ptr<NetworkStage> own_instance_;
  NetworkStage* instance_ = nullptr;  // the same, or the semantic network that is also given as the one for instances
};

}  // namespace

Fields fields(NetworkOptions& options) {
  constexpr int kMaxThreads = 1024;
  return {
      {"semantic", &options.semantic, "model descriptions of the semantic networks; their class probabilities are averaged", {}},
      {"instance", &options.instance, "model description of the instance network", {}},
      {"engine", &options.engine, "inference engine", one_of({"auto", "onnxruntime", "opencv"})},
      {"threads", &options.threads, "threads of inference; 0 = as many as everything else", in_range(0, kMaxThreads)},
      {"score_threshold", &options.score_threshold, "instances below are dropped, whatever the model description says",
       in_range(0, 1)},
      {"likeliest_first",
       &options.likeliest_first,
       "a pixel's class: the likeliest of a network's own classes, then what it is in the label set; false: probabilities of "
       "classes that are the same there are added first",
       {}},
      {"unknown_share", &options.unknown_share,
       "what counts of the probability of network classes that the label set lacks, when a pixel's class is chosen",
       in_range(0, 1)},
      {"keep_whole_classes",
       &options.segmentation.keep_whole_classes,
       "things that only the semantic network sees keep their class, without an id of their own; false: they are unknown",
       {}},
      {"smaller_in_front",
       &options.segmentation.smaller_in_front,
       "where masks overlap, the smaller is in front; false: the higher score",
       {}}};
}

std::unique_ptr<Predictor> make_network_predictor(const NetworkOptions& options, LabelSet labels) {
  if (options.semantic.empty() && options.instance.empty()) {
    throw Error("no network is given: name a model description with --semantic, --instance or both");
  }
  return std::make_unique<NetworkPredictor>(options, std::move(labels));
}

}  // namespace panoptic
