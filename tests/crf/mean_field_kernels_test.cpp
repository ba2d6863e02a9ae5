// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/mean_field_kernels.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

#include "tests/crf/crf_graphs.h"

namespace panoptic {
namespace {

constexpr std::size_t kVoxels = 100;

std::vector<float> random_floats(std::size_t count, std::mt19937& random) {
  std::vector<float> floats(count);
  for (float& value : floats) value = test::share(random);
  return floats;
}

// Marginals from random sums, in one pass or in two.
std::vector<float> marginals(std::size_t width, float absent, bool at_once) {
  std::mt19937 random(7);
  std::vector<std::uint32_t> voxels(kVoxels);
  std::iota(voxels.begin(), voxels.end(), 0U);
  std::vector<float> rows = random_floats(kVoxels * width, random);
  const std::vector<float> grid = random_floats(kVoxels * width, random);
  const std::vector<float> color = random_floats(kVoxels * width, random);
  const std::vector<float> norms = random_floats(kVoxels, random);
  const std::vector<float> head_start = random_floats(kVoxels, random);
  std::vector<std::int32_t> own_column(kVoxels);
  for (std::int32_t& column : own_column) column = static_cast<std::int32_t>(random() % (width - 2)) - 1;
  std::vector<float> is_label(width, 1.0F);
  is_label[width - 1] = is_label[width - 2] = 0;
  std::vector<ColumnGroup> groups;
  for (std::size_t c = 0; c < width; c += 8) groups.push_back({rows.data() + c, width, 8, is_label.data() + c});
  const kernels::MessageWork messages{voxels,       grid.data(), color.data(), voxels.data(), norms.data(),
                                      norms.data(), 10,          15,           rows.data()};
  const kernels::MarginalWork work{groups, own_column.data(), head_start.data(), absent};
  if (at_once) {
    kernels::renew_rows(messages, work, static_cast<RowWidth>(width));
  } else {
    kernels::combine_rows(messages, static_cast<RowWidth>(width));
    kernels::softmax_rows(work, voxels);
  }
  return rows;
}

TEST(MeanFieldKernels, GiveTheSameBitsInOnePassAsInTwo) {
  for (const std::size_t width : {8U, 16U, 24U, 32U}) {
    for (const float absent : {0.0F, 5.0F}) EXPECT_EQ(marginals(width, absent, true), marginals(width, absent, false)) << width;
  }
}

TEST(MeanFieldKernels, TheDifferencesFromAbsentLabelsAndThoseMakeUpOne) {
  constexpr std::size_t kWidth = 16;
  const std::vector<float> differences = marginals(kWidth, 5, true);
  const std::vector<float> whole = marginals(kWidth, 0, true);
  for (std::size_t i = 0; i < kVoxels; ++i) {
    const auto row = differences.begin() + static_cast<std::ptrdiff_t>(i * kWidth);
    const double level = (1 - std::accumulate(row, row + kWidth, 0.0)) / (kWidth - 2 + 5);
    // Without the five, what is left is shared in the same proportions.
    for (std::size_t c = 0; c < kWidth - 2; ++c) {
      EXPECT_NEAR(whole[i * kWidth + c] * (1 - 5 * level), differences[i * kWidth + c] + level, 1e-6);
    }
    EXPECT_EQ(row[kWidth - 1], 0.0F);
  }
}

}  // namespace
}  // namespace panoptic
