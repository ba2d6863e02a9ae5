// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Graphs for the CRF, and mean field by its definition: every pair of voxels, in double.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "panoptic/crf/mean_field.h"

namespace panoptic::test {

// marginals[voxel][label]
inline std::vector<std::vector<double>> naive_mean_field(const CrfGraph& g, const MeanFieldSettings& s, int iterations) {
  const std::size_t n = g.size();
  std::vector<std::vector<double>> k1(n, std::vector<double>(n));
  std::vector<std::vector<double>> k2 = k1;
  std::vector<double> n1(n, 0);
  std::vector<double> n2(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const GridPoint& a = g.points[i];
      const GridPoint& b = g.points[j];
      const double distance = std::pow(a.x - b.x, 2) + std::pow(a.y - b.y, 2) + std::pow(a.z - b.z, 2);
      double color = 0;
      for (std::size_t c = 0; c < 3; ++c) color += std::pow(g.colors[i][c] - g.colors[j][c], 2);
      k2[i][j] = std::exp(-distance / (2.0 * s.theta_alpha * s.theta_alpha));
      k1[i][j] = k2[i][j] * std::exp(-color / (2.0 * s.theta_beta * s.theta_beta));
      n1[i] += k1[i][j];
      n2[i] += k2[i][j];
    }
  }
  std::vector<std::vector<double>> weight(n, std::vector<double>(n, 0.0));  // none of a voxel to itself
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      if (i == j) continue;
      weight[i][j] = s.w1 * k1[i][j] / std::sqrt(n1[i] * n1[j]) + s.w2 * k2[i][j] / std::sqrt(n2[i] * n2[j]);
    }
  }
  std::vector<std::vector<double>> messages(n, std::vector<double>(g.label_count, 0.0));
  std::vector<std::vector<double>> q = messages;
  for (int t = 0; t <= iterations; ++t) {
    for (std::size_t i = 0; i < n; ++i) {
      double sum = 0;
      for (std::size_t l = 0; l < g.label_count; ++l) {
        const double p =
            l == g.labels[i] ? g.probabilities[i] : (1 - double{g.probabilities[i]}) / (static_cast<double>(g.all_labels) - 1);
        sum += q[i][l] = p * std::exp(messages[i][l]);
      }
      for (double& value : q[i]) value /= sum;
    }
    for (std::size_t i = 0; i < n && t < iterations; ++i) {
      std::fill(messages[i].begin(), messages[i].end(), 0.0);
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t l = 0; l < g.label_count; ++l) messages[i][l] += weight[i][j] * q[j][l];
      }
    }
  }
  return q;
}

inline std::size_t argmax(const std::vector<double>& row) {
  return static_cast<std::size_t>(std::max_element(row.begin(), row.end()) - row.begin());
}

// A number in [0, 1) of known algorithm.
inline float share(std::mt19937& random) { return static_cast<float>(random() >> 8) / 16777216.0F; }

inline void sort_points(std::vector<GridPoint>& points) {
  std::sort(points.begin(), points.end(),
            [](const GridPoint& a, const GridPoint& b) { return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x); });
}

// Voxels of a cube of that side, each with that probability; labels, colours and certainty at random.
inline CrfGraph random_graph(int side, float density, std::size_t labels, unsigned seed) {
  std::mt19937 random(seed);
  CrfGraph g;
  g.label_count = g.all_labels = labels;
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        if (share(random) >= density) continue;
        g.points.push_back({x - side / 2, y - 7, z + 100});
        g.colors.push_back({255 * share(random), 255 * share(random), 255 * share(random)});
        g.labels.push_back(static_cast<std::uint16_t>(random() % labels));
        g.probabilities.push_back(0.5F + 0.49F * share(random));
      }
    }
  }
  return g;
}

// A wavy sheet, `thickness` voxels thick, of patches with one label and colour each; a fifth of the voxels (`noise`) has any
// label, colours vary a little.
struct Sheet {
  int side = 60;
  int thickness = 8;
  int patch = 15;
  std::size_t labels = 20;
  float noise = 0.2F;
};

inline CrfGraph sheet_graph(const Sheet& sheet, unsigned seed) {
  std::mt19937 random(seed);
  CrfGraph g;
  g.label_count = g.all_labels = sheet.labels;
  for (int y = 0; y < sheet.side; ++y) {
    for (int x = 0; x < sheet.side; ++x) {
      const int height = static_cast<int>(std::lround(0.35 * x + 6 * std::sin(0.11 * y)));
      for (int d = 0; d < sheet.thickness; ++d) g.points.push_back({x, y, height + d});
    }
  }
  sort_points(g.points);
  for (const GridPoint& p : g.points) {
    const int patch = p.x / sheet.patch * 7 + p.y / sheet.patch * 3;
    const bool noisy = share(random) < sheet.noise;
    g.labels.push_back(static_cast<std::uint16_t>((noisy ? random() : static_cast<unsigned>(patch)) % sheet.labels));
    g.probabilities.push_back(noisy ? 0.5F + 0.2F * share(random) : 0.55F + 0.4F * share(random));
    VoxelColor color{};
    for (int c = 0; c < 3; ++c) {
      color[static_cast<std::size_t>(c)] = static_cast<float>(40 + (patch * (37 + 20 * c)) % 180) + 12 * share(random);
    }
    g.colors.push_back(color);
  }
  return g;
}

// A long beam along x, of patches with one label and colour each; a tenth of the voxels has the label of the next patch.
struct Strip {
  int length = 260;
  int side = 2;
  int patch = 13;
  std::size_t labels = 20;
};

inline CrfGraph strip_graph(const Strip& strip, unsigned seed) {
  std::mt19937 random(seed);
  CrfGraph g;
  g.label_count = g.all_labels = strip.labels;
  for (int i = 0; i < strip.side * strip.side * strip.length; ++i) {
    const int row = i / strip.length;
    g.points.push_back({i % strip.length, row % strip.side, row / strip.side});
    const int patch = i % strip.length / strip.patch;
    const int next = share(random) < 0.1F ? 1 : 0;
    g.labels.push_back(static_cast<std::uint16_t>(static_cast<std::size_t>(patch + next) % strip.labels));
    const auto level = static_cast<float>(patch * 37 % 200);
    g.colors.push_back({level + 10 * share(random), 100 + 10 * share(random), 200 - level + 10 * share(random)});
    g.probabilities.push_back(0.5F + 0.4F * share(random));
  }
  return g;
}

}  // namespace panoptic::test
