// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/targets.h"

#include <array>

namespace panoptic::fuzz {

std::span<const Target> targets() {
  static constexpr std::array<Target, 17> kTargets = {{{"bag", bag},
                                                       {"block_codec", block_codec},
                                                       {"coco", coco},
                                                       {"corrections", corrections},
                                                       {"http", http},
                                                       {"image", image},
                                                       {"map_file", map_file},
                                                       {"map_rows", map_rows},
                                                       {"ply", ply},
                                                       {"predictions", predictions},
                                                       {"recording", recording},
                                                       {"results", results},
                                                       {"resume", resume},
                                                       {"scan", scan},
                                                       {"sens", sens},
                                                       {"toml", toml},
                                                       {"video", video}}};
  return kTargets;
}

}  // namespace panoptic::fuzz
