// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Scores of a map, or of any method's labels, against ScanNet-style ground truth, as `panoptic eval` counts them
// (docs/evaluation.md). Scenes accumulate as the benchmarks do: counts are summed over the scenes and scores taken at the end,
// never a mean of scores.
//
//   Evaluation evaluation;
//   evaluation.add(read_run_folder("OUT"), read_scan_truth("scans/scene0001_00"));
//   const Scores scores = evaluation.scores();  // scores.panoptic.front().all.pq ...
//   std::fputs(to_table(scores).c_str(), stdout);
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/labels.h"
#include "panoptic/map.h"
#include "panoptic/mesh.h"
#include "panoptic/scan_truth.h"

namespace panoptic {

// One of the 20 classes of ScanNet's benchmark. Wall and floor are stuff, the other 18 are things.
struct BenchmarkClass {
  ClassId id = ClassId::kUnknown;  // NYU40 number
  std::string_view name;
  bool is_thing = true;
};
inline constexpr std::size_t kBenchmarkClassCount = 20;
// The classes, ascending by id. Scores by class are in this order.
const std::array<BenchmarkClass, kBenchmarkClassCount>& benchmark_classes();

// A map to be scored.
struct LabelledMap {
  Mesh mesh;
  LabelSet labels;
  std::map<PanopticId, double> confidence;  // of the objects; 1 where it is missing
  double voxel_size_m = 0;
};

// The map with its surface, and confidence in the objects that the surface shows. `warnings`, if given, hears of classes that
// NYU40 does not have.
LabelledMap labelled_map(const PanopticMap& map, Mesh mesh, std::vector<std::string>* warnings = nullptr);

// mesh.ply, objects.json and report.json of a run's folder. Throws Error naming the file; `warnings`, if given, hears of an
// incomplete run and of classes that NYU40 does not have.
LabelledMap read_run_folder(const std::filesystem::path& folder, std::vector<std::string>* warnings = nullptr);

// Labels for the vertices of a scan, one entry per vertex. A segment is all vertices that share both class and instance.
struct VertexLabels {
  std::vector<ClassId> class_id;        // NYU40 number; kUnknown = none
  std::vector<std::uint32_t> instance;  // which one; 0 = no identity

  bool operator==(const VertexLabels&) const = default;
};

// A prediction for the vertices of a scan.
struct LabelledVertices {
  VertexLabels labels;
  std::map<std::uint32_t, double> confidence;  // of an instance; 1 where it is missing
  std::vector<std::uint8_t> reached;           // 1 = the map has a surface there, labelled or not; empty = everywhere
};

// One predicted thing. Masks of one scene may overlap.
struct InstanceMask {
  ClassId class_id = ClassId::kUnknown;
  double confidence = 1;
  std::vector<std::uint32_t> vertices;  // ascending
};

// The part of the truth that the prediction reaches and labels.
struct Coverage {
  std::uint64_t vertices = 0;
  std::uint64_t annotated = 0;  // true class known
  std::uint64_t reached = 0;    // of those, near a surface of the map
  std::uint64_t labelled = 0;   // of those, given a class

  std::optional<double> coverage() const;  // labelled / annotated
};

struct ClassIou {
  std::uint64_t tp = 0;
  std::uint64_t fp = 0;
  std::uint64_t fn = 0;

  // The IoU; nothing if the class occurs neither in truth nor in predictions, 0 if only in predictions.
  std::optional<double> iou() const;
};

struct SemanticScores {
  std::optional<double> miou;  // over the defined classes
  std::array<ClassIou, kBenchmarkClassCount> classes;
};

// Average precisions; nothing where no scene has a true instance of 100 vertices or more.
struct ApScores {
  std::optional<double> ap;    // mean over the thresholds .50, .55, ... .90
  std::optional<double> ap50;  // IoU > .50
  std::optional<double> ap25;

