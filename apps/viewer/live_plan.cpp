// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/live_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <utility>

#include "apps/viewer/live_map.h"
#include "panoptic/base/json.h"
#include "panoptic/error.h"

namespace panoptic {

std::string LivePlan::newest() {
  const bool is_time = !since_ || since_->seconds() >= std::max(kEvery_s, 2 * took_s_);
  if (is_time && latest_.newest()->revision != looked_at_) renew();
  return Json{{"revision", newest_.revision}, {"looked_at", looked_at_}, {"finished", is_last_}, {"why_not", why_not_}}.dump();
}

void LivePlan::renew() {
  since_.emplace();
  const std::shared_ptr<const Snapshot> snapshot = latest_.newest();
  looked_at_ = snapshot->revision;
  is_last_ = snapshot->run.finished;
  why_not_.clear();
  try {
    const LiveMap live = live_map(*snapshot, scene_);
    Made made{snapshot->revision, scene_plan(live.map, live.surface, {}, snapshot->up.cast<double>())};
    before_ = std::exchange(newest_, std::move(made));
  } catch (const std::exception& e) {
    why_not_ = e.what();
  }
  took_s_ = since_->seconds();
}

const ScenePlan& LivePlan::of(std::uint64_t revision) const {
  for (const Made* made : {&newest_, &before_}) {
    if (revision != 0 && made->revision == revision) return made->plan;
  }
  throw Error(fmt::format("there is no plan of revision {} (any more): plan.json names the newest", revision));
}

}  // namespace panoptic
