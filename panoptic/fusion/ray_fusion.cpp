// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/ray_fusion.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <memory>

#include "panoptic/base/clones.h"

namespace panoptic {

namespace kernels {

using Color [[gnu::vector_size(16)]] = float;  // red, green, blue and nothing
using ColorBits [[gnu::vector_size(16)]] = std::int32_t;

// A block turned round: all that one update touches lies side by side, since rays hit voxels one by one. Colours are whole
// numbers, as in the planes.
struct RayVoxel {
  float distance;
  float weight;
  float label_weight;
  float vote_sum;
  Color color;
  std::uint32_t label;
};

constexpr std::size_t kNoVoxel = kBlockVoxels;  // takes what must not change anything
struct RayVoxels {
  alignas(64) std::array<RayVoxel, kBlockVoxels + 1> at;
};

// Updates on their way to the voxels: the rays' passages one after the other, so that the loop over them is long and does not
// have to guess how long each passage is.
constexpr std::size_t kStep = 16;  // voxels of a passage at a time
constexpr std::size_t kBatch = 1024;
struct RayBatch {
  alignas(64) float distance[kBatch + kStep];
  alignas(64) float weight[kBatch + kStep];
  alignas(64) std::int32_t voxel[kBatch + kStep];
  alignas(64) std::int32_t ray[kBatch + kStep];
  std::size_t count;
};

// The observation of a ray's pixel.
struct RayWord {
  Color target;         // the colour as it is kept
  std::uint32_t color;  // 0 = none
  std::uint32_t label;
  float votes;
};

struct RayWords {
  std::array<RayWord, kBatch> of;  // at most one ray for each update
  std::size_t count;
};

// A ray as the kernel sees it, in voxels.
struct RayLine {
  float direction[3];
  float range;
  float depth;
  float weight;  // of the reading
};

// Values that all rays through a block have in common.
struct RayFrame {
  float origin[3];       // the camera
  float first_voxel[3];  // of the block
  RayBand band;
};

void turn_round(const VoxelBlock& block, RayVoxels& voxels);
void turn_back(const RayVoxels& voxels, bool labels_only, VoxelBlock& block);
void observe(const RayFrame& frame, const RayLine& line, const std::uint16_t* voxels, std::size_t count, RayBatch& batch);
void fuse_batch(const RayBatch& batch, const RayWords& words, float max_weight, RayVoxels& voxels);

void turn_round(const VoxelBlock& block, RayVoxels& voxels) {
  std::memset(voxels.at.data(), 0, sizeof voxels.at);
  for (int n = 0; n < kBlockBricks; ++n) {
    const Brick& brick = block.brick(n);
    int i = 0;
    for (std::uint64_t rest = brick.stored(); rest != 0; rest &= rest - 1, ++i) {
      const auto channel = [&](WordPlane plane) { return static_cast<float>(brick.plane(plane)[i]); };
      const auto value = [&](FloatPlane plane) { return brick.plane(plane)[i]; };
      voxels.at[static_cast<std::size_t>(offset_in_block(n, std::countr_zero(rest)))] =
          RayVoxel{value(FloatPlane::kDistance),
                   value(FloatPlane::kWeight),
                   value(FloatPlane::kLabelWeight),
                   value(FloatPlane::kVoteSum),
                   Color{channel(WordPlane::kRed), channel(WordPlane::kGreen), channel(WordPlane::kBlue)},
                   brick.plane(WordPlane::kLabel)[i]};
    }
  }
}

// The voxels of a brick that rays have observed; a bit each.
static std::uint64_t observed_in(const RayVoxels& voxels, int brick) {
  std::uint64_t bits = 0;
  for (int v = 0; v < kBrickVoxels; ++v) {
    const bool observed = voxels.at[static_cast<std::size_t>(offset_in_block(brick, v))].weight > 0;
    bits |= std::uint64_t{observed} << v;
  }
  return bits;
}

static void write_labels(const RayVoxel& voxel, Brick& brick, int i) {
  brick.plane(FloatPlane::kLabelWeight)[i] = voxel.label_weight;
  brick.plane(FloatPlane::kVoteSum)[i] = voxel.vote_sum;
  brick.plane(WordPlane::kLabel)[i] = static_cast<std::uint16_t>(voxel.label);
}

static void write_all(const RayVoxel& voxel, Brick& brick, int i) {
  brick.plane(FloatPlane::kDistance)[i] = voxel.distance;
  brick.plane(FloatPlane::kWeight)[i] = voxel.weight;
  brick.plane(WordPlane::kRed)[i] = static_cast<std::uint16_t>(voxel.color[0]);
  brick.plane(WordPlane::kGreen)[i] = static_cast<std::uint16_t>(voxel.color[1]);
  brick.plane(WordPlane::kBlue)[i] = static_cast<std::uint16_t>(voxel.color[2]);
  write_labels(voxel, brick, i);
}

void turn_back(const RayVoxels& voxels, bool labels_only, VoxelBlock& block) {
  const auto write = labels_only ? write_labels : write_all;
  for (int n = 0; n < kBlockBricks; ++n) {
    if (!labels_only) block.store(n, observed_in(voxels, n));
    Brick& brick = block.brick(n);
    int i = 0;
    for (std::uint64_t rest = brick.stored(); rest != 0; rest &= rest - 1, ++i) {
      write(voxels.at[static_cast<std::size_t>(offset_in_block(n, std::countr_zero(rest)))], brick, i);
    }
  }
}

// Distances and weights of a passage, always 16 at a time: what is too much is overwritten by the next. REQUIRES 16 voxels to
// be readable from each multiple of 16 on.
PANOPTIC_CLONES
void observe(const RayFrame& frame, const RayLine& line, const std::uint16_t* voxels, std::size_t count, RayBatch& batch) {
  const RayFrame f = frame;
  const RayLine ray = line;
  const Band band = f.band.band;
  for (std::size_t begin = 0; begin < count; begin += kStep) {
    const std::uint16_t* __restrict offset = voxels + begin;
    float* __restrict distances = batch.distance + batch.count;
    float* __restrict weights = batch.weight + batch.count;
    std::int32_t* __restrict targets = batch.voxel + batch.count;
    for (std::size_t k = 0; k < kStep; ++k) {
      const std::int32_t i = offset[k];
      const float x = f.first_voxel[0] + static_cast<float>(i & 15) + 0.5F - f.origin[0];
      const float y = f.first_voxel[1] + static_cast<float>(i >> 4 & 15) + 0.5F - f.origin[1];
      const float z = f.first_voxel[2] + static_cast<float>(i >> 8) + 0.5F - f.origin[2];
      const float along =
          (ray.range - (ray.direction[0] * x + (ray.direction[1] * y + ray.direction[2] * z))) * f.band.voxel_size_m;
      const float capped = along < band.truncation_m ? along : band.truncation_m;
      const float distance = capped > -band.truncation_m ? capped : -band.truncation_m;
      const float weight = observation_weight(ray.depth, distance, band) * ray.weight;
      distances[k] = distance;
      weights[k] = weight;
      targets[k] = weight > 0 ? i : static_cast<std::int32_t>(kNoVoxel);
    }
    batch.count += count - begin < kStep ? count - begin : kStep;
  }
}

[[gnu::always_inline]] static inline Color fused_colors(Color old, Color target, float share) {
  const Color shares = old == 0.0F ? Color{1, 1, 1, 1} : Color{share, share, share, share};
  const Color step = (target - old) * shares;  // as whole_step
  const Color up = step > 1.0F ? step : Color{1, 1, 1, 1};
  const Color down = step < -1.0F ? step : Color{-1, -1, -1, -1};
  const Color falls = step < 0.0F ? down : Color{0, 0, 0, 0};
  const Color mean = old + (step > 0.0F ? up : falls) + 0.5F;
  const Color at_least_one = mean > 1.0F ? mean : Color{1, 1, 1, 1};
  return __builtin_convertvector(__builtin_convertvector(at_least_one, ColorBits), Color);
}

PANOPTIC_CLONES
void fuse_batch(const RayBatch& batch, const RayWords& words, float max_weight, RayVoxels& voxels) {
  for (std::size_t k = 0; k < batch.count; ++k) {
    RayVoxel& voxel = voxels.at[static_cast<std::size_t>(batch.voxel[k])];
    const RayWord& word = words.of[static_cast<std::size_t>(batch.ray[k])];
    const float weight = batch.weight[k];
    const float old_weight = voxel.weight;
    voxel.distance = fused_distance(voxel.distance, old_weight, batch.distance[k], weight);
    voxel.weight = fused_weight(old_weight, weight, max_weight);
    if (word.color != 0) voxel.color = fused_colors(voxel.color, word.target, weight / (old_weight + weight));
    if (word.label != number(LabelSlot::kNoVote)) {
      const VoxelVotes old{{static_cast<std::uint16_t>(voxel.label), voxel.label_weight}, voxel.vote_sum};
      const VoxelVotes fused = fused_votes(old, static_cast<std::uint16_t>(word.label), weight * word.votes, max_weight);
      voxel.label = fused.label.label;
      voxel.label_weight = fused.label.weight;
      voxel.vote_sum = fused.sum;
    }
  }
}

}  // namespace kernels

namespace {

kernels::RayWord word_of(const KernelFrame& pixels, std::size_t pixel) {
  const std::uint32_t color = pixels.color[pixel];
  const std::uint16_t label = number(pixels.label[pixel]);
  const auto kept = [color](int shift) { return static_cast<float>(color >> shift & 0xFFU) * 256.0F; };
  const kernels::Color target = {kept(16), kept(8), kept(0), 0};
  return {target, color, label, pixels.votes.of(label)};
}

// Passages of one list after the other, and the updates that have come together so far.
class PassageFuser {
 public:
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): the buffers are filled as far as they are read
  PassageFuser(const FrameView& view, const RayTable& rays, const kernels::RayFrame& frame, kernels::RayVoxels& voxels)
      : view_(view), rays_(rays), frame_(frame), voxels_(voxels) {
    batch_.count = 0;
    words_.count = 0;
  }

