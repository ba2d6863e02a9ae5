// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/endurance.h"

#include "bench/process_memory.h"
#include "bench/stage_clock.h"
#include "panoptic/error.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/map.h"
#include "panoptic/mapper.h"
#include "panoptic/profile.h"
#include "panoptic/run_outputs.h"

namespace panoptic {
namespace {

// Sums since the last look.
struct Since {
  std::size_t frames = 0;
  double cpu_s = 0;
  StageClock stages;
};

EnduranceLook look(const Mapper& mapper, Since& since) {
  EnduranceLook result;
  const auto frames = static_cast<double>(since.frames);
  result.cpu_ms = since.cpu_s * 1e3 / frames;
  for (const auto& [name, ms] : since.stages.lap_ms(mapper.profile())) result.stages_ms[name] = ms / frames;
  since.frames = 0;
  since.cpu_s = 0;
  const PanopticMap& map = mapper.map();
  result.rss_mb = rss_mb();
  result.map_mb = static_cast<double>(map.voxels.memory_bytes()) / 1e6;
  result.blocks = map.voxels.block_count();
  result.observed_voxels = map.voxels.observed_voxels();
  result.objects = map.objects.count();
  result.ids_given = number(map.objects.next_id()) - map.labels.first_thing();
  return result;
}

double saved_mb(const Mapper& mapper, const EnduranceSettings& settings) {
  if (settings.save.empty()) return 0;
  save_map(settings.save, mapper, settings.options);
  return static_cast<double>(std::filesystem::file_size(settings.save)) / 1e6;
}

}  // namespace

EnduranceResult endure(const NextFrame& next, const LabelSet& labels, const EnduranceSettings& settings) {
  EnduranceResult result;
  Mapper mapper(settings.options, labels);
  Since since;
  reset_peak_memory();
  const auto look_now = [&] {
    EnduranceLook& latest = result.looks.emplace_back(look(mapper, since));
    latest.frames = mapper.frames().used();
    latest.file_mb = saved_mb(mapper, settings);
  };
  while (mapper.frames().used() < settings.frames) {
    const std::optional<BenchFrame> f = next();
    if (!f) break;
    const double before_s = cpu_seconds(CLOCK_THREAD_CPUTIME_ID);
    const Outcome outcome = mapper.add(f->frame, f->segmentation);
    if (!outcome.used) throw Error("a frame was refused: " + outcome.reason);
    since.cpu_s += cpu_seconds(CLOCK_THREAD_CPUTIME_ID) - before_s;
    if (++since.frames == settings.every) look_now();
  }
  if (since.frames > 0) look_now();
  if (result.looks.empty()) throw Error("no frame came that could be mapped");
  result.peak_rss_mb = peak_memory_mb();
  result.map_hash = mapper.map().voxels.hash();
  return result;
}

}  // namespace panoptic