  bool operator==(const ApScores&) const = default;
};

// Class-agnostic: truth is the instances of the 18 thing classes (wall and floor are not kept), predictions are all masks
// whatever their label.
struct InstanceScores {
  ApScores mean;                                       // over the classes that are defined
  ApScores class_agnostic;                             // the same count with one class for everything
  std::array<ApScores, kBenchmarkClassCount> classes;  // nothing for wall and floor
};

// Rules for how the vertices of a scan become segments, and which classes are averaged.
struct PqVariant {
  std::string name;                     // "pq-scannet20" (the default), "seed", "ndt", "coco": docs/evaluation.md
  std::size_t min_true_thing = 0;       // true things with less vertices become void
  std::size_t min_predicted_thing = 0;  // predicted things with less vertices become void
  bool merge_stuff = true;              // all of a stuff class is one segment, whatever its instance numbers
  bool average_true_only = false;       // leave classes without a true segment out of the averages
};

struct PqCounts {
  std::uint64_t tp = 0;
  std::uint64_t fp = 0;
  std::uint64_t fn = 0;
  double iou_sum = 0;  // over the matches
};

struct PqScores {
  std::optional<double> pq;  // nothing where there is nothing to count
  std::optional<double> sq;
  std::optional<double> rq;

  bool operator==(const PqScores&) const = default;
};

struct PanopticScores {
  PqVariant variant;
  PqScores all;  // means over the classes that count
  PqScores things;
  PqScores stuff;
  std::array<PqCounts, kBenchmarkClassCount> counts;
};

// Nothing without a surface of the truth; a map without any has missed all of it.
struct ThresholdScores {
  double threshold_m = 0;
  std::optional<double> precision;  // share of the map's points with the truth nearer than the threshold; nothing without points
  std::optional<double> recall;     // share of the truth's points with the map nearer
  std::optional<double> f_score;    // their harmonic mean
};

struct SurfaceScores {
  std::optional<double> accuracy_m;    // mean distance from the map's points to the truth; nothing without a surface
  std::optional<double> completion_m;  // mean distance from the truth's points to the map
  std::array<ThresholdScores, 2> at;   // 5 cm, 2.5 cm
};

// A part that was not evaluated is absent (panoptic: empty).
struct Scores {
  std::vector<std::string> scenes;
  Coverage coverage;
  std::optional<SemanticScores> semantic;
  std::optional<InstanceScores> instance;
  std::vector<PanopticScores> panoptic;  // the variant asked for, then the others
  std::optional<SurfaceScores> surface;
};

// A table of classes and means for a person, in percent, with the coverage and the rules of the count.
std::string to_table(const Scores& scores);

// The same for a program, as `panoptic eval --json` prints it but for its settings: fractions from 0 to 1, undefined is null.
std::string to_json_text(const Scores& scores);

// Not thread-safe.
class Evaluation {
 public:
  // Throws Error for an unknown variant.
  explicit Evaluation(const std::string& variant = "pq-scannet20");
  ~Evaluation();
  Evaluation(Evaluation&&) noexcept;
  Evaluation& operator=(Evaluation&&) noexcept;
  Evaluation(const Evaluation&) = delete;
  Evaluation& operator=(const Evaluation&) = delete;

  // Carries the map's labels to the vertices of the truth: each takes those of the map's nearest vertex, if that is within two
  // voxels. Adds them, and compares the surfaces too. Returns the labels, for a submission.
  LabelledVertices add(const LabelledMap& map, const ScanTruth& truth);

  // A prediction for the vertices of the truth: semantic, instance and panoptic scores. Throws Error naming the scene if the
  // numbers of vertices differ.
  void add(const LabelledVertices& prediction, const ScanTruth& truth);

  // One part alone, for predictions that have no more. `scene` is for messages; sizes are checked as above.
  void add_semantic(const std::string& scene, const VertexLabels& truth, const std::vector<ClassId>& prediction);
  void add_instances(const std::string& scene, const VertexLabels& truth, const std::vector<InstanceMask>& prediction);
  void add_panoptic(const std::string& scene, const VertexLabels& truth, const VertexLabels& prediction);

  Scores scores() const;

  // All counts so far as a text, for another process that counts scenes too, and their addition. Throws Error naming `origin` if
  // the text is no such one, or of other variants.
  std::string counts_text() const;
  void add_counts(const std::string& text, const std::string& origin);

 private:
  struct Counts;
  std::unique_ptr<Counts> counts_;
};

}  // namespace panoptic
