// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/dataset_confidence.h"

#include <fmt/format.h>

#include <cstdint>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"

namespace panoptic {

Outcome weigh_by_confidence(const std::filesystem::path& root, const std::string& file, Image<float>& depth,
                            Image<float>& weight) {
  constexpr float kMedium = 0.5F;
  try {
    if (!is_there(root / file)) return Outcome::refused(fmt::format("confidence image missing: {}", file));
    const Image<std::uint16_t> levels = read_gray16(root / file);
    if (!levels.same_size(depth.width(), depth.height())) {
      return Outcome::refused(fmt::format("confidence image is {}x{}, and the depth image {}x{}", levels.width(), levels.height(),
                                          depth.width(), depth.height()));
    }
    weight = Image<float>(depth.width(), depth.height());
    for (std::size_t i = 0; i < depth.size(); ++i) {
      depth[i] = levels[i] == 0 ? 0.0F : depth[i];
      weight[i] = levels[i] == 1 ? kMedium : 1.0F;
    }
    return {};
  } catch (const Error& e) {
    return Outcome::refused(fmt::format("confidence image unreadable: {}", e.what()));
  }
}

}  // namespace panoptic
