// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/id_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "panoptic/base/nearest_points.h"
#include "panoptic/data/nyu40.h"
#include "panoptic/error.h"
#include "panoptic/eval/benchmark_classes.h"

namespace panoptic {
namespace {

constexpr std::int64_t kPerClass = 1000;

// Numbers that stand for no label in other people's files.
bool is_none(std::int64_t id, IdSpace space) {
  return id < 0 || (id == 0 && space != IdSpace::kTrain) || id == 255 || id == 65535;
}

bool is_class(std::int64_t id, IdSpace space) {
  const ClassId c = class_in(id, space);
  return c != ClassId::kUnknown && number(c) <= kNyu40Classes;
}

// Numbers that stand for something, and those of them that do not fit.
struct Misfits {
  std::size_t labelled = 0;
  std::size_t count = 0;
  std::int64_t example = 0;  // the first

  bool are_most() const { return 2 * count > labelled; }
};

template <typename Fits>
Misfits misfits(const std::vector<std::int64_t>& numbers, IdSpace space, const Fits& fits) {
  Misfits result;
  for (const std::int64_t id : numbers) {
    if (is_none(id, space)) continue;
    ++result.labelled;
    if (fits(id)) continue;
    if (result.count++ == 0) result.example = id;
  }
  return result;
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

// The share of a sample of points that lie within 10 cm of the others.
double share_near(const std::vector<Vec3f>& points, const std::vector<Vec3f>& others) {
  constexpr std::size_t kMostAsked = 20000;
  constexpr double kNear_m = 0.1;
  const NearestPoints nearest(others);
  const std::size_t step = points.size() / kMostAsked + 1;
  std::size_t asked = 0;
  std::size_t near = 0;
  for (std::size_t i = 0; i < points.size(); i += step) {
    ++asked;
    near += nearest.nearest(points[i])->distance_m < kNear_m ? 1 : 0;
  }
  return static_cast<double>(near) / static_cast<double>(asked);
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

void require_classes(const std::filesystem::path& file, const std::vector<std::int64_t>& numbers, IdSpace space) {
  const Misfits foreign = misfits(numbers, space, [&](std::int64_t id) { return is_class(id, space); });
  if (!foreign.are_most()) return;
  throw Error(fmt::format(
      "{}: {} of {} labels are no class, {} for one; {}", file.string(), foreign.count, foreign.labelled, foreign.example,
      space != IdSpace::kNyu40       ? "is --id-space right?"
      : foreign.example >= kPerClass ? "class * 1000 + instance is the form of eval instance and eval panoptic, and eval "
                                       "semantic takes NYU40's ids, 1 to 40"
                                     : "NYU40's ids are 1 to 40"));
}

void require_class_and_instance(const std::filesystem::path& file, const std::vector<std::int64_t>& numbers) {
  const Misfits small = misfits(numbers, IdSpace::kNyu40, [](std::int64_t id) { return id >= kPerClass; });
  if (!small.are_most()) return;
  throw Error(
      fmt::format("{}: {} of {} labels are below 1000, {} for one; instance and panoptic labels are class * 1000 + instance, "
                  "and class numbers alone are the form of eval semantic",
                  file.string(), small.count, small.labelled, small.example));
}

void require_stuff(const std::string& scene, const std::vector<ClassId>& truth, const std::vector<ClassId>& prediction) {
  const auto is_stuff = [](ClassId id) { return benchmark_index(id).has_value() && !is_benchmark_thing(id); };
  if (std::any_of(truth.begin(), truth.end(), is_stuff) || std::none_of(prediction.begin(), prediction.end(), is_stuff)) return;
  throw Error(fmt::format(
      "{}: the ground truth has neither wall nor floor, and the prediction has: is it the truth of instances alone? That "
      "is for eval instance",
      scene));
}

std::vector<std::string> label_notices(const std::string& scene, const std::vector<ClassId>& truth,
                                       const std::vector<ClassId>& prediction) {
  std::vector<std::string> notices;
  if (std::all_of(prediction.begin(), prediction.end(), [](ClassId id) { return id == ClassId::kUnknown; }))
    notices.push_back(fmt::format("{}: the prediction names no class", scene));
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
  constexpr double kMilli = 1000;
  if (map.mesh.vertices.empty() || truth.positions.empty()) return {};
  std::vector<Vec3f> positions;
  positions.reserve(map.mesh.vertices.size());
  for (const MeshVertex& vertex : map.mesh.vertices) positions.push_back(vertex.position);
  const double of_map = share_near(positions, truth.positions);
  if (3 * of_map >= 1 || 3 * share_near(truth.positions, positions) >= 1) return {};
  const double ratio = extent_m(truth.positions) / std::max(extent_m(positions), 1e-9);
  const bool in_millimetres = ratio > kMilli / 10;
  return fmt::format(
      "{}: only {:.0f} % of the map lies within 10 cm of the ground truth; {}", truth.scene, 100 * of_map,
      in_millimetres ? "is the truth in millimetres?" : "is the truth of another place, or in other axes (axis-aligned mesh)?");
}

}  // namespace panoptic
