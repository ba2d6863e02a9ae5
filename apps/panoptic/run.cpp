// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/base/files.h"
#include "panoptic/base/parallel.h"
#include "panoptic/io/dataset.h"
#include "panoptic/session/outputs.h"
#include "panoptic/session/session.h"

namespace panoptic {
namespace {

// Maps frame after frame; returns why it stopped early, or nothing at the end of the range.
std::optional<std::string> map_frames(FrameStream& stream, Predictor* predictor, Session& session, Progress& progress) {
  for (std::size_t position = 0;; ++position) {
    progress.advance(position);
    if (interrupted()) return "interrupted";
    const Stopwatch waiting;
    const std::optional<ReadResult> read = stream.next();
    if (!read) return std::nullopt;
    session.profile().add("read", waiting.seconds());
    if (!read->frame) {
      session.skip(read->skipped);
      continue;
    }
    Segmentation segmentation;
    if (predictor != nullptr && !why_unusable(*read->frame)) {
      const Stopwatch predicting;
      segmentation = predictor->predict(*read->frame);
      session.profile().add("predict", predicting.seconds());
    }
    session.add(*read->frame, segmentation);
  }
}

void print_stages(const Profile& profile) {
  fmt::print("\n{:<12}{:>8}{:>10}{:>10}{:>10}{:>10}\n", "stage", "count", "mean ms", "p50 ms", "p95 ms", "max ms");
  for (const auto& [name, h] : profile.stages()) {
    fmt::print("{:<12}{:>8}{:>10.2f}{:>10.2f}{:>10.2f}{:>10.2f}\n", name, h.count(), h.mean_ms(), h.percentile_ms(0.5),
               h.percentile_ms(0.95), h.max_ms());
  }
}

void print_frames(const FrameLog& frames) {
  fmt::print("\n{} frames used, {} skipped\n", frames.used(), frames.skipped());
  for (const auto& [reason, count] : frames.skipped_by_reason()) fmt::print("  {} x {}\n", count, reason);
}

std::string predictor_text(const Options& options) {
  if (!options.predictions.empty()) return options.predictions;
  const std::string networks = networks_text(options.networks);
  return networks.empty() ? "none" : networks;
}

void print_closing(const Session& session, const std::string& output) {
  print_stages(session.profile());
  print_frames(session.frames());
  fmt::print("{} blocks, {:.0f} MB map, peak {:.0f} MB\n", session.map().block_count(),
             static_cast<double>(session.map().memory_bytes()) / 1e6, peak_rss_mb());
  fmt::print("\nlook at   {0}/views/*.png, {0}/scene.glb, {0}/mesh.ply\nread      {0}/objects.json, {0}/report.json\n", output);
}

}  // namespace

std::string networks_text(const NetworkOptions& o) {
  return o.semantic + (o.semantic.empty() || o.instance.empty() ? "" : " + ") + o.instance;
}

FrameRange frame_range_from(const Arguments& arguments) {
  if (arguments.frames.empty()) return {};
  try {
    return parse_frame_range(arguments.frames);
  } catch (const Error& e) {
    throw UsageError(e.what());
  }
}

int run(const Arguments& arguments) {
  const FrameRange range = frame_range_from(arguments);
  const Options options = options_from(arguments);
  set_thread_count(arguments.threads);
  require_writable_folder(arguments.output);
  const auto dataset = open_dataset(arguments.dataset, arguments.calibration);
  const auto predictor = make_predictor(options);
  Session session(options, labels_of(options, predictor.get()));
  fmt::print("{}\nlabels    {}\n", dataset->description(),
             predictor ? predictor_text(options) : "none: mapping geometry and colour");
  std::fflush(stdout);

  watch_for_interrupt();
  RunSummary summary{dataset->description(), predictor_text(options), true, "", 0};
  const Stopwatch stopwatch;
  std::optional<Error> failure;
  {
    FrameStream stream(*dataset, range);
    Progress progress("frames", range.count(dataset->size()));
    try {
      if (const auto stopped = map_frames(stream, predictor.get(), session, progress)) summary.stopped_by = *stopped;
    } catch (const Error& e) {  // what was mapped before is worth keeping
      failure = e;
      summary.stopped_by = e.what();
    }
  }
  summary.complete = summary.stopped_by.empty();
  summary.wall_s = stopwatch.seconds();
  write_outputs(arguments.output, session, options, summary);
  print_closing(session, arguments.output);
  if (failure) throw Error(fmt::format("{} (the map so far is in {}, marked incomplete)", failure->what(), arguments.output));
  if (summary.complete && session.frames().used() == 0) {
    throw Error(fmt::format("{}: no frame was usable; {}/report.json lists why, panoptic doctor looks closer", arguments.dataset,
                            arguments.output));
  }
  if (!summary.complete) fmt::print(stderr, "interrupted: the map so far is in {}, marked incomplete\n", arguments.output);
  return summary.complete ? kDone : kInterrupted;
}

}  // namespace panoptic
