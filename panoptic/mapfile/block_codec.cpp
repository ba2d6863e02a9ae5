// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/block_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

namespace panoptic {
namespace {

constexpr std::size_t kMaskBytes = kBlockVoxels / 8;
constexpr std::size_t kMostBytesPerVoxel = 26;
constexpr std::size_t kMostBytes = kMaskBytes + kMostBytesPerVoxel * kBlockVoxels;

// How the sum of votes is told from the weight, and the label weight from both. Format 1 knows no kVotes.
enum WeightCode : std::uint8_t { kSame, kFourfold, kZero, kOther, kVotes };

using HeldVoxels = std::vector<std::uint16_t>;  // ascending
using Mask = std::array<std::uint8_t, kBlockVoxels>;

// Floats as integers in the same order, so that near values have near numbers.
std::uint32_t ordered(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return (bits >> 31) != 0 ? ~bits : bits | 0x80000000U;
}
float unordered(std::uint32_t number) { return std::bit_cast<float>((number >> 31) != 0 ? number & 0x7FFFFFFFU : ~number); }

// The ordered bits of a prediction, whose zero may come with either sign, as the compiler likes.
std::uint32_t ordered_prediction(float value) {
  return (std::bit_cast<std::uint32_t>(value) << 1) == 0 ? ordered(0.0F) : ordered(value);
}

// Small differences of either sign as small numbers.
std::uint32_t folded(std::uint32_t difference) { return difference << 1 ^ (difference >> 31 != 0 ? ~0U : 0U); }
std::uint32_t unfolded(std::uint32_t number) { return number >> 1 ^ ((number & 1) != 0 ? ~0U : 0U); }
std::uint16_t folded16(int difference) {
  const auto bits = static_cast<std::uint16_t>(difference);
  return static_cast<std::uint16_t>(bits << 1 ^ (bits >> 15 != 0 ? 0xFFFF : 0));
}
int unfolded16(std::uint16_t number) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(number >> 1 ^ ((number & 1) != 0 ? 0xFFFF : 0)));
}

// Predicts a voxel of a plane from the voxels before it: the plane through three neighbours in each of the three directions,
// averaged; where no such three are held, the mean of the direct neighbours, else the voxel before.
class Predictor {
 public:
  explicit Predictor(const Mask& held) : held_(held) {}

  template <typename Plane>
  float predict(const Plane& plane, std::size_t v, float before) const {
    const bool x = v % kBlockSide != 0 && held_[v - kX] != 0;
    const bool y = v / kBlockSide % kBlockSide != 0 && held_[v - kY] != 0;
    const bool z = v >= kZ && held_[v - kZ] != 0;
    const auto at = [&](std::size_t back) { return static_cast<float>(plane[v - back]); };
    float sum = 0;
    float count = 0;
    const auto add = [&](bool all, std::size_t a, std::size_t b) {
      if (!all || held_[v - a - b] == 0) return;
      sum += at(a) + at(b) - at(a + b);
      count += 1;
    };
    add(x && y, kX, kY);
    add(x && z, kX, kZ);
    add(y && z, kY, kZ);
    if (count > 0) return sum / count;
    for (const auto& [is_held, back] : {std::pair(x, kX), std::pair(y, kY), std::pair(z, kZ)}) {
      if (!is_held) continue;
      sum += at(back);
      count += 1;
    }
    return count > 0 ? sum / count : before;
  }

 private:
  static constexpr std::size_t kX = 1;
  static constexpr std::size_t kY = kBlockSide;
  static constexpr std::size_t kZ = kBlockSide * kBlockSide;
  const Mask& held_;
};

int rounded_color(float predicted) { return static_cast<int>(std::clamp(predicted, 0.0F, 65535.0F)); }

// Writes planes of bytes into the payload: first all lowest bytes of a property, then the next ones.
class PayloadWriter {
 public:
  PayloadWriter(Bytes& payload, std::size_t count) : payload_(payload), count_(count) {}

  template <typename Number>
  void begin() {
    base_ = payload_.size();
    payload_.resize(base_ + sizeof(Number) * count_);
    for (std::size_t k = 0; k < sizeof(Number); ++k) parts_.emplace_back(base_ + k * count_, count_);
  }
  template <typename Number>
  void put(std::size_t i, Number value) {
    for (std::size_t k = 0; k < sizeof(Number); ++k) {
      payload_[base_ + k * count_ + i] = static_cast<std::uint8_t>(value >> (8 * k));
    }
  }
  // Sets how many numbers the next planes have.
  void resize(std::size_t count) { count_ = count; }
  void add_part(std::size_t begin, std::size_t size) { parts_.emplace_back(begin, size); }

