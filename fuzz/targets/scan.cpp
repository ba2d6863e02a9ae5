// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/input.h"
#include "panoptic/io/scannet_scan.h"

namespace panoptic::fuzz {

// The aggregation, the segments, the mesh and the list of categories of a ScanNet scan.
void scan(Input input) {
  static const Scratch kScratch("scan");
  constexpr std::string_view kNames[] = {"s.aggregation.json", "s_vh_clean_2.0.010000.segs.json", "s_vh_clean_2.ply",
                                         "labels.tsv"};
  const std::vector<Input> parts = parts_of(input, std::size(kNames));
  for (std::size_t i = 0; i < std::size(kNames); ++i) kScratch.put(kNames[i], i < parts.size() ? parts[i] : Input{});
  const bool has_categories = parts.size() == std::size(kNames);
  succeeds([&] {
    std::vector<std::string> warnings;
    const ScanTruth truth =
        read_scan_truth(kScratch.path(), has_categories ? kScratch.path() / "labels.tsv" : std::filesystem::path(), &warnings);
    const std::size_t vertices = truth.positions.size();
    require(truth.class_id.size() == vertices && truth.instance.size() == vertices, "every vertex has a label");
  });
}

}  // namespace panoptic::fuzz
