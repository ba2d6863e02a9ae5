// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/result_folder.h"
#include "fuzz/input.h"
#include "panoptic/eval/submission.h"
#include "panoptic/evaluation.h"

namespace panoptic::fuzz {
namespace {

// report.json, objects.json, trajectory.txt and mesh.ply of a run.
void run_folder(Input input) {
  static const Scratch kScratch("run");
  constexpr std::string_view kNames[] = {"report.json", "objects.json", "trajectory.txt", "mesh.ply"};
  const std::vector<Input> parts = parts_of(input, std::size(kNames));
  for (std::size_t i = 0; i < std::size(kNames); ++i) kScratch.put(kNames[i], i < parts.size() ? parts[i] : Input{});
  succeeds([&] { require(open_result(kScratch.path()).snapshot != nullptr, "a result that was opened can be shown"); });
  succeeds([&] { read_run_folder(kScratch.path()); });
}

// <scene>.txt and two masks, in the forms of ScanNet's benchmark.
void submission(Input input) {
  constexpr std::size_t kVertices = 4;
  static const Scratch kScratch("submission");
  const std::vector<Input> parts = parts_of(input, 3);
  const std::filesystem::path scene = kScratch.put("a.txt", parts[0]);
  for (std::size_t i = 1; i < parts.size(); ++i) kScratch.put(i == 1 ? "0.txt" : "1.txt", parts[i]);
  succeeds([&] { read_semantic(scene); });
  succeeds([&] { read_panoptic(scene); });
  succeeds([&] { read_instances(kScratch.path(), "a", kVertices); });
}

}  // namespace

// The first byte says which of the two the rest is.
void results(Input input) {
  if (input.empty()) return;
  if (input[0] % 2 == 0) {
    run_folder(input.subspan(1));
  } else {
    submission(input.subspan(1));
  }
}

}  // namespace panoptic::fuzz