  std::vector<std::span<const std::uint8_t>> parts() const {
    std::vector<std::span<const std::uint8_t>> all;
    for (const auto& [begin, size] : parts_) all.emplace_back(std::span(payload_).subspan(begin, size));
    return all;
  }

 private:
  Bytes& payload_;
  std::size_t count_;
  std::size_t base_ = 0;
  std::vector<std::pair<std::size_t, std::size_t>> parts_;
};

class PayloadReader {
 public:
  PayloadReader(std::span<const std::uint8_t> payload, std::size_t begin, std::size_t count)
      : payload_(payload), count_(count), next_(begin) {}

  // False if the payload ends before.
  template <typename Number>
  bool begin() {
    base_ = next_;
    next_ += sizeof(Number) * count_;
    return next_ <= payload_.size();
  }
  template <typename Number>
  Number take(std::size_t i) const {
    Number value = 0;
    for (std::size_t k = 0; k < sizeof(Number); ++k) {
      value = static_cast<Number>(value | Number{payload_[base_ + k * count_ + i]} << (8 * k));
    }
    return value;
  }
  void resize(std::size_t count) { count_ = count; }
  bool at_end() const { return next_ == payload_.size(); }

 private:
  std::span<const std::uint8_t> payload_;
  std::size_t count_;
  std::size_t base_ = 0;
  std::size_t next_;
};

HeldVoxels held_voxels(const BlockPlanes& b, Mask& mask) {
  HeldVoxels held;
  held.reserve(kBlockVoxels);
  for (std::size_t v = 0; v < kBlockVoxels; ++v) {
    const std::uint32_t floats = std::bit_cast<std::uint32_t>(b.distance[v]) | std::bit_cast<std::uint32_t>(b.weight[v]) |
                                 std::bit_cast<std::uint32_t>(b.label_weight[v]) | std::bit_cast<std::uint32_t>(b.vote_sum[v]);
    mask[v] = (floats | b.label[v] | b.red[v] | b.green[v] | b.blue[v]) != 0 ? 1 : 0;
    if (mask[v] != 0) held.push_back(static_cast<std::uint16_t>(v));
  }
  return held;
}

WeightCode code_of(float value, float weight) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  if (bits == std::bit_cast<std::uint32_t>(weight)) return kSame;
  if (bits == std::bit_cast<std::uint32_t>(4 * weight)) return kFourfold;  // the vote of an object, by default
  return bits == 0 ? kZero : kOther;
}

WeightCode code_of(float label_weight, float weight, float vote_sum) {
  const WeightCode code = code_of(label_weight, weight);
  return code == kOther && std::bit_cast<std::uint32_t>(label_weight) == std::bit_cast<std::uint32_t>(vote_sum) ? kVotes : code;
}

// The value that a code stands for; values of kOther are stored elsewhere.
float value_of(std::uint8_t code, float weight, float vote_sum) {
  switch (code) {
    case kSame:
      return weight;
    case kFourfold:
      return 4 * weight;
    case kVotes:
      return vote_sum;
    default:
      return 0;
  }
}

void put_floats(const std::array<float, kBlockVoxels>& plane, const HeldVoxels& held, const Predictor& predictor,
                PayloadWriter& out) {
  out.begin<std::uint32_t>();
  float before = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const float value = plane[held[i]];
    out.put(i, folded(ordered(value) - ordered_prediction(predictor.predict(plane, held[i], before))));
    before = value;
  }
}

// Red and blue mostly differ from what is predicted as green does.
void put_colors(const BlockPlanes& block, const HeldVoxels& held, const Predictor& predictor, PayloadWriter& out) {
  std::vector<int> green_error(held.size(), 0);
  for (const auto* plane : {&block.green, &block.red, &block.blue}) {
    out.begin<std::uint16_t>();
    float before = 0;
    for (std::size_t i = 0; i < held.size(); ++i) {
      const int value = (*plane)[held[i]];
      const int error = value - rounded_color(predictor.predict(*plane, held[i], before));
      out.put(i, folded16(error - green_error[i]));
      if (plane == &block.green) green_error[i] = error;
      before = static_cast<float>(value);
    }
  }
}