  void add(Passages list) {
    for (std::size_t at = 0; at < list.size();) {
      const std::size_t pixel = list[at] | std::size_t{list[at + 1]} << 16;
      const std::size_t count = list[at + 2];
      add_passage(pixel, list.subspan(at + kPassageHead), count);
      at += kPassageHead + count;
    }
  }

  void flush() {
    kernels::fuse_batch(batch_, words_, view_.pixels.max_weight, voxels_);
    batch_.count = 0;
    words_.count = 0;
  }

 private:
  void add_passage(std::size_t pixel, Passages rest, std::size_t count) {
    if (batch_.count + count > kernels::kBatch) flush();
    kernels::RayLine line{};
    for (std::size_t a = 0; a < 3; ++a) line.direction[a] = rays_.direction[a][pixel];
    line.range = rays_.range[pixel];
    line.depth = view_.pixels.depth[pixel];
    line.weight = view_.pixels.depth_weight == nullptr ? 1.0F : view_.pixels.depth_weight[pixel];
    const auto word = static_cast<std::int32_t>(words_.count);
    for (std::size_t begin = 0; begin < count; begin += kernels::kStep) {
      std::fill_n(batch_.ray + batch_.count + begin, kernels::kStep, word);
    }
    words_.of[words_.count++] = word_of(view_.pixels, pixel);
    if (rest.size() >= kMostVoxels) {
      kernels::observe(frame_, line, rest.data(), count, batch_);
    } else {  // the kernel reads further than the list goes
      std::array<std::uint16_t, kMostVoxels> voxels{};
      std::copy_n(rest.begin(), count, voxels.begin());
      kernels::observe(frame_, line, voxels.data(), count, batch_);
    }
  }

  const FrameView& view_;
  const RayTable& rays_;
  const kernels::RayFrame& frame_;
  kernels::RayVoxels& voxels_;
  kernels::RayBatch batch_;
  kernels::RayWords words_;
};

}  // namespace

void fuse_passages(const FrameView& view, const RayTable& rays, const RayBand& band, std::span<const Passages> lists,
                   const RayTarget& target) {
  kernels::RayFrame frame{{}, {}, band};
  const Vec3f origin = camera_in_voxels(view, band.voxel_size_m);
  for (int a = 0; a < 3; ++a) {
    frame.origin[a] = origin[a];
    frame.first_voxel[a] = target.first_voxel[a];
  }
  const auto voxels = std::make_unique_for_overwrite<kernels::RayVoxels>();
  kernels::turn_round(target.block, *voxels);
  PassageFuser fuser(view, rays, frame, *voxels);
  for (const Passages list : lists) fuser.add(list);
  fuser.flush();
  kernels::turn_back(*voxels, view.pixels.labels_only, target.block);
}

}  // namespace panoptic
