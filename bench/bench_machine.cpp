// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// bench_machine: what this machine can do at most, to hold the fusion side against it. Bandwidth of copying and of the triad
// a = b + s * c over arrays far larger than the caches, and single-precision operations of chains of multiplications and
// additions in registers, with one thread and with all. Prints JSON.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <vector>

#include "panoptic/base/clones.h"
#include "panoptic/base/json.h"
#include "panoptic/parallel.h"
#include "panoptic/profile.h"

namespace panoptic {

namespace kernels {

void copy(const float* from, float* to, std::size_t count);
void triad(const float* b, const float* c, float* a, std::size_t count);
float multiply_and_add(std::size_t rounds, float factor);

constexpr std::size_t kChains = 192;  // floats: enough independent vectors to fill the pipelines of any register width

PANOPTIC_CLONES
void copy(const float* from, float* to, std::size_t count) {
  const float* __restrict f = from;
  float* __restrict t = to;
  for (std::size_t i = 0; i < count; ++i) t[i] = f[i];
}

PANOPTIC_CLONES
void triad(const float* b, const float* c, float* a, std::size_t count) {
  const float* __restrict in1 = b;
  const float* __restrict in2 = c;
  float* __restrict out = a;
  for (std::size_t i = 0; i < count; ++i) out[i] = in1[i] + 3.0F * in2[i];
}

// Two operations per chain and round. Products and sums stay apart, as the whole build keeps them.
PANOPTIC_CLONES
float multiply_and_add(std::size_t rounds, float factor) {
  alignas(64) float chain[kChains];
  for (std::size_t k = 0; k < kChains; ++k) chain[k] = static_cast<float>(k);
  for (std::size_t r = 0; r < rounds; ++r) {
#pragma GCC unroll 192
    for (float& c : chain) c = c * factor + 1.0F;
  }
  float sum = 0;
  for (const float c : chain) sum += c;
  return sum;
}

}  // namespace kernels

namespace {

constexpr std::size_t kFloats = std::size_t{1} << 25;  // 128 MiB per array
constexpr std::size_t kPieces = 64;
constexpr int kRepeats = 7;

double best_seconds(const auto& work) {
  double best = 1e9;
  for (int i = 0; i < kRepeats; ++i) {
    const Stopwatch stopwatch;
    work();
    best = std::min(best, stopwatch.seconds());
  }
  return best;
}

struct Arrays {
  std::vector<float> a = std::vector<float>(kFloats, 1);
  std::vector<float> b = std::vector<float>(kFloats, 2);
  std::vector<float> c = std::vector<float>(kFloats, 3);
};

Json ceilings(int threads, Arrays& arrays) {
  set_thread_count(threads);
  constexpr std::size_t kPiece = kFloats / kPieces;
  const double copy_s = best_seconds([&] {
    parallel_for(kPieces,
                 [&](std::size_t p) { kernels::copy(arrays.b.data() + p * kPiece, arrays.a.data() + p * kPiece, kPiece); });
  });
  const double triad_s = best_seconds([&] {
    parallel_for(kPieces, [&](std::size_t p) {
      kernels::triad(arrays.b.data() + p * kPiece, arrays.c.data() + p * kPiece, arrays.a.data() + p * kPiece, kPiece);
    });
  });
  constexpr std::size_t kRounds = 20000;
  std::vector<float> sums(kPieces);
  const double compute_s =
      best_seconds([&] { parallel_for(kPieces, [&](std::size_t p) { sums[p] = kernels::multiply_and_add(kRounds, 0.5F); }); });
  constexpr double kBytes = static_cast<double>(kFloats) * sizeof(float);
  return {{"threads", threads},
          {"copy_gb_per_s", 2 * kBytes / copy_s * 1e-9},
          {"triad_gb_per_s", 3 * kBytes / triad_s * 1e-9},
          {"float_gop_per_s", 2.0 * kRounds * kernels::kChains * kPieces / compute_s * 1e-9},
          {"check", sums.front()}};
}

}  // namespace
}  // namespace panoptic

int main() {
  try {
    panoptic::Arrays arrays;
    panoptic::set_thread_count(0);
    const int cores = panoptic::thread_count();
    panoptic::Json result = panoptic::Json::array();
    for (int threads = 1; threads <= cores; threads *= 2) result.push_back(panoptic::ceilings(threads, arrays));
    fmt::print("{}\n", result.dump(2));
  } catch (const std::exception& e) {
    fmt::print(stderr, "bench_machine: {}\n", e.what());
    return 1;
  }
  return 0;
}