// The numbers of the voxels with code kOther, and again as many numbers as there are voxels.
void put_others(const std::vector<std::uint32_t>& others, std::size_t held, PayloadWriter& out) {
  out.resize(others.size());
  out.begin<std::uint32_t>();
  for (std::size_t i = 0; i < others.size(); ++i) out.put(i, others[i]);
  out.resize(held);
}

void put_votes(const BlockPlanes& block, const HeldVoxels& held, const Predictor& predictor, PayloadWriter& out) {
  std::vector<std::uint32_t> others;
  out.begin<std::uint8_t>();
  float before = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const float value = block.vote_sum[held[i]];
    const WeightCode code = code_of(value, block.weight[held[i]]);
    out.put(i, static_cast<std::uint8_t>(code));
    if (code == kOther) {
      others.push_back(folded(ordered(value) - ordered_prediction(predictor.predict(block.vote_sum, held[i], before))));
    }
    before = value;
  }
  put_others(others, held.size(), out);
}

void put_labels(const BlockPlanes& block, const HeldVoxels& held, PayloadWriter& out) {
  out.begin<std::uint16_t>();
  for (std::size_t i = 0; i < held.size(); ++i) out.put(i, block.label[held[i]]);
  std::vector<std::uint32_t> others;
  out.begin<std::uint8_t>();
  for (std::size_t i = 0; i < held.size(); ++i) {
    const std::uint16_t v = held[i];
    const WeightCode code = code_of(block.label_weight[v], block.weight[v], block.vote_sum[v]);
    out.put(i, static_cast<std::uint8_t>(code));
    if (code == kOther) others.push_back(std::bit_cast<std::uint32_t>(block.label_weight[v]));
  }
  put_others(others, held.size(), out);
}

bool take_floats(std::array<float, kBlockVoxels>& plane, const HeldVoxels& held, const Predictor& predictor, PayloadReader& in) {
  if (!in.begin<std::uint32_t>()) return false;
  float before = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const std::uint32_t predicted = ordered_prediction(predictor.predict(plane, held[i], before));
    before = plane[held[i]] = unordered(unfolded(in.take<std::uint32_t>(i)) + predicted);
    if (!std::isfinite(before)) return false;
  }
  return true;
}

bool take_colors(BlockPlanes& block, const HeldVoxels& held, const Predictor& predictor, PayloadReader& in) {
  std::vector<int> green_error(held.size(), 0);
  for (auto* plane : {&block.green, &block.red, &block.blue}) {
    if (!in.begin<std::uint16_t>()) return false;
    float before = 0;
    for (std::size_t i = 0; i < held.size(); ++i) {
      const int predicted = rounded_color(predictor.predict(*plane, held[i], before));
      const auto value = static_cast<std::uint16_t>(predicted + green_error[i] + unfolded16(in.take<std::uint16_t>(i)));
      (*plane)[held[i]] = value;
      if (plane == &block.green) green_error[i] = value - predicted;
      before = static_cast<float>(value);
    }
  }
  return true;
}

// Codes up to `last` of all voxels. Empty: there are other ones, or too few.
std::vector<std::uint8_t> take_codes(std::size_t count, std::uint8_t last, PayloadReader& in) {
  std::vector<std::uint8_t> codes(in.begin<std::uint8_t>() ? count : 0);
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = in.take<std::uint8_t>(i);
  const bool known = std::all_of(codes.begin(), codes.end(), [last](std::uint8_t code) { return code <= last; });
  return known ? codes : std::vector<std::uint8_t>();
}

// Begins the numbers of the voxels with code kOther.
bool begin_others(const std::vector<std::uint8_t>& codes, PayloadReader& in) {
  in.resize(static_cast<std::size_t>(std::count(codes.begin(), codes.end(), kOther)));
  return in.begin<std::uint32_t>();
}

bool take_votes(BlockPlanes& block, const HeldVoxels& held, const Predictor& predictor, PayloadReader& in) {
  const std::vector<std::uint8_t> codes = take_codes(held.size(), kOther, in);
  if (codes.empty() || !begin_others(codes, in)) return false;
  std::size_t other = 0;
  float before = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const std::uint16_t v = held[i];
    float value = value_of(codes[i], block.weight[v], 0);
    if (codes[i] == kOther) {
      const std::uint32_t predicted = ordered_prediction(predictor.predict(block.vote_sum, v, before));
      value = unordered(unfolded(in.take<std::uint32_t>(other++)) + predicted);
    }
    if (!std::isfinite(value)) return false;
    before = block.vote_sum[v] = value;
  }
  in.resize(held.size());
  return true;
}

