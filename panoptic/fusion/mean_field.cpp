// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/mean_field.h"

#include <algorithm>
#include <cmath>

#include "panoptic/base/clones.h"
#include "panoptic/base/error.h"
#include "panoptic/fusion/fast_exp.h"
#include "panoptic/fusion/lanes.h"

namespace panoptic {
namespace {

constexpr std::size_t kGrain = 2048;  // voxels that are worked together

RowWidth width_from(std::size_t first_label, std::size_t stride) {
  return stride - first_label >= 16 ? RowWidth::k16 : RowWidth::k8;
}

// Every voxel belongs to some sum of at least its own 1, so the root is of something positive.
float inverse_root(float sum) { return 1.0F / std::sqrt(sum); }

}  // namespace

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

// What one voxel's messages are made of: the kernels' sums, and how much of its own marginals they hold.
struct MessageParts {
  const float* color_sum;
  const float* grid_sum;
  float color_factor;  // w n
  float grid_factor;
  float own_factor;  // w1 n1 n1 + w2 n2 n2
};

void combine_8(const MessageParts& parts, float* row);
void combine_16(const MessageParts& parts, float* row);
void softmax_rows(float* rows, std::size_t count, std::span<const float> is_label);

template <int Width>
[[gnu::always_inline]] inline void combine(const MessageParts& parts, float* row) {
  for (int c = 0; c < Width; ++c) {
    row[c] = parts.color_factor * parts.color_sum[c] + parts.grid_factor * parts.grid_sum[c] - parts.own_factor * row[c];
  }
}

PANOPTIC_CLONES void combine_8(const MessageParts& parts, float* row) { combine<8>(parts, row); }
PANOPTIC_CLONES void combine_16(const MessageParts& parts, float* row) { combine<16>(parts, row); }

// Rows of logits to rows of probabilities; columns where is_label is 0 become 0. Eight sums side by side, in a fixed order.
PANOPTIC_CLONES
void softmax_rows(float* rows, std::size_t count, std::span<const float> is_label) {
  const std::size_t stride = is_label.size();
  for (std::size_t i = 0; i < count; ++i) {
    float* row = rows + i * stride;
    float most[kLanes];
    for (std::size_t c = 0; c < kLanes; ++c) most[c] = row[c];
    for (std::size_t g = kLanes; g < stride; g += kLanes) {
      for (std::size_t c = 0; c < kLanes; ++c) most[c] = row[g + c] > most[c] ? row[g + c] : most[c];
    }
    float highest = most[0];
    for (std::size_t c = 1; c < kLanes; ++c) highest = most[c] > highest ? most[c] : highest;
    float sums[kLanes] = {};
    for (std::size_t g = 0; g < stride; g += kLanes) {
      for (std::size_t c = 0; c < kLanes; ++c) {
        row[g + c] = is_label[g + c] * fast_exp(row[g + c] - highest);
        sums[c] += row[g + c];
      }
    }
    const float total = ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7]));
    const float share = 1.0F / total;
    for (std::size_t c = 0; c < stride; ++c) row[c] *= share;
  }
}

}  // namespace kernels

MeanField::MeanField(const CrfGraph& graph, const MeanFieldSettings& settings, Ranges ranges)
    : graph_(graph),
      settings_(settings),
      ranges_(ranges),
      grid_filter_(graph.points, settings.theta_alpha),
      color_filter_(graph.points, graph.colors, {settings.theta_alpha, settings.theta_beta}, ranges),
      color_norm_(graph.size()),
      grid_norm_(graph.size()),
      head_start_(graph.size()),
      stride_((graph.label_count + kLanes - 1) / kLanes * kLanes) {
  PANOPTIC_ASSERT(graph.size() > 0 && graph.label_count > 0 && graph.all_labels >= graph.label_count);
  const std::size_t count = graph.size();
  // The kernels' row sums: what the filters make of ones.
  rows_.assign(count * kLanes, 1.0F);
  grid_sums_.resize(count * kLanes);
  const ScaledRows ones{rows_.data(), kLanes, nullptr};
  grid_filter_.apply(ones, grid_sums_.data(), RowWidth::k8, grid_scratch_, ranges_);
  const float* color_sums = color_filter_.apply(ones, RowWidth::k8, color_scratch_, ranges_);
  for (std::size_t i = 0; i < count; ++i) {
    grid_norm_[i] = inverse_root(grid_sums_[i * kLanes]);
    color_norm_[i] = inverse_root(color_sums[color_filter_.cluster_of()[i] * kLanes]);
  }
  // In double: rounded to float it is the same whichever of its variants for this CPU the library takes.
  const double others = static_cast<double>(graph.all_labels) - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double p = graph.probabilities[i];
    head_start_[i] = others < 1 ? 0.0F : static_cast<float>(std::log(p * others / (1 - p)));
  }
  rows_.assign(count * stride_, 0.0F);
  normalise_rows();
}

void MeanField::iterate() {
  for (std::size_t label = 0; label < stride_;) {
    const RowWidth width = width_from(label, stride_);
    pass_messages(label, width);
    label += static_cast<std::size_t>(width);
  }
  normalise_rows();
}

// Marginals of some labels to their messages, in place: no label's message depends on another label.
void MeanField::pass_messages(std::size_t first_label, RowWidth row_width) {
  const auto width = static_cast<std::size_t>(row_width);
  grid_sums_.resize(std::max(grid_sums_.size(), graph_.size() * width));
  const float* q = rows_.data() + first_label;
  grid_filter_.apply({q, stride_, grid_norm_.data()}, grid_sums_.data(), row_width, grid_scratch_, ranges_);
  const float* color_sums = color_filter_.apply({q, stride_, color_norm_.data()}, row_width, color_scratch_, ranges_);
  const auto combine = row_width == RowWidth::k8 ? kernels::combine_8 : kernels::combine_16;
  ranges_.run(graph_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float color_factor = settings_.w1 * color_norm_[i];
      const float grid_factor = settings_.w2 * grid_norm_[i];
      combine({color_sums + color_filter_.cluster_of()[i] * width, grid_sums_.data() + i * width, color_factor, grid_factor,
               color_factor * color_norm_[i] + grid_factor * grid_norm_[i]},
              rows_.data() + i * stride_ + first_label);
    }
  });
}

void MeanField::normalise_rows() {
  std::vector<float> is_label(stride_, 0.0F);
  std::fill_n(is_label.begin(), graph_.label_count, 1.0F);
  ranges_.run(graph_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (graph_.labels[i] != CrfGraph::kOtherLabel) rows_[i * stride_ + graph_.labels[i]] += head_start_[i];
    }
    kernels::softmax_rows(rows_.data() + begin * stride_, end - begin, is_label);
  });
}

float MeanField::marginal(std::size_t voxel, std::size_t label) const { return rows_[voxel * stride_ + label]; }

MeanField::Best MeanField::best(std::size_t voxel) const {
  const float* row = rows_.data() + voxel * stride_;
  const float* most = std::max_element(row, row + graph_.label_count);
  return {static_cast<std::uint16_t>(most - row), *most};
}

std::size_t MeanField::memory_bytes() const {
  const std::size_t floats = 3 * graph_.size() + rows_.capacity() + grid_sums_.capacity() + grid_scratch_.rows.capacity() +
                             color_scratch_.sums.capacity() + color_scratch_.blurred.capacity();
  return floats * sizeof(float) + grid_filter_.memory_bytes() + color_filter_.memory_bytes();
}

}  // namespace panoptic
