// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/id_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "panoptic/data/nyu40.h"
#include "panoptic/error.h"
#include "panoptic/eval/benchmark_classes.h"
#include "panoptic/eval/nearest_points.h"

namespace panoptic {
namespace {

std::string ids_notice(const std::string& scene, const char* what, const std::vector<ClassId>& classes) {
  std::size_t labelled = 0;
  std::size_t foreign = 0;
  ClassId example{};
  for (const ClassId id : classes) {
    if (id == ClassId::kUnknown) continue;
    ++labelled;
    if (number(id) <= kNyu40Classes) continue;
    if (foreign++ == 0) example = id;
  }
  if (labelled == 0) {
    return fmt::format(
        "{}: the {} names no class; is it in another form? semantic takes NYU40's ids, instance and panoptic class * "
        "1000 + instance",
        scene, what);
  }
  if (2 * foreign < labelled) return {};
  return fmt::format(
      "{}: most ids of the {} are above 40, {} for one; the semantic form takes NYU40's ids, class * 1000 + instance "
      "is that of eval instance and eval panoptic",
      scene, what, number(example));
}

std::size_t agreement(const std::vector<ClassId>& truth, const std::vector<ClassId>& prediction, IdSpace space) {
  std::size_t count = 0;
  for (std::size_t v = 0; v < truth.size(); ++v) {
    const bool counts = benchmark_index(truth[v]).has_value();
    count += counts && class_in(number(prediction[v]), space) == truth[v] ? 1 : 0;
  }
  return count;
}

double extent_m(const std::vector<Vec3f>& points) {
  Eigen::AlignedBox3f box;
  for (const Vec3f& point : points) box.extend(point);
  return box.isEmpty() ? 0 : static_cast<double>(box.diagonal().norm());
}

}  // namespace

IdSpace id_space_of(const std::string& name) {
  if (name == "nyu40") return IdSpace::kNyu40;
  if (name == "scannet20") return IdSpace::kScannet20;
  if (name == "train") return IdSpace::kTrain;
  throw Error(fmt::format("'{}' is no id space; there are nyu40, scannet20 (1 to 20) and train (0 to 19)", name));
}

ClassId class_in(std::int64_t id, IdSpace space) {
  if (space == IdSpace::kNyu40) {
    const bool fits = id > 0 && id <= std::numeric_limits<std::uint16_t>::max();
    return fits ? static_cast<ClassId>(id) : ClassId::kUnknown;
  }
  const std::int64_t index = space == IdSpace::kScannet20 ? id - 1 : id;
  const bool fits = index >= 0 && index < static_cast<std::int64_t>(kBenchmarkClassCount);
  return fits ? benchmark_classes().at(static_cast<std::size_t>(index)).id : ClassId::kUnknown;
}

std::vector<std::string> label_notices(const std::string& scene, const std::vector<ClassId>& truth,
                                       const std::vector<ClassId>& prediction) {
  std::vector<std::string> notices;
  for (std::string notice : {ids_notice(scene, "ground truth", truth), ids_notice(scene, "prediction", prediction)}) {
    if (!notice.empty()) notices.push_back(std::move(notice));
  }
  if (!notices.empty() || truth.size() != prediction.size()) return notices;
  const auto counted = std::count_if(truth.begin(), truth.end(), [](ClassId id) { return benchmark_index(id).has_value(); });
  const std::size_t as_read = agreement(truth, prediction, IdSpace::kNyu40);
  constexpr double kClearly = 0.005;  // of the vertices: correct NYU40 ids never agree better by chance
  for (const auto& [space, name] : {std::pair{IdSpace::kScannet20, "scannet20"}, std::pair{IdSpace::kTrain, "train"}}) {
    const std::size_t other = agreement(truth, prediction, space);
    if (static_cast<double>(other) <= static_cast<double>(as_read) + kClearly * static_cast<double>(counted)) continue;
    const auto percent = [&](std::size_t n) { return 100 * static_cast<double>(n) / static_cast<double>(counted); };
    notices.push_back(
        fmt::format("{}: these may be no NYU40 ids: {:.1f} % of the vertices agree with the truth, {:.1f} % with "
                    "--id-space {}",
                    scene, percent(as_read), percent(other), name));
  }
  return notices;
}

std::string place_notice(const LabelledMap& map, const ScanTruth& truth) {
  constexpr std::size_t kMostAsked = 20000;
  constexpr double kNear_m = 0.1;
  constexpr double kMilli = 1000;
  if (map.mesh.vertices.empty() || truth.positions.empty()) return {};
  const NearestPoints nearest(truth.positions);
  const std::size_t step = map.mesh.vertices.size() / kMostAsked + 1;
  std::vector<Vec3f> positions;
  std::size_t near = 0;
  for (std::size_t v = 0; v < map.mesh.vertices.size(); v += step) {
    positions.push_back(map.mesh.vertices[v].position);
    near += nearest.nearest(positions.back())->distance_m < kNear_m ? 1 : 0;
  }
  if (3 * near >= positions.size()) return {};
  const double ratio = extent_m(truth.positions) / std::max(extent_m(positions), 1e-9);
  const bool in_millimetres = ratio > kMilli / 10;
  return fmt::format(
      "{}: only {:.0f} % of the map lies within 10 cm of the ground truth; {}", truth.scene,
      100 * static_cast<double>(near) / static_cast<double>(positions.size()),
      in_millimetres ? "is the truth in millimetres?" : "is the truth of another place, or in other axes (axis-aligned mesh)?");
}

}  // namespace panoptic
