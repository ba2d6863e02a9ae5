// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <utility>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "apps/viewer/server.h"
#include "panoptic/base/files.h"
#include "panoptic/base/parallel.h"
#include "panoptic/session/checkpoint.h"
#include "panoptic/session/online.h"
#include "panoptic/session/online_playback.h"
#include "panoptic/session/open_dataset.h"
#include "panoptic/session/outputs.h"
#include "panoptic/session/publisher_loop.h"
#include "panoptic/session/session.h"

namespace panoptic {
namespace {

// One run while it goes on.
struct Run {
  Predictor* predictor = nullptr;  // none: geometry and colour alone
  Session& session;
  LatestSnapshot& latest;
  RunSummary summary;
  std::unique_ptr<LoopPublisher> publisher = nullptr;  // of an offline run that somebody looks at
  std::unique_ptr<Checkpoints> checkpoints = nullptr;  // of a run that a map file is kept of
  std::optional<std::int64_t> first_used = {};         // frame numbers, in the order of the recording
  std::optional<std::int64_t> last_used = {};
};

void map_frame(const std::shared_ptr<const Frame>& frame, Run& run) {
  auto segmentation = std::make_shared<Segmentation>();
  if (run.predictor != nullptr && !why_unusable(*frame)) {
    const Stopwatch predicting;
    *segmentation = run.predictor->predict(*frame);
    run.session.profile().add("predict", predicting.seconds());
  }
  const std::optional<std::string> refused = run.session.add(*frame, *segmentation);
  if (run.checkpoints) run.checkpoints->note(record_of(*frame, !segmentation->segment_at.empty(), refused));
  if (refused) return;
  if (!run.first_used) run.first_used = frame->index;
  run.last_used = frame->index;
  if (run.predictor != nullptr && segmentation->segment_at.empty()) ++run.summary.without_prediction;
  if (run.publisher) run.publisher->added(frame, std::move(segmentation));
}

// Frame after frame to the end of the range, or until it is interrupted, which run.summary then says.
void map_frames(FrameStream& stream, Run& run, Progress& progress) {
  for (std::size_t position = run.checkpoints ? run.checkpoints->positions() : 0;; ++position) {
    progress.advance(position);
    if (run.publisher) run.publisher->at(position);
    if (interrupted()) {
      run.summary.stopped_by = "interrupted";
      return;
    }
    const Stopwatch waiting;
    std::optional<ReadResult> read = stream.next();
    if (!read) return;
    run.session.profile().add("read", waiting.seconds());
    if (read->frame) {
      map_frame(std::make_shared<const Frame>(std::move(*read->frame)), run);
    } else {
      run.session.skip(read->skipped);
      if (run.checkpoints) run.checkpoints->note({.frame = read->skipped.index, .unused_because = read->skipped.reason});
    }
    if (run.checkpoints) {
      const Stopwatch saving;
      run.checkpoints->after_frame(run.session);
      run.session.profile().add("save", saving.seconds());
    }
  }
}

// What went before the run was resumed counts as if it had been now.
void count_resumed(Run& run) {
  for (const FrameRecord& frame : run.checkpoints->resumed_frames()) {
    if (!frame.unused_because.empty()) continue;
    if (!run.first_used) run.first_used = frame.frame;
    run.last_used = frame.frame;
    if (run.predictor != nullptr && !frame.labelled) ++run.summary.without_prediction;
  }
}

// The part of the range that is not in the map yet.
FrameRange rest_of(FrameRange range, std::uint64_t done) {
  range.begin += done * range.step;
  return range;
}

// What the action throws, as text for a person; empty if it throws nothing.
std::string failure_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::bad_alloc&) {
    return kOutOfMemory;
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

// Returns what went wrong on the way, or nothing: what was mapped before is worth keeping, so it is not thrown.
std::string map_offline(const Dataset& dataset, FrameRange range, Run& run) {
  if (run.checkpoints && run.checkpoints->was_complete()) return "";
  FrameStream stream(dataset, run.checkpoints ? rest_of(range, run.checkpoints->positions()) : range);
  Progress progress("frames", range.count(dataset.size()));
  std::string failure = failure_of([&] {
    map_frames(stream, run, progress);
    // What finish does waits until the recording is through: an interrupted map must be as it was between two frames.
    if (run.checkpoints && !run.summary.stopped_by.empty()) run.checkpoints->finish(run.session, false);
    run.session.finish();
    if (run.checkpoints && run.summary.stopped_by.empty()) run.checkpoints->finish(run.session, true);
  });
  if (!failure.empty()) run.summary.stopped_by = failure;
  if (run.publisher) {
    const std::string unseen = failure_of([&] { run.publisher->finish(run.summary.stopped_by); });
    if (failure.empty()) failure = unseen;
  }
  return failure;
}

// The same with every stage on its own thread.
std::string map_online(const Dataset& dataset, const Playback& playback, Run& run, const OnlineOptions& options) {
  const std::size_t total = playback.range.count(dataset.size());
  OnlinePipeline::Parts parts{run.session, run.predictor, run.latest, total};
  parts.checkpoints = run.checkpoints.get();
  OnlinePipeline pipeline(parts, options);
  Progress progress("frames", total);
  std::string failure = failure_of([&] {
    play(dataset, playback, pipeline, [&](std::size_t done) {
      progress.advance(done);
      if (interrupted()) pipeline.stop("interrupted");
    });
  });
  if (!failure.empty()) pipeline.stop(failure);
  const OnlineReport report = pipeline.finish();
  if (report.failure) failure = failure_of([&] { std::rethrow_exception(report.failure); });
  if (run.checkpoints) {
    const bool complete = failure.empty() && report.stopped_by.empty();
    const std::string unsaved = failure_of([&] { run.checkpoints->finish(run.session, complete); });
    if (failure.empty()) failure = unsaved;
  }
  run.summary.stopped_by = failure.empty() ? report.stopped_by : failure;
  if (run.predictor != nullptr) run.summary.without_prediction = report.used - report.labelled;
  run.summary.online = report;
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
  fmt::print("\n{:<18}{:>8}{:>10}{:>10}{:>10}{:>10}\n", "stage", "count", "mean ms", "p50 ms", "p95 ms", "max ms");
  for (const auto& [name, h] : profile.stages()) {
    fmt::print("{:<18}{:>8}{:>10.2f}{:>10.2f}{:>10.2f}{:>10.2f}\n", name, h.count(), h.mean_ms(), h.percentile_ms(0.5),
               h.percentile_ms(0.95), h.max_ms());
  }
}

void print_frames(const FrameLog& frames, std::uint64_t without_prediction) {
  fmt::print("\n{} frames used, {} skipped\n", frames.used(), frames.skipped());
  if (without_prediction > 0) fmt::print("{} of the frames used had no prediction\n", without_prediction);
  for (const auto& [reason, count] : frames.skipped_by_reason()) fmt::print("  {} x {}\n", count, reason);
}

void print_online(const OnlineReport& o) {
  fmt::print("\nonline    geometry {:.1f} Hz, labels {:.1f} Hz\n", o.geometry_hz, o.label_hz);
  fmt::print("{} read = {} used + {} skipped + {} dropped + {} lost; {} of those used were labelled, {} passed over\n", o.read,
             o.used, o.skipped, o.dropped, o.lost, o.labelled, o.passed_over);
  for (const auto& [name, h] : o.latency.stages()) {
    fmt::print("read to {:<10} p50 {:.0f} ms, p95 {:.0f} ms\n", name, h.percentile_ms(0.5), h.percentile_ms(0.95));
  }
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
  if (run.summary.online) print_online(*run.summary.online);
  fmt::print("{} blocks, {:.0f} MB map, peak {:.0f} MB\n", session.map().voxels.block_count(),
             static_cast<double>(session.map().voxels.memory_bytes()) / 1e6, peak_rss_mb());
  if (const std::uint64_t refused = session.map().objects.refused(); refused > 0) {
    tell(fmt::format("{} times there was no place for a new object: a map holds {} at a time; map smaller parts\n", refused,
                     number(LabelSlot::kNoVote) - session.map().labels.first_thing()));
  }
  const std::string pictures = run.summary.pictures ? output + "/views/*.png, " : "";
  fmt::print("\nlook at   {1}{0}/scene.glb, {0}/mesh.ply\nread      {0}/objects.json, {0}/report.json\n", output, pictures);
}

// Where explain finds the recording again, from whatever folder it is started.
std::string absolute_recording(const std::string& recording) {
  return recording.starts_with("sim:") ? recording : std::filesystem::absolute(recording).lexically_normal().string();
}

void keep_map_file(const Arguments& arguments, const Options& options, Run& run) {
  CheckpointSettings settings{.path = arguments.map, .resume = arguments.resume};
  settings.every_s = arguments.checkpoint_every_s.value_or(settings.every_s);
  settings.warn = [](const std::string& what) { tell(fmt::format("\n{}\n", what)); };
  const RunIdentity identity{run.summary.recording, run.summary.calibration, arguments.frames, options, arguments.online};
  run.checkpoints = std::make_unique<Checkpoints>(std::move(settings), identity, run.session);
  count_resumed(run);
  if (run.checkpoints->was_complete()) {
    fmt::print("map       {} is complete: nothing is left to map\n", arguments.map);
  } else if (run.checkpoints->positions() > 0) {
    fmt::print("map       {}, from frame {} on\n", arguments.map, run.checkpoints->positions());
  }
  std::fflush(stdout);
}

// A run that went through and still gave nothing of what was asked for.
void require_use(const Run& run, const Arguments& arguments) {
  const std::uint64_t used = run.session.frames().used();
  if (used == 0) {
    throw Error(fmt::format("{}: no frame was usable; {}/report.json lists why, panoptic doctor looks closer", arguments.dataset,
                            arguments.output));
  }
  if (run.summary.without_prediction == used && run.summary.online) {
    throw Error(
        fmt::format("{}: no prediction matched a frame (the map in {} has no labels)", run.summary.predictor, arguments.output));
  }
  if (run.summary.without_prediction == used) {
    throw Error(
        fmt::format("{}: no prediction matched a frame; the {} frames used are numbered {} to {}, and a prediction must "
                    "have the number of its frame (the map in {} has no labels)",
                    run.summary.predictor, used, run.first_used.value_or(0), run.last_used.value_or(0), arguments.output));
  }
}

// Networks that run beside everything else get half of the threads each, unless the user chose.
Options with_shared_threads(Options options) {
  if (options.networks.threads == 0) options.networks.threads = std::max(1, thread_count() / 2);
  return options;
}

std::string title_of(const std::string& recording) {
  const std::filesystem::path path = std::filesystem::path(recording).lexically_normal();
  return path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
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

// Not in what is written of the options: they may be used for another run.
Options with_swap_folder(Options options, const std::string& output) {
  if (options.map.swap_folder.empty()) options.map.swap_folder = output;
  return options;
}

int run(const Arguments& arguments) {
  if (arguments.online && arguments.resume) {
    throw UsageError("--resume is for runs without --online: what an online run drops depends on the moment");
  }
  const FrameRange range = frame_range_from(arguments);
  const Options options = options_from(arguments);
  const Options placed = with_swap_folder(options, arguments.output);
  set_thread_count(arguments.threads);
  require_writable_folder(arguments.output);
  const auto dataset = open_dataset(arguments.dataset, arguments.calibration);
  const auto predictor = make_predictor(arguments.online ? with_shared_threads(options) : options);
  Session session(placed, labels_of(options, predictor.get()));
  LatestSnapshot latest;
  std::unique_ptr<ViewerServer> viewer;
  if (arguments.view) {
    viewer = std::make_unique<ViewerServer>(viewer_options_from(arguments),
                                            scene_of(session, title_of(arguments.dataset), dataset->description()), latest);
  }
  watch_for_interrupt();
  fmt::print("{}\nlabels    {}\n", dataset->description(),
             predictor ? predictor_text(options) : "none: mapping geometry and colour");
  if (viewer) fmt::print("look at   {}\n", viewer->url());
  std::fflush(stdout);

  Run run{predictor.get(), session, latest, {}};
  run.summary.dataset = dataset->description();
  run.summary.recording = absolute_recording(arguments.dataset);
  if (!arguments.calibration.empty()) run.summary.calibration = std::filesystem::absolute(arguments.calibration).string();
  run.summary.predictor = predictor_text(options);
  run.summary.pictures = !arguments.no_pictures;
  if (!arguments.map.empty()) keep_map_file(arguments, placed, run);
  if (viewer && !arguments.online) run.publisher = std::make_unique<LoopPublisher>(session, latest, range.count(dataset->size()));
  const Stopwatch stopwatch;
  const std::string failure = arguments.online ? map_online(*dataset, {range, arguments.speed.value_or(1)}, run, options.online)
                                               : map_offline(*dataset, range, run);
  run.summary.complete = run.summary.stopped_by.empty();
  run.summary.wall_s = stopwatch.seconds();
  // An older result is worth more than none.
  if (!failure.empty() && session.frames().used() == 0) throw Error(failure);
  write_map(arguments.output, run, options, failure);
  print_closing(run, arguments.output);
  if (!failure.empty()) throw Error(fmt::format("{} (the map so far is in {}, marked incomplete)", failure, arguments.output));
  if (!run.summary.complete) {
    tell(fmt::format("interrupted: the map so far is in {}, marked incomplete\n", arguments.output));
    return kInterrupted;
  }
  require_use(run, arguments);
  return kDone;
}

}  // namespace panoptic
