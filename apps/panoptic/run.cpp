// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "apps/panoptic/visits.h"
#include "apps/viewer/server.h"
#include "panoptic/bag.h"
#include "panoptic/base/files.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/map.h"
#include "panoptic/mapper.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/mapping_run.h"
#include "panoptic/mapping/outputs.h"
#include "panoptic/mapping/publisher_loop.h"
#include "panoptic/parallel.h"
#include "panoptic/predictor.h"
#include "panoptic/profile.h"
#include "panoptic/simulation.h"

namespace panoptic {
namespace {

constexpr const char* kNoPredictor = "none";

// Writes the map, or what there is of it after a failure; whatever goes wrong here must not hide that failure.
WrittenMap write_map(const std::string& output, Mapper& mapper, const Options& options, const RunSummary& summary,
                     const std::string& failure) {
  try {
    return write_outputs(output, mapper, options, summary);
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

void print_frames(const FrameStatistics& frames, std::uint64_t without_prediction) {
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

void print_corrections(const std::vector<Correction>& corrections) {
  double ms = 0;
  std::size_t poses = 0;
  std::size_t unknown = 0;
  for (const Correction& correction : corrections) {
    ms += correction.ms;
    poses += correction.frames;
    unknown += correction.unknown;
  }
  fmt::print("{} corrections moved {} poses, {:.0f} ms each\n", corrections.size(), poses,
             ms / static_cast<double>(corrections.size()));
  if (unknown > 0)
    tell(fmt::format("note: {} corrected poses are of frames that were not in the map at their moment\n", unknown));
}

void print_tracking(const TrackingReport& tracking) {
  const auto corrected = std::count_if(tracking.loops.begin(), tracking.loops.end(), [](const Loop& l) { return l.corrects; });
  fmt::print("\ntracking  {} frames, {} lost, quality {:.2f}, {} keyframes, {} places seen again, {} of them corrected poses\n",
             tracking.tracked, tracking.lost, tracking.mean_quality, tracking.keyframes, tracking.loops.size(), corrected);
}

// The source of labels, if there is one: what the options name, else what the list of recordings does.
std::string predictor_text(const Options& options, const std::string& list) {
  if (!options.predictions.empty()) return options.predictions;
  const std::string networks = networks_text(options.networks);
  return networks.empty() ? "the predictions of " + list : networks;
}

void print_closing(const Arguments& arguments, const Mapper& mapper, const RunSummary& summary) {
  const std::string& output = arguments.output;
  print_stages(mapper.profile());
  print_frames(mapper.frames(), summary.without_prediction);
  if (summary.online) print_online(*summary.online);
  if (summary.tracking) print_tracking(*summary.tracking);
  if (summary.tracking && !arguments.earlier_map.empty()) tell_found(arguments.earlier_map, *summary.tracking);
  if (!summary.corrections.empty()) print_corrections(summary.corrections);
  const VoxelMap& map = mapper.map().voxels;
  fmt::print("{} blocks, {:.1f} million voxels observed, {:.0f} MB map, peak {:.0f} MB\n", map.block_count(),
             static_cast<double>(map.observed_voxels()) / 1e6, static_cast<double>(map.memory_bytes()) / 1e6, peak_rss_mb());
  if (const std::uint64_t refused = mapper.map().objects.refused(); refused > 0) {
    tell(fmt::format("{} times there was no place for a new object: a map holds {} at a time; map smaller parts\n", refused,
                     number(LabelSlot::kNoVote) - mapper.map().labels.first_thing()));
  }
  const std::string pictures = summary.pictures ? output + "/views/*.png, " : "";
  fmt::print("\nlook at   {1}{0}/scene.glb, {0}/mesh.ply\nread      {0}/objects.json, {0}/report.json\n", output, pictures);
}

std::unique_ptr<Checkpoints> keep_map_file(const Arguments& arguments, const Options& options, const RunSummary& summary,
                                           bool is_tracked, Mapper& mapper) {
  if (arguments.map.empty()) return nullptr;
  CheckpointSettings settings{.path = arguments.map, .resume = arguments.resume, .earlier = earlier_map(arguments, summary)};
  settings.every_s = arguments.checkpoint_every_s.value_or(settings.every_s);
  settings.warn = [](const std::string& what) { tell(fmt::format("\n{}\n", what)); };
  const RunIdentity identity{summary.recording,
                             summary.calibration,
                             arguments.frames,
                             options,
                             arguments.online,
                             summary.pair_tolerance_s,
                             to_text(summary.recordings),
                             absolute_recording(arguments.pose_updates),
                             is_tracked};
  auto checkpoints = std::make_unique<Checkpoints>(std::move(settings), identity, mapper);
  if (checkpoints->was_complete()) {
    fmt::print("map       {} is complete: nothing is left to map\n", arguments.map);
  } else if (checkpoints->positions() > 0) {
    fmt::print("map       {}, from frame {} on\n", arguments.map, checkpoints->positions());
  }
  std::fflush(stdout);
  return checkpoints;
}

// A map without surface, or without a label although labels were asked for.
void require_map(const WrittenMap& written, const RunSummary& summary, std::uint64_t used, const Arguments& arguments) {
  if (written.triangles == 0) {
    throw Error(fmt::format("{}: no surface came of the {} frames used (see {}); check depth scale and poses: panoptic doctor {}",
                            arguments.dataset, used, arguments.output, arguments.dataset));
  }
  if (summary.predictor != kNoPredictor && written.labelled_vertices == 0) {
    throw Error(
        fmt::format("{}: not one of its labels counted (the map in {} has no labels); do its classes have the names of the label "
                    "set's, and does it fit the images?",
                    summary.predictor, arguments.output));
  }
}

// " (20 x pose is not finite)": the reason for which most frames were skipped.
std::string usual_reason(const FrameStatistics& frames) {
  const auto& reasons = frames.skipped_by_reason();
  const auto most =
      std::max_element(reasons.begin(), reasons.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == reasons.end() ? "" : fmt::format(" ({} x {})", most->second, most->first);
}

// A network that was of no use makes a map that looks as if there was nothing to see.
void require_sense(const PredictorReport& report, const WrittenMap& written, const RunSummary& summary, std::uint64_t used,
                   const Arguments& arguments) {
  if (!report.trouble.empty()) throw Error(fmt::format("{} (the map is in {})", report.trouble, arguments.output));
  require_map(written, summary, used, arguments);
}

// A run that went through and still gave nothing of what was asked for.
void require_use(const Mapper& mapper, const RunSummary& summary, const MappingResult& result, const EarlierFrames& earlier,
                 const Arguments& arguments) {
  const std::uint64_t used = mapper.frames().used() - earlier.used;
  if (used == 0 && summary.tracking && !arguments.earlier_map.empty()) throw never_found(arguments, *summary.tracking);
  if (used == 0) {
    throw Error(fmt::format("{}: no frame was usable{}; {}/report.json lists why, panoptic doctor looks closer",
                            arguments.dataset, usual_reason(mapper.frames()), arguments.output));
  }
  if (summary.without_prediction != used + (earlier.used - earlier.labelled)) return;
  if (summary.online) {
    throw Error(
        fmt::format("{}: no prediction matched a frame (the map in {} has no labels)", summary.predictor, arguments.output));
  }
  throw Error(
      fmt::format("{}: no prediction matched a frame; the {} frames used are numbered {} to {}, and a prediction must "
                  "have the number of its frame (the map in {} has no labels)",
                  summary.predictor, used, result.first_used.value_or(0), result.last_used.value_or(0), arguments.output));
}

// Tells how the run went, and returns the program's exit code. Throws Error if it failed, or gave nothing of what was asked for.
int conclude(const Arguments& arguments, const Mapper& mapper, const RunSummary& summary, const MappingResult& result,
             const EarlierFrames& earlier) {
  print_closing(arguments, mapper, summary);
  if (!result.failure.empty()) {
    throw Error(fmt::format("{} (the map so far is in {}, marked incomplete)", result.failure, arguments.output));
  }
  if (!summary.complete) {
    tell(fmt::format("interrupted: the map so far is in {}, marked incomplete\n", arguments.output));
    return kInterrupted;
  }
  require_use(mapper, summary, result, earlier, arguments);
  return kDone;
}

// Networks that run beside everything else get half of the threads each, unless the user chose.
Options with_shared_threads(Options options) {
  if (options.networks.threads == 0) options.networks.threads = std::max(1, thread_count() / 2);
  return options;
}

std::string title_of(const std::string& recording) {
  const std::filesystem::path path = path_of_recording(recording).lexically_normal();
  return path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
}

// The facts about the run that are known before it begins.
RunSummary summary_of(const Arguments& arguments, const Dataset& dataset) {
  RunSummary summary;
  summary.dataset = dataset.description();
  summary.recording = absolute_recording(arguments.dataset);
  if (!arguments.calibration.empty()) summary.calibration = std::filesystem::absolute(arguments.calibration).string();
  summary.recordings = recordings_of(dataset);
  summary.pair_tolerance_s = arguments.pair_tolerance_s;
  summary.notes = dataset.notes();
  summary.pictures = !arguments.no_pictures;
  return summary;
}

}  // namespace

std::string absolute_recording(const std::string& recording) {
  return recording.empty() || recording.starts_with("sim:") ? recording
                                                            : std::filesystem::absolute(recording).lexically_normal().string();
}

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

// A log of the frames is kept where something can come of it.
Options with_log(Options options, const Arguments& arguments, bool is_tracked) {
  if (options.map.log == "auto" && (!arguments.map.empty() || !arguments.pose_updates.empty() || is_tracked))
    options.map.log = "reference";
  if (is_tracked && options.map.log == "none") {
    throw UsageError("map.log = none: where poses are tracked the map follows when they are corrected, and needs the log for it");
  }
  return options;
}

void require_possible(const Arguments& arguments) {
  if (arguments.online && arguments.resume) {
    throw UsageError("--resume is for runs without --online: what an online run drops depends on the moment");
  }
  if (arguments.online && !arguments.write_moving.empty()) {
    throw UsageError("--write-moving is for runs without --online: what moves there is known when the frame is gone");
  }
  if (!arguments.earlier_map.empty() && (arguments.online || !arguments.frames.empty() || !arguments.pose_updates.empty())) {
    throw UsageError("--in does not go with --online, --frames or --pose-updates");
  }
  if (arguments.track && (arguments.resume || !arguments.pose_updates.empty())) {
    throw UsageError("--track does not go with --resume or --pose-updates");
  }
}

std::vector<PoseUpdates> pose_updates_from(const Arguments& arguments) {
  return arguments.pose_updates.empty() ? std::vector<PoseUpdates>() : read_pose_updates(arguments.pose_updates);
}

// The facts that are known once it has ended.
void add_result(RunSummary& summary, const MappingResult& result) {
  summary.stopped_by = result.stopped_by;
  summary.complete = result.stopped_by.empty();
  summary.without_prediction = result.without_prediction;
  summary.online = result.online;
  summary.corrections = result.corrections;
  summary.tracking = result.tracking;
}

namespace {

// nullptr if nobody wants to look on.
std::unique_ptr<ViewerServer> open_viewer(const Arguments& arguments, const Mapper& mapper, const Dataset& dataset,
                                          LatestSnapshot& latest) {
  if (!arguments.view) return nullptr;
  return std::make_unique<ViewerServer>(viewer_options_from(arguments),
                                        scene_of(mapper, title_of(arguments.dataset), dataset.description()), latest,
                                        PlaySource::of_growing_map());
}

void tell_start(const RunSummary& summary, const ViewerServer* viewer) {
  fmt::print("{}\nlabels    {}\n", summary.dataset,
             summary.predictor == kNoPredictor ? "none: mapping geometry and colour" : summary.predictor);
  if (viewer != nullptr) fmt::print("look at   {}\n", viewer->url());
  std::fflush(stdout);
}

int map_recording(const Arguments& arguments) {
  const FrameRange range = frame_range_from(arguments);
  const Options options = options_from(arguments);
  const std::vector<PoseUpdates> pose_updates = pose_updates_from(arguments);
  set_thread_count(arguments.threads);
  require_writable_folder(arguments.output);
  if (!arguments.write_moving.empty()) require_writable_folder(arguments.write_moving);
  const OpenedRecording opened = open_to_map(arguments);
  const auto& dataset = opened.dataset;
  const Options placed = with_log(with_swap_folder(options, arguments.output), arguments, opened.is_tracked);
  const auto predictor = make_predictor(arguments.online ? with_shared_threads(options) : options, *dataset);
  Mapper mapper(placed, labels_of(options, predictor.get()));
  LatestSnapshot latest;
  const std::unique_ptr<ViewerServer> viewer = open_viewer(arguments, mapper, *dataset, latest);
  watch_for_interrupt();
  RunSummary summary = summary_of(arguments, *dataset);
  summary.predictor = predictor ? predictor_text(options, arguments.dataset) : kNoPredictor;
  tell_start(summary, viewer.get());
  const auto checkpoints = keep_map_file(arguments, placed, summary, opened.is_tracked, mapper);
  const Stopwatch stopwatch;
  MappingResult result = [&] {
    Progress progress("frames", range.count(dataset->size()));
    std::optional<RunTracker> tracker;
    if (opened.is_tracked) tracker.emplace(CameraTrackerOptions{options.depth.min_m, options.depth.max_m, {}});
    if (tracker && !arguments.earlier_map.empty()) tell_places(*checkpoints, mapper, *dataset, *tracker);
    MappingRun run{*dataset, range, predictor.get(), mapper, checkpoints.get(), pose_updates, [&](std::size_t done) {
                     progress.advance(done);
                     tell_warnings(predictor.get());
                     return !interrupted();
                   }};
    run.tracker = tracker ? &*tracker : nullptr;
    run.given_poses = opened.given_poses();
    run.moving_masks = arguments.write_moving;
    if (arguments.online) return map_online(run, arguments.speed.value_or(1), options.online, latest);
    std::optional<LoopPublisher> publisher;
    if (viewer) publisher.emplace(mapper, latest, range.count(dataset->size()));
    return map_offline(run, publisher ? &*publisher : nullptr);
  }();
  summary.wall_s = stopwatch.seconds();
  if (result.failure == kOutOfMemory) result.failure = kOutOfMemoryAdvice;
  add_result(summary, result);
  // An older result is worth more than none.
  if (!result.failure.empty() && mapper.frames().used() == 0) throw Error(result.failure);
  const WrittenMap written = write_map(arguments.output, mapper, options, summary, result.failure);
  const PredictorReport report = closing_report(predictor.get());
  const EarlierFrames earlier = earlier_frames(arguments, summary, checkpoints.get());
  const int code = conclude(arguments, mapper, summary, result, earlier);
  tell_changes(arguments.map, earlier);
  if (viewer) viewer->finish([] { return !interrupted(); });
  if (code == kDone) require_sense(report, written, summary, mapper.frames().used(), arguments);
  return code;
}

}  // namespace

int run(const Arguments& arguments) {
  require_possible(arguments);
  return map_recording(arguments.earlier_map.empty() ? arguments : with_earlier_visits(arguments));
}

}  // namespace panoptic
