// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The vectors whose values the public evaluators gave.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "panoptic/base/json.h"
#include "panoptic/eval/benchmark_classes.h"
#include "panoptic/eval/instance_ap.h"
#include "panoptic/eval/panoptic_quality.h"
#include "panoptic/eval/semantic_iou.h"
#include "tests/shared_data.h"

namespace panoptic {
namespace {

constexpr const char* kVectors = "specs/eval_vectors.json";
constexpr double kRounding = 1e-9;
constexpr double kSixDigits = 5.1e-7;  // as the file prints panoptic quality

Json vectors() { return read_json_file(test::shared_folder() / kVectors); }

std::vector<int> expanded(const Json& runs) {
  std::vector<int> values;
  for (const Json& run : runs) values.insert(values.end(), run[1].get<std::size_t>(), run[0].get<int>());
  return values;
}

std::vector<ClassId> classes_in(const Json& runs) {
  std::vector<ClassId> classes;
  for (const int value : expanded(runs)) classes.push_back(static_cast<ClassId>(value));
  return classes;
}

VertexLabels ids_in(const Json& runs) {
  VertexLabels labels;
  for (const int id : expanded(runs)) {
    labels.class_id.push_back(static_cast<ClassId>(id / 1000));
    labels.instance.push_back(static_cast<std::uint32_t>(id % 1000));
  }
  return labels;
}

void add_scene(const Json& scene, InstanceAp& metric) {
  std::vector<InstanceMask> masks;
  for (const Json& prediction : scene["preds"]) {
    InstanceMask mask{ClassId{prediction["label"].get<std::uint16_t>()}, prediction["conf"].get<double>(), {}};
    for (auto v = prediction["begin"].get<std::uint32_t>(); v < prediction["end"].get<std::uint32_t>(); ++v)
      mask.vertices.push_back(v);
    masks.push_back(std::move(mask));
  }
  metric.add(ids_in(scene["gt_runs"]), masks);
}

void expect_ap(const ApScores& scores, const Json& expected, const std::string& where) {
  const std::array<std::optional<double>, 3> values = {scores.ap, scores.ap50, scores.ap25};
  for (std::size_t i = 0; i < values.size(); ++i) {
    ASSERT_TRUE(values[i].has_value()) << where;
    EXPECT_NEAR(*values[i], expected[i].get<double>(), kRounding) << where << " " << i;
  }
}

TEST(BenchmarkVectors, GiveTheInstanceScoresOfThePublicEvaluator) {
  PANOPTIC_REQUIRE_SHARED(kVectors);
  const Json all = vectors()["scannet_instance"];
  ASSERT_GE(all.size(), 3U);
  for (const auto& [name, vector] : all.items()) {
    InstanceAp metric;
    for (const Json& scene : vector["scenes"]) add_scene(scene, metric);
    const InstanceScores scores = metric.scores();
    expect_ap(scores.mean, vector["mean_ap_ap50_ap25"], name);
    const Json& defined = vector["per_class_ap_ap50_ap25"];
    for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
      const std::string id = std::to_string(number(benchmark_classes()[c].id));
      if (defined.contains(id)) {
        expect_ap(scores.classes[c], defined[id], fmt::format("{} class {}", name, id));
      } else {
        EXPECT_EQ(scores.classes[c], ApScores{}) << name << " class " << id;
      }
    }
  }
}

TEST(BenchmarkVectors, GiveTheSemanticScoresOfThePublicEvaluator) {
  PANOPTIC_REQUIRE_SHARED(kVectors);
  const Json all = vectors()["scannet_semantic"];
  for (const auto& [name, vector] : all.items()) {
    SemanticIou metric;
    metric.add(classes_in(vector["gt_runs"]), classes_in(vector["pred_runs"]));
    const SemanticScores scores = metric.scores();
    EXPECT_NEAR(scores.miou.value(), vector["mean_over_defined"].get<double>(), kRounding) << name;
    for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
      const std::string id = std::to_string(number(benchmark_classes()[c].id));
      const ClassIou& counts = scores.classes[c];
      ASSERT_EQ(counts.iou().has_value(), vector["iou"].contains(id)) << id;
      if (!counts.iou()) continue;
      EXPECT_NEAR(*counts.iou(), vector["iou"][id].get<double>(), kRounding) << id;
      EXPECT_EQ(Json({counts.tp, counts.fp, counts.fn}), vector["tp_fp_fn"][id]) << id;
    }
  }
}

// Segments of COCO ids as categories of the vector.
PqSegments segments_in(const Json& runs, const Json& categories, const std::map<std::string, std::size_t>& index_of) {
  PqSegments segments;
  std::map<int, std::uint32_t> label_of = {{0, 0}};
  for (const auto& [id, category] : categories.items()) {
    const bool is_truth = category.is_object();
    const int number = is_truth ? category["category"].get<int>() : category.get<int>();
    segments.segments.push_back({index_of.at(std::to_string(number)), is_truth && category["iscrowd"] == 1});
    label_of[std::stoi(id)] = static_cast<std::uint32_t>(segments.segments.size());
  }
  for (const int id : expanded(runs)) segments.segment_at.push_back(label_of.at(id));
  return segments;
}

TEST(BenchmarkVectors, GiveThePanopticQualityOfCoco) {
  PANOPTIC_REQUIRE_SHARED(kVectors);
  const Json vector = vectors()["coco_pq"];
  std::map<std::string, std::size_t> index_of;
  for (const auto& [id, is_thing] : vector["categories_isthing"].items()) {
    index_of.emplace(id, *benchmark_index(static_cast<ClassId>(std::stoi(id))));
    EXPECT_EQ(benchmark_classes()[index_of.at(id)].is_thing, is_thing == 1);
  }
  PanopticQuality metric(kBenchmarkClassCount);
  for (const Json& image : vector["P1"]["images"]) {
    metric.add(segments_in(image["gt_runs"], image["gt_segments"], index_of),
               segments_in(image["pred_runs"], image["pred_segments"], index_of));
  }
  const PanopticScores scores = panoptic_scores(metric.counts(), pq_variant("coco"));
  const Json& expected = vector["P1"]["expected"];
  for (const auto& [name, part] : {std::pair("All", scores.all), {"Things", scores.things}, {"Stuff", scores.stuff}}) {
    EXPECT_NEAR(part.pq.value(), expected[name][0].get<double>(), kSixDigits) << name;
    EXPECT_NEAR(part.sq.value(), expected[name][1].get<double>(), kSixDigits) << name;
    EXPECT_NEAR(part.rq.value(), expected[name][2].get<double>(), kSixDigits) << name;
  }
  for (const auto& [id, counts] : vector["P1"]["tp_fp_fn_iou"].items()) {
    const PqCounts& found = scores.counts[index_of.at(id)];
    EXPECT_EQ(Json({found.tp, found.fp, found.fn}), Json({counts[0], counts[1], counts[2]})) << id;
    EXPECT_NEAR(found.iou_sum, counts[3].get<double>(), kSixDigits) << id;
  }
}

}  // namespace
}  // namespace panoptic
