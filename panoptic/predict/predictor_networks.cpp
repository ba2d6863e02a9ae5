// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predictor.h"

#include <utility>

#include "panoptic/base/config.h"
#include "panoptic/error.h"
#include "panoptic/predict/decoders.h"
#include "panoptic/predict/model.h"
#include "panoptic/predict/network.h"
#include "panoptic/predict/preprocess.h"

namespace panoptic {
namespace {

// A network with its description and decoder: from a colour image to whatever the decoder gives.
template <typename Decoder>
class Stage {
 public:
  Stage(Model model, Decoder decode, std::vector<ClassId> class_of, const NetworkOptions& options)
      : model_(std::move(model)),
        decode_(decode),
        class_of_(std::move(class_of)),
        likeliest_first_(options.likeliest_first),
        network_(load(model_, options)) {
    run(Image<Rgb>(model_.input.width, model_.input.height));
  }

  auto run(const ImageView<Rgb>& color) const {
    const DecodeContext context{model_, class_of_, place(color.width(), color.height(), model_.input), likeliest_first_};
    return decode_(network_.run(to_input(color, model_.input)), context);
  }

 private:
  static Network load(const Model& model, const NetworkOptions& options) {
    const Engine engine = engine_from(options.engine);
    return {find_weights(model, engine), engine, options.threads};
  }

  Model model_;
  Decoder decode_;
  std::vector<ClassId> class_of_;
  bool likeliest_first_;
  Network network_;
};

using SemanticStage = Stage<SemanticDecoder>;
using InstanceStage = Stage<InstanceDecoder>;

SemanticStage load_semantic(const std::string& description, const NetworkOptions& options, const LabelSet& labels) {
  Model model = load_model(description);
  const SemanticDecoder decode = semantic_decoder(model);
  std::vector<ClassId> class_of = map_classes(model, labels);
  return {std::move(model), decode, std::move(class_of), options};
}

InstanceStage load_instance(const NetworkOptions& options, const LabelSet& labels) {
  Model model = load_model(options.instance);
  const InstanceDecoder decode = instance_decoder(model);
  if (options.score_threshold) model.thresholds.score = static_cast<float>(*options.score_threshold);
  std::vector<ClassId> class_of = map_classes(model, labels);
  for (ClassId& id : class_of) {
    if (!labels.is_thing(id)) id = ClassId::kUnknown;  // what is stuff in this label set has no instances
  }
  return {std::move(model), decode, std::move(class_of), options};
}

class NetworkPredictor final : public Predictor {
 public:
  NetworkPredictor(const NetworkOptions& options, LabelSet labels)
      : labels_(std::move(labels)), unknown_share_(options.unknown_share), segmentation_(options.segmentation) {
    for (const std::string& description : options.semantic) semantic_.push_back(load_semantic(description, options, labels_));
    if (!options.instance.empty()) instance_.emplace(load_instance(options, labels_));
  }

  const LabelSet& labels() const override { return labels_; }

  // One network after the other, each on all threads: side by side on half of them was slower (docs/networks.md).
  Segmentation predict(const Frame& frame) override {
    if (frame.color.empty()) return {};
    const Image<ClassId> classes = semantic(frame.color);
    return fuse(classes, instances(frame.color), labels_, segmentation_);
  }

  std::optional<PredictorHalves> halves() override {
    if (semantic_.empty() || !instance_) return std::nullopt;
    return PredictorHalves{[this](const ImageView<Rgb>& color) { return semantic(color); },
                           [this](const ImageView<Rgb>& color) { return instances(color); },
                           [this](const Image<ClassId>& classes, const std::vector<Instance>& found) {
                             return fuse(classes, found, labels_, segmentation_);
                           }};
  }

 private:
  Image<ClassId> semantic(const ImageView<Rgb>& color) const {
    std::vector<ClassScores> scores;
    for (const SemanticStage& network : semantic_) scores.push_back(network.run(color));
    if (scores.empty()) return {color.width(), color.height()};
    return most_likely(average(std::move(scores), unknown_share_), color.width(), color.height());
  }
  std::vector<Instance> instances(const ImageView<Rgb>& color) const {
    return instance_ ? instance_->run(color) : std::vector<Instance>();
  }

  LabelSet labels_;
  float unknown_share_;
  SegmentationOptions segmentation_;
  std::vector<SemanticStage> semantic_;
  std::optional<InstanceStage> instance_;
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
