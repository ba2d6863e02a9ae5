// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predictor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/predict/coco_panoptic.h"
#include "panoptic/predict/prediction_io.h"

namespace panoptic {
namespace {

// The segmentation that fuse would have made with keep_whole_classes = false: pixels of things that were not told apart are
// unknown.
Segmentation without_whole_classes(const Segmentation& segmentation, const LabelSet& labels) {
  Segmentation result{segmentation.segment_at, {}};
  std::vector<std::uint16_t> kept_as = {0};  // by value of segment_at
  for (const Segment& segment : segmentation.segments) {
    const bool dropped = segment.is_whole_class && labels.is_thing(segment.class_id);
    if (!dropped) result.segments.push_back(segment);
    kept_as.push_back(dropped ? std::uint16_t{0} : static_cast<std::uint16_t>(result.segments.size()));
  }
  for (std::size_t i = 0; i < result.segment_at.size(); ++i) result.segment_at[i] = kept_as[result.segment_at[i]];
  return result;
}

using ReadFrame = std::function<Segmentation(std::int64_t frame_index)>;

class FilePredictor final : public Predictor {
 public:
  FilePredictor(std::string name, LabelSet labels, ReadFrame read, bool keep_whole_classes, PredictorReport report = {})
      : name_(std::move(name)),
        labels_(std::move(labels)),
        read_(std::move(read)),
        keep_whole_classes_(keep_whole_classes),
        report_(std::move(report)) {}

  const LabelSet& labels() const override { return labels_; }

  Segmentation predict(const Frame& frame) override {
    Segmentation segmentation = read_(frame.index);
    const auto& image = segmentation.segment_at;
    if (!image.empty() && !frame.color.empty() && !image.same_size(frame.color.width(), frame.color.height())) {
      throw Error(fmt::format(
          "{}: the prediction of frame {} is {} x {} pixels, its colour image {} x {}; predict on this recording's images", name_,
          frame.index, image.width(), image.height(), frame.color.width(), frame.color.height()));
    }
    return keep_whole_classes_ ? segmentation : without_whole_classes(segmentation, labels_);
  }

  PredictorReport report() const override { return report_; }

 private:
  std::string name_;
  LabelSet labels_;
  ReadFrame read_;
  bool keep_whole_classes_;
  PredictorReport report_;
};

bool same_classes(const LabelSet& a, const LabelSet& b) {
  return std::equal(
      a.classes().begin(), a.classes().end(), b.classes().begin(), b.classes().end(),
      [](const LabelClass& x, const LabelClass& y) { return x.id == y.id && x.name == y.name && x.is_thing == y.is_thing; });
}

}  // namespace

std::unique_ptr<Predictor> make_file_predictor(const std::filesystem::path& path, const std::optional<LabelSet>& labels,
                                               bool keep_whole_classes) {
  if (!is_there(path)) throw Error(fmt::format("there are no predictions at {}: check the path", path.string()));
  if (is_file(path / "predictions.json")) {
    PredictionFolder folder = open_predictions(path);
    if (labels && !same_classes(*labels, folder.labels)) {
      throw Error(
          fmt::format("{}: these predictions are of the label set '{}', not '{}'; leave the label set out or predict again",
                      path.string(), folder.labels.name(), labels->name()));
    }
    LabelSet own = folder.labels;
    ReadFrame read = [folder = std::move(folder)](std::int64_t index) { return read_prediction(folder, index); };
    return std::make_unique<FilePredictor>(path.string(), std::move(own), std::move(read), keep_whole_classes);
  }
  const std::optional<std::filesystem::path> json = find_coco_panoptic(path);
  if (!json) {
    throw Error(
        fmt::format("{} holds no predictions: expected predictions.json, or one COCO panoptic JSON file (docs/predictions.md)",
                    path.string()));
  }
  CocoPanoptic coco = read_coco_panoptic(*json, labels);
  LabelSet own = coco.labels;
  PredictorReport report;
  if (!coco.unmatched.empty()) report.notes.push_back(fmt::format("{}: {}", path.string(), coco.unmatched));
  if (coco.in_order > 0)
    report.notes.push_back(
        fmt::format("{}: the names of its images have no numbers: they are taken for frames 0 to {} in their order",
                    path.string(), coco.in_order - 1));
  ReadFrame read = [coco = std::move(coco)](std::int64_t index) { return read_coco_frame(coco, index); };
  return std::make_unique<FilePredictor>(path.string(), std::move(own), std::move(read), keep_whole_classes, std::move(report));
}

}  // namespace panoptic
