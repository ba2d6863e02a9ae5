// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <utility>

#include "panoptic/parallel.h"
#include "panoptic/predict/decoders.h"

namespace panoptic {
namespace {

// Between which two cells a pixel lies, and how far from the first.
struct Between {
  std::size_t first = 0;
  std::size_t second = 0;
  float share = 0;  // of the second
};

std::vector<Between> neighbours(int pixels, int cells, double cells_per_px) {
  std::vector<Between> result(static_cast<std::size_t>(pixels));
  for (int i = 0; i < pixels; ++i) {
    const double at = std::clamp((i + 0.5) * cells_per_px - 0.5, 0.0, static_cast<double>(cells - 1));
    const auto first = static_cast<std::size_t>(at);
    result[static_cast<std::size_t>(i)] = {first, std::min(first + 1, static_cast<std::size_t>(cells - 1)),
                                           static_cast<float>(at - static_cast<double>(first))};
  }
  return result;
}

// One value per class of the label set: the highest of those that it has.
ClassScores highest_per_class(ClassScores scores) {
  ClassScores result = {{}, scores.width, scores.height, scores.cells_per_px_x, scores.cells_per_px_y, {}};
  const std::vector<std::size_t> position = positions_of(scores.classes, result.classes);
  if (result.classes == scores.classes) return scores;
  const std::size_t from = scores.classes.size();
  const std::size_t to = result.classes.size();
  result.values.resize(scores.values.size() / from * to, 0.0F);
  for (std::size_t i = 0; i < scores.values.size(); ++i) {
    float& highest = result.values[i / from * to + position[i % from]];
    highest = std::max(highest, scores.values[i]);
  }
  return result;
}

// The first network's part of the mean, with room for the classes of all.
ClassScores with_classes_of_all(const std::vector<ClassScores>& networks, float part) {
  const ClassScores& first = networks[0];
  ClassScores all = {first.classes, first.width, first.height, first.cells_per_px_x, first.cells_per_px_y, {}};
  for (const ClassScores& network : networks) {
    for (const ClassId id : network.classes) {
      if (std::find(all.classes.begin(), all.classes.end(), id) == all.classes.end()) all.classes.push_back(id);
    }
  }
  const std::size_t from = first.classes.size();
  const std::size_t to = all.classes.size();
  const std::size_t cells = first.values.size() / from;
  all.values.resize(cells * to, 0.0F);
  for (std::size_t i = 0; i < cells; ++i) {
    for (std::size_t k = 0; k < from; ++k) all.values[i * to + k] = first.values[i * from + k] * part;
  }
  return all;
}

// Adds the part of a coarser network, between its cells, to each cell of the sum.
void add(const ClassScores& network, float part, ClassScores& sum) {
  std::vector<std::size_t> position;
  for (const ClassId id : network.classes) {
    position.push_back(static_cast<std::size_t>(std::find(sum.classes.begin(), sum.classes.end(), id) - sum.classes.begin()));
  }
  // Along an axis: network = (sum + 0.5) * ratio - 0.5, as for pixels.
  const std::vector<Between> columns = neighbours(sum.width, network.width, network.cells_per_px_x / sum.cells_per_px_x);
  const std::vector<Between> rows = neighbours(sum.height, network.height, network.cells_per_px_y / sum.cells_per_px_y);
  const std::size_t from = network.classes.size();
  const std::size_t to = sum.classes.size();
  const auto width = static_cast<std::size_t>(network.width);
  parallel_for(rows.size(), [&](std::size_t v) {
    const Between& y = rows[v];
    float* out = &sum.values[v * columns.size() * to];
    for (const Between& x : columns) {
      const float* const upper[2] = {&network.values[(y.first * width + x.first) * from],
                                     &network.values[(y.first * width + x.second) * from]};
      const float* const lower[2] = {&network.values[(y.second * width + x.first) * from],
                                     &network.values[(y.second * width + x.second) * from]};
      for (std::size_t k = 0; k < from; ++k) {
        const float above = upper[0][k] + (upper[1][k] - upper[0][k]) * x.share;
        const float below = lower[0][k] + (lower[1][k] - lower[0][k]) * x.share;
        out[position[k]] += (above + (below - above) * y.share) * part;
      }
      out += to;
    }
  });
}

// The position of the highest value, `count` if none is above 0.
std::size_t best_of(const float* values, std::size_t count) {
  const float* best = std::max_element(values, values + count);
  return *best > 0 ? static_cast<std::size_t>(best - values) : count;
}

std::vector<std::uint16_t> best_per_cell(const ClassScores& scores) {
  const std::size_t count = scores.classes.size();
  std::vector<std::uint16_t> best(scores.values.size() / count);
  for (std::size_t i = 0; i < best.size(); ++i) {
    best[i] = static_cast<std::uint16_t>(best_of(scores.values.data() + i * count, count));
  }
  return best;
}

// The position of the likeliest class between four cells.
std::size_t best_between(const float* const (&cells)[4], const float (&shares)[4], std::vector<float>& mixed) {
  for (std::size_t k = 0; k < mixed.size(); ++k) {
    mixed[k] = cells[0][k] * shares[0] + cells[1][k] * shares[1] + cells[2][k] * shares[2] + cells[3][k] * shares[3];
  }
  return best_of(mixed.data(), mixed.size());
}

}  // namespace

std::vector<std::size_t> positions_of(const std::vector<ClassId>& class_of, std::vector<ClassId>& classes) {
  classes = {ClassId::kUnknown};
  std::vector<std::size_t> result;
  for (const ClassId id : class_of) {
    const auto found = std::find(classes.begin(), classes.end(), id);
    result.push_back(static_cast<std::size_t>(found - classes.begin()));
    if (found == classes.end()) classes.push_back(id);
  }
  return result;
}

ClassScores average(std::vector<ClassScores> networks, float unknown_share) {
  if (networks.size() > 1) {
    for (ClassScores& network : networks) network = highest_per_class(std::move(network));
  }
  const auto finest = std::max_element(networks.begin(), networks.end(), [](const ClassScores& a, const ClassScores& b) {
    return a.width * a.height < b.width * b.height;
  });
  std::iter_swap(networks.begin(), finest);
  const float part = 1.0F / static_cast<float>(networks.size());
  ClassScores result = networks.size() == 1 ? std::move(networks[0]) : with_classes_of_all(networks, part);
  const std::size_t count = result.classes.size();
  for (std::size_t n = 1; n < networks.size(); ++n) add(networks[n], part, result);
  for (std::size_t k = 0; k < count; ++k) {
    if (result.classes[k] != ClassId::kUnknown) continue;
    for (std::size_t i = k; i < result.values.size(); i += count) result.values[i] *= unknown_share;
  }
  return result;
}

Image<ClassId> most_likely(const ClassScores& scores, int image_width, int image_height) {
  const std::vector<Between> columns = neighbours(image_width, scores.width, scores.cells_per_px_x);
  const std::vector<Between> rows = neighbours(image_height, scores.height, scores.cells_per_px_y);
  const std::vector<std::uint16_t> best = best_per_cell(scores);
  const std::size_t count = scores.classes.size();
  const auto width = static_cast<std::size_t>(scores.width);
  Image<ClassId> image(image_width, image_height);
  parallel_for(rows.size(), [&](std::size_t v) {
    const Between& y = rows[v];
    ClassId* out = image.row(static_cast<int>(v));
    std::vector<float> mixed(count);
    for (const Between& x : columns) {
      const std::size_t i[4] = {y.first * width + x.first, y.first * width + x.second, y.second * width + x.first,
                                y.second * width + x.second};
      std::size_t k = best[i[0]];
      // A class that leads in all four cells leads everywhere between them.
      if (best[i[1]] != k || best[i[2]] != k || best[i[3]] != k) {
        const float* const cells[4] = {&scores.values[i[0] * count], &scores.values[i[1] * count], &scores.values[i[2] * count],
                                       &scores.values[i[3] * count]};
        const float shares[4] = {(1 - y.share) * (1 - x.share), (1 - y.share) * x.share, y.share * (1 - x.share),
                                 y.share * x.share};
        k = best_between(cells, shares, mixed);
      }
      *out++ = k < count ? scores.classes[k] : ClassId::kUnknown;
    }
  });
  return image;
}

}  // namespace panoptic