bool take_labels(BlockPlanes& block, const HeldVoxels& held, std::uint8_t last_code, PayloadReader& in) {
  if (!in.begin<std::uint16_t>()) return false;
  for (std::size_t i = 0; i < held.size(); ++i) block.label[held[i]] = in.take<std::uint16_t>(i);
  const std::vector<std::uint8_t> codes = take_codes(held.size(), last_code, in);
  if (codes.empty() || !begin_others(codes, in)) return false;
  std::size_t other = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const std::uint16_t v = held[i];
    block.label_weight[v] = codes[i] == kOther ? std::bit_cast<float>(in.take<std::uint32_t>(other++))
                                               : value_of(codes[i], block.weight[v], block.vote_sum[v]);
  }
  return true;
}

bool are_weights(const std::array<float, kBlockVoxels>& plane) {
  return std::all_of(plane.begin(), plane.end(), [](float w) { return std::isfinite(w) && w >= 0; });
}

bool are_within_votes(const BlockPlanes& block) {
  constexpr float kRounding = 1.0001F;
  for (std::size_t v = 0; v < kBlockVoxels; ++v) {
    if (block.label_weight[v] > block.vote_sum[v] * kRounding) return false;
  }
  return true;
}

// Format 1 took the weight of the distance for the sum of the votes. A label that weighs more (the vote of an object counted
// fourfold) was taken to be sure, which it stays; where there is no label and no weight of one, nobody had voted.
void votes_of_format_1(BlockPlanes& block) {
  for (std::size_t v = 0; v < kBlockVoxels; ++v) {
    const bool voted = block.label[v] != 0 || block.label_weight[v] > 0;
    block.vote_sum[v] = voted ? std::max(block.weight[v], block.label_weight[v]) : 0.0F;
  }
}

}  // namespace

Bytes BlockEncoder::encode(const BlockPlanes& block) {
  Mask mask{};
  const HeldVoxels held = held_voxels(block, mask);
  const Predictor predictor(mask);
  payload_.reserve(kMostBytes);
  payload_.assign(kMaskBytes, 0);
  for (const std::uint16_t v : held) payload_[v / 8] = static_cast<std::uint8_t>(payload_[v / 8] | 1U << (v % 8));
  PayloadWriter out(payload_, held.size());
  out.add_part(0, kMaskBytes);
  if (!held.empty()) {
    put_floats(block.distance, held, predictor, out);
    put_floats(block.weight, held, predictor, out);
    put_colors(block, held, predictor, out);
    put_votes(block, held, predictor, out);
    put_labels(block, held, out);
  }
  return compressor_.compress(out.parts());
}

const char* BlockDecoder::decode(std::span<const std::uint8_t> bytes, BlockPlanes& block) {
  payload_.resize(kMostBytes);
  const std::size_t size = decompressor_.decompress(bytes, payload_);
  if (size == Decompressor::kDamaged) return "its voxels cannot be decompressed";
  if (size < kMaskBytes) return "its voxels are cut off";
  Mask mask{};
  HeldVoxels held;
  held.reserve(kBlockVoxels);
  for (std::size_t v = 0; v < kBlockVoxels; ++v) {
    mask[v] = payload_[v / 8] >> (v % 8) & 1;
    if (mask[v] != 0) held.push_back(static_cast<std::uint16_t>(v));
  }
  const Predictor predictor(mask);
  PayloadReader in({payload_.data(), size}, kMaskBytes, held.size());
  const bool has_votes = format_ >= 2;
  const bool good =
      held.empty() || (take_floats(block.distance, held, predictor, in) && take_floats(block.weight, held, predictor, in) &&
                       take_colors(block, held, predictor, in) && (!has_votes || take_votes(block, held, predictor, in)) &&
                       take_labels(block, held, has_votes ? kVotes : kOther, in));
  if (!good) return "its voxels are cut off or not numbers";
  if (!in.at_end()) return "bytes follow its voxels";
  if (!are_weights(block.weight) || !are_weights(block.label_weight) || !are_weights(block.vote_sum)) {
    return "a weight is negative or not a number";
  }
  if (!has_votes) votes_of_format_1(block);
  return are_within_votes(block) ? nullptr : "a label weighs more than all votes";
}

}  // namespace panoptic
