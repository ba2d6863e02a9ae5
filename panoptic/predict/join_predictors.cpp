// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/join_predictors.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "panoptic/data/same_labels.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

class JoinedPredictor final : public Predictor {
 public:
  explicit JoinedPredictor(std::vector<NumberedPredictor> predictors)
      : predictors_(std::move(predictors)),
        first_(std::find_if(predictors_.begin(), predictors_.end(), [](const auto& p) { return p.predictor != nullptr; })) {
    PANOPTIC_ASSERT(first_ != predictors_.end());
    for (const NumberedPredictor& p : predictors_) require_same_labels(p);
  }

  const LabelSet& labels() const override { return first_->predictor->labels(); }

  Segmentation predict(const Frame& frame) override {
    const auto after = std::upper_bound(predictors_.begin(), predictors_.end(), frame.index,
                                        [](std::int64_t number, const auto& p) { return number < p.first_number; });
    if (after == predictors_.begin() || std::prev(after)->predictor == nullptr) return {};
    Frame own = frame;
    own.index -= std::prev(after)->first_number;
    return std::prev(after)->predictor->predict(own);
  }

  std::vector<std::string> take_warnings() override {
    std::vector<std::string> all;
    for (const NumberedPredictor& p : predictors_) {
      if (p.predictor != nullptr) std::ranges::move(p.predictor->take_warnings(), std::back_inserter(all));
    }
    return all;
  }

  PredictorReport report() const override {
    PredictorReport all;
    for (const NumberedPredictor& p : predictors_) {
      if (p.predictor == nullptr) continue;
      PredictorReport report = p.predictor->report();
      std::ranges::move(report.notes, std::back_inserter(all.notes));
      if (all.trouble.empty()) all.trouble = std::move(report.trouble);
    }
    return all;
  }

 private:
  void require_same_labels(const NumberedPredictor& p) const {
    if (p.predictor == nullptr || same_labels(p.predictor->labels(), labels())) return;
    throw Error(fmt::format(
        "{}: these predictions are of the label set '{}', those of {} of '{}'; give --labels, or predict again with one", p.name,
        p.predictor->labels().name(), first_->name, labels().name()));
  }

  std::vector<NumberedPredictor> predictors_;
  std::vector<NumberedPredictor>::iterator first_;
};

}  // namespace

std::unique_ptr<Predictor> join_predictors(std::vector<NumberedPredictor> predictors) {
  return std::make_unique<JoinedPredictor>(std::move(predictors));
}

}  // namespace panoptic
