// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/take_topics.h"

#include <fmt/format.h>

#include "panoptic/bag.h"
#include "panoptic/error.h"

namespace panoptic {

void take_topics(Arguments& a) {
  if (a.topics.empty()) return;
  try {
    parse_bag_choice(a.topics);
  } catch (const Error& e) {
    throw UsageError(fmt::format("--topics: {}", e.what()));
  }
  if (a.dataset.starts_with("sim:")) throw UsageError("--topics: a simulated home has no topics; leave it out");
  a.dataset += "?" + a.topics;
}

}  // namespace panoptic
