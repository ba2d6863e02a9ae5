// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <new>
#include <optional>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/base/files.h"
#include "panoptic/base/parallel.h"
#include "panoptic/session/open_dataset.h"
#include "panoptic/session/outputs.h"
#include "panoptic/session/session.h"

namespace panoptic {
namespace {

// One run while it goes on.
struct Run {
  Predictor* predictor = nullptr;  // none: geometry and colour alone
  Session& session;
  RunSummary summary;
  std::int64_t first_used = 0;  // frame numbers, in the order of the recording
  std::int64_t last_used = 0;
};

void map_frame(const Frame& frame, Run& run) {
  Segmentation segmentation;
  if (run.predictor != nullptr && !why_unusable(frame)) {
    const Stopwatch predicting;
    segmentation = run.predictor->predict(frame);
    run.session.profile().add("predict", predicting.seconds());
  }
  if (run.session.add(frame, segmentation)) return;
  if (run.session.frames().used() == 1) run.first_used = frame.index;
  run.last_used = frame.index;
  if (run.predictor != nullptr && segmentation.segment_at.empty()) ++run.summary.without_prediction;
}

// Frame after frame to the end of the range, or until it is interrupted, which run.summary then says.
void map_frames(FrameStream& stream, Run& run, Progress& progress) {
  for (std::size_t position = 0;; ++position) {
    progress.advance(position);
    if (interrupted()) {
      run.summary.stopped_by = "interrupted";
      return;
    }
    const Stopwatch waiting;
    const std::optional<ReadResult> read = stream.next();
    if (!read) return;
    run.session.profile().add("read", waiting.seconds());
    if (read->frame) {
      map_frame(*read->frame, run);
    } else {
      run.session.skip(read->skipped);
    }
  }
}

// Returns what went wrong on the way, or nothing: what was mapped before is worth keeping, so it is not thrown.
std::string map_recording(const Dataset& dataset, FrameRange range, Run& run) {
  const Stopwatch stopwatch;
  std::string failure;
  FrameStream stream(dataset, range);
  Progress progress("frames", range.count(dataset.size()));
  try {
    map_frames(stream, run, progress);
    run.session.finish();
  } catch (const std::bad_alloc&) {
    failure = kOutOfMemory;
  } catch (const std::exception& e) {
    failure = e.what();
  }
  if (!failure.empty()) run.summary.stopped_by = failure;
  run.summary.complete = run.summary.stopped_by.empty();
  run.summary.wall_s = stopwatch.seconds();
  return failure;
}

// Writes the map, or what there is of it after a failure; whatever goes wrong here must not hide that failure.
void write_map(const std::string& output, const Run& run, const Options& options, const std::string& failure) {
  try {
    write_outputs(output, run.session, options, run.summary);
  } catch (const std::exception& e) {
    if (failure.empty()) throw;
    throw Error(fmt::format("{}; and the map so far could not be written whole: {}", failure, e.what()));
  }
}

void print_stages(const Profile& profile) {
  fmt::print("\n{:<12}{:>8}{:>10}{:>10}{:>10}{:>10}\n", "stage", "count", "mean ms", "p50 ms", "p95 ms", "max ms");
  for (const auto& [name, h] : profile.stages()) {
    fmt::print("{:<12}{:>8}{:>10.2f}{:>10.2f}{:>10.2f}{:>10.2f}\n", name, h.count(), h.mean_ms(), h.percentile_ms(0.5),
               h.percentile_ms(0.95), h.max_ms());
  }
}

void print_frames(const FrameLog& frames, std::uint64_t without_prediction) {
  fmt::print("\n{} frames used, {} skipped\n", frames.used(), frames.skipped());
  if (without_prediction > 0) fmt::print("{} of the frames used had no prediction\n", without_prediction);
  for (const auto& [reason, count] : frames.skipped_by_reason()) fmt::print("  {} x {}\n", count, reason);
}

std::string predictor_text(const Options& options) {
  if (!options.predictions.empty()) return options.predictions;
  const std::string networks = networks_text(options.networks);
  return networks.empty() ? "none" : networks;
}

void print_closing(const Run& run, const std::string& output) {
  const Session& session = run.session;
  print_stages(session.profile());
  print_frames(session.frames(), run.summary.without_prediction);
  fmt::print("{} blocks, {:.0f} MB map, peak {:.0f} MB\n", session.map().block_count(),
             static_cast<double>(session.map().memory_bytes()) / 1e6, peak_rss_mb());
  fmt::print("\nlook at   {0}/views/*.png, {0}/scene.glb, {0}/mesh.ply\nread      {0}/objects.json, {0}/report.json\n", output);
}

// Where explain finds the recording again, from whatever folder it is started.
std::string absolute_recording(const std::string& recording) {
  return recording.starts_with("sim:") ? recording : std::filesystem::absolute(recording).lexically_normal().string();
}

// A run that went through and still gave nothing of what was asked for.
void require_use(const Run& run, const Arguments& arguments) {
  const std::uint64_t used = run.session.frames().used();
  if (used == 0) {
    throw Error(fmt::format("{}: no frame was usable; {}/report.json lists why, panoptic doctor looks closer", arguments.dataset,
                            arguments.output));
  }
  if (run.summary.without_prediction == used) {
    throw Error(
        fmt::format("{}: no prediction matched a frame; the {} frames used are numbered {} to {}, and a prediction must "
                    "have the number of its frame (the map in {} has no labels)",
                    run.summary.predictor, used, run.first_used, run.last_used, arguments.output));
  }
}

}  // namespace

std::string networks_text(const NetworkOptions& o) {
  std::vector<std::string> names = o.semantic;
  if (!o.instance.empty()) names.push_back(o.instance);
  return fmt::format("{}", fmt::join(names, " + "));
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
  watch_for_interrupt();
  fmt::print("{}\nlabels    {}\n", dataset->description(),
             predictor ? predictor_text(options) : "none: mapping geometry and colour");
  std::fflush(stdout);

  Run run{predictor.get(), session, {}};
  run.summary.dataset = dataset->description();
  run.summary.recording = absolute_recording(arguments.dataset);
  if (!arguments.calibration.empty()) run.summary.calibration = std::filesystem::absolute(arguments.calibration).string();
  run.summary.predictor = predictor_text(options);
  const std::string failure = map_recording(*dataset, range, run);
  write_map(arguments.output, run, options, failure);
  print_closing(run, arguments.output);
  if (!failure.empty()) throw Error(fmt::format("{} (the map so far is in {}, marked incomplete)", failure, arguments.output));
  if (!run.summary.complete) {
    fmt::print(stderr, "interrupted: the map so far is in {}, marked incomplete\n", arguments.output);
    return kInterrupted;
  }
  require_use(run, arguments);
  return kDone;
}

}  // namespace panoptic
