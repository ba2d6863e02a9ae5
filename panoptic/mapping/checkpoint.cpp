// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/checkpoint.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <iterator>
#include <optional>
#include <utility>

#include "panoptic/base/config.h"
#include "panoptic/base/files.h"
#include "panoptic/base/version.h"
#include "panoptic/data/same_labels.h"
#include "panoptic/error.h"
#include "panoptic/map/brick_pool.h"
#include "panoptic/mapfile/image_rows.h"
#include "panoptic/mapfile/map_lock.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr std::size_t kMostCopies = 4;  // times CheckpointSettings::copies_bytes

std::map<std::string, std::string> texts_of(const RunIdentity& identity) {
  std::map<std::string, std::string> texts = {
      {run_note::kRecording, identity.recording},
      {run_note::kCalibration, identity.calibration},
      {run_note::kPairTolerance, identity.pair_tolerance_s ? fmt::format("{}", *identity.pair_tolerance_s) : ""},
      {run_note::kFrames, identity.frames},
      {run_note::kPoseUpdates, identity.pose_updates},
      {run_note::kOptions, options_text(identity.options)}};
  if (!identity.recordings.empty()) texts[run_note::kRecordings] = identity.recordings;
  return texts;
}

// The first line of two texts that differs, each as it is there.
std::pair<std::string, std::string> first_difference(std::string_view a, std::string_view b) {
  const auto line = [](std::string_view& text) {
    const std::size_t end = text.find('\n');
    const std::string_view first = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    return first;
  };
  while (!a.empty() || !b.empty()) {
    const std::string_view of_a = line(a);
    const std::string_view of_b = line(b);
    if (of_a != of_b) return {std::string(of_a), std::string(of_b)};
  }
  return {};
}

// A file that holds a map, but no run to go on with.
void require_resumable(const std::filesystem::path& path, const SavedMap& saved, const RunIdentity& identity) {
  if (!note_or_empty(saved, run_note::kMerged).empty()) {
    throw Error(fmt::format("{} was merged from two maps: there is no run to go on with; choose another file", path.string()));
  }
  if (!note_or_empty(saved, run_note::kRebuilt).empty()) {
    throw Error(
        fmt::format("{} was rebuilt with corrected poses, and what the recording says next would not fit them; choose "
                    "another file",
                    path.string()));
  }
  const std::string older =
      saved.format != kMapFormat ? std::to_string(saved.format) : note_or_empty(saved, run_note::kFromFormat);
  if (!older.empty()) {
    throw Error(
        fmt::format("{} was made in format {}, which tells less than a run needs to go on (the format is {} now): map the "
                    "recording anew, into another file",
                    path.string(), older, kMapFormat));
  }
  if (identity.online || !note_or_empty(saved, run_note::kOnline).empty()) {
    throw Error(fmt::format("{}: an online run cannot be resumed, for what it dropped depends on the moment; choose another file",
                            path.string()));
  }
}

void require_posed(const std::filesystem::path& path, const SavedMap& saved, const RunIdentity& identity) {
  if (!identity.tracked && note_or_empty(saved, run_note::kTracked).empty()) return;
  throw Error(
      fmt::format("{}: a run that tracked the camera cannot be resumed, for the file does not hold the tracker's memory; "
                  "choose another file",
                  path.string()));
}

void require_same_run(const std::filesystem::path& path, const SavedMap& saved, const RunIdentity& identity,
                      const LabelSet& labels) {
  for (const auto& [name, text] : texts_of(identity)) {
    const auto [before, now] = first_difference(note_or_empty(saved, name), text);
    if (before == now) continue;
    throw Error(
        fmt::format("{} is of another run: its {} is '{}', here it is '{}'; run with what it was made with, or choose another "
                    "file",
                    path.string(), name, before, now));
  }
  if (!same_labels(saved.map.labels, labels)) {
    throw Error(fmt::format("{} is of another run: its label set '{}' is not '{}' as it is now; choose another file",
                            path.string(), saved.map.labels.name(), labels.name()));
  }
}

void require_same_map(const std::filesystem::path& path, const SavedMap& saved, const MapOptions& map, const LabelSet& labels) {
  Options before;
  Options now;
  before.map = options_of(saved).map;
  now.map = map;
  if (const auto [a, b] = first_difference(options_text(before), options_text(now)); a != b) {
    throw Error(
        fmt::format("{} has another kind of map: there it says '{}', here '{}'; map with the options that it was made with",
                    path.string(), a, b));
  }
  if (!same_labels(saved.map.labels, labels)) {
    throw Error(fmt::format("{} has the label set '{}', which is not '{}' as it is now: map with that one", path.string(),
                            saved.map.labels.name(), labels.name()));
  }
}

}  // namespace

// A checkpoint that is being written.
struct Checkpoints::Pending {
  MapUpdate update;
  std::uint64_t log = 0;   // FrameLog::clock
  std::uint64_t anew = 0;  // MapperParts::times_anew
  std::size_t copies = 0;  // FrameLog::packed_bytes
  bool is_whole = true;    // else there is nothing but copies of frames
  BrickPool pool;
  std::vector<std::unique_ptr<VoxelBlock>> blocks;  // in that pool
};

std::string options_text(Options options) {
  std::string text;
  Fields recorded = fields(options);
  std::erase_if(recorded,
                [](const Field& field) { return field.key == "map.memory_limit_mb" || field.key == "map.swap_folder"; });
  std::string comments = to_toml(recorded);
  for (std::size_t begin = 0; begin < comments.size();) {
    const std::size_t end = std::min(comments.find('\n', begin), comments.size());
    const std::string_view line = std::string_view(comments).substr(begin, end - begin);
    if (!line.empty() && line.front() != '#') text.append(line).push_back('\n');
    begin = end + 1;
  }
  return text;
}

std::string to_text(const std::vector<RunRecording>& recordings) {
  std::string text;
  for (const RunRecording& r : recordings) {
    const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> pose = r.world_from_recording.matrix().topRows<3>();
    text += fmt::format("{}, frames {} from {} on, calibration '{}', predictions '{}', at {}\n", r.recording, r.frames,
                        r.first_number, r.calibration, r.predictions, fmt::join(pose.data(), pose.data() + pose.size(), " "));
  }
  return text;
}

Options options_of(const SavedMap& saved) {
  Options options;
  read_toml_text(note_or_empty(saved, run_note::kOptions), "the map file's options", fields(options));
  return options;
}

std::optional<Vec3d> noted_up(const SavedMap& saved) {
  return note_or_empty(saved, run_note::kUp).empty() ? std::nullopt : std::optional(up_of(saved));
}

FrameRecord record_of(const Frame& frame, bool labelled, const Outcome& outcome) {
  FrameRecord record{.frame = frame.index, .time_s = frame.time_s, .labelled = labelled, .unused_because = outcome.reason};
  if (is_finite(frame.world_from_camera)) record.world_from_camera = frame.world_from_camera;
  return record;
}

Checkpoints::Checkpoints(CheckpointSettings settings, const RunIdentity& identity, Mapper& mapper)
    : settings_(std::move(settings)), identity_(texts_of(identity)) {
  identity_[run_note::kProgram] = fmt::format("panoptic {}", version());
  if (identity.online) identity_[run_note::kOnline] = "1";
  if (identity.tracked) identity_[run_note::kTracked] = "1";
  mapper.parts().copy_to_file();
  const bool exists = is_there(settings_.path);
  if (exists && !settings_.resume) {
    throw Error(
        fmt::format("{} is there already: go on with it (--resume), choose another name or remove it", settings_.path.string()));
  }
  if (exists) {
    resume(identity, mapper);
    return;
  }
  if (settings_.earlier) begin_with(*settings_.earlier, identity, mapper);
  // With all that resuming needs from the first moment: the process may be killed at any.
  pending_ = copy(mapper, false);
  const MapHeader header{identity.options.map, mapper.map().labels};
  writer_ = std::make_unique<MapFileWriter>(MapFileWriter::create(settings_.path, header, pending_->update));
  collect();
}

void Checkpoints::resume(const RunIdentity& identity, Mapper& mapper) {
  MapLock lock(settings_.path);
  SavedMap saved = load_map(settings_.path, identity.options.map);
  require_resumable(settings_.path, saved, identity);
  require_posed(settings_.path, saved, identity);
  require_same_run(settings_.path, saved, identity, mapper.map().labels);
  MapperState state = load_state(settings_.path, saved);
  was_complete_ = is_complete(saved);
  writer_ = std::make_unique<MapFileWriter>(MapFileWriter::open(settings_.path, std::move(lock), saved));
  saved_epoch_ = saved.map.voxels.epoch();
  mapper.parts().restore(std::move(saved.map), std::move(state));
  saved_log_ = saved_images_ = mapper.parts().log().clock();
}

// All of it is new to the file that is made.
void Checkpoints::begin_with(const EarlierMap& earlier, const RunIdentity& identity, Mapper& mapper) {
  const MapLock lock(earlier.path);
  SavedMap saved = load_map(earlier.path, identity.options.map);
  require_resumable(earlier.path, saved, identity);
  require_same_map(earlier.path, saved, identity.options.map, mapper.map().labels);
  MapperState state = load_state(earlier.path, saved);
  if (positions_ != earlier.positions) {
    throw Error(fmt::format("{} was made of {} frames, and its recordings have {} now: put back what it was made of",
                            earlier.path.string(), positions_, earlier.positions));
  }
  if (!identity.recordings.starts_with(note_or_empty(saved, run_note::kRecordings))) {
    throw Error(fmt::format("{} was made of other recordings than its list names now: put the list back as it was",
                            earlier.path.string()));
  }
  mapper.parts().restore(std::move(saved.map), std::move(state));
  frames_ = resumed_frames_;
}

// Takes in the frames of a file, and gives the state of the mapper that it holds.
MapperState Checkpoints::load_state(const std::filesystem::path& path, const SavedMap& saved) {
  resumed_frames_ = load_frames(path);
  positions_ = resumed_frames_.size();
  if (positions_ > 0 && static_cast<std::uint64_t>(resumed_frames_.back().position) + 1 != positions_) {
    throw Error(fmt::format("{} lacks frames; the file is damaged: use another copy", path.string()));
  }
  MapperState state = mapper_state(saved, resumed_frames_, load_log(path));
  const std::optional<SpaceView>& last_view = saved.map.free_space.last_view();
  if (last_view && last_view->time >= state.frames.used()) {
    throw Error(
        fmt::format("{} lacks frames that its free space was seen from; the file is damaged: use another copy", path.string()));
  }
  return state;
}

Checkpoints::~Checkpoints() {
  if (is_writing()) writing_.wait();
}

std::int64_t Checkpoints::note(FrameRecord record) {
  const auto position = static_cast<std::int64_t>(positions_++);
  record.position = position;
  frames_.push_back(std::move(record));
  return position;
}

std::unique_ptr<Checkpoints::Pending> Checkpoints::copy(const Mapper& mapper, bool complete) {
  auto pending = std::make_unique<Pending>();
  const VoxelMap& map = mapper.map().voxels;
  const MapperParts& parts = mapper.parts();
  pending->update.epoch = map.epoch();
  pending->log = parts.log().clock();
  pending->anew = parts.times_anew();
  pending->copies = parts.log().packed_bytes();
  pending->update.anew = pending->anew != saved_anew_;
  pending->update.log = log_since(parts.log(), saved_log_, saved_images_);
  const std::uint64_t since = pending->update.anew ? 0 : saved_epoch_;
  for (const Slot slot : map.changed_since(since)) {
    pending->update.blocks.push_back({slot, map.index_of(slot), map.changed_at(slot), nullptr});
  }
  pending->blocks.resize(pending->update.blocks.size());
  parallel_for(pending->update.blocks.size(), [&](std::size_t i) {
    BlockCopy& block = pending->update.blocks[i];
    pending->blocks[i] = std::make_unique<VoxelBlock>(pending->pool);
    pending->blocks[i]->copy(map.block(block.slot));
    block.voxels = pending->blocks[i].get();
  });
  pending->update.space = space_since(mapper.map().free_space, since);
  pending->update.objects = mapper.map().objects;
  pending->update.history = mapper.map().history;
  pending->update.frames = std::exchange(frames_, {});
  pending->update.notes = notes_of(parts.state());
  pending->update.notes.texts.insert(identity_.begin(), identity_.end());
  pending->update.notes.texts[run_note::kUp] = up_text(mapper.up());
  pending->update.notes.texts[run_note::kPositions] = std::to_string(positions_);
  pending->update.notes.texts[run_note::kComplete] = complete ? "1" : "0";
  return pending;
}

// Copies of frames go ahead of the checkpoint that has these frames; until then nobody asks for them.
std::unique_ptr<Checkpoints::Pending> Checkpoints::copy_images(const FrameLog& log) const {
  auto pending = std::make_unique<Pending>();
  pending->update.log = log_since(log, saved_images_, saved_images_);
  pending->log = log.clock();
  pending->copies = log.packed_bytes();
  pending->is_whole = false;
  return pending;
}

// The pending checkpoint is through: in the file, or to be tried again, which writing_ tells by throwing.
void Checkpoints::collect() {
  if (is_writing()) writing_.wait();
  const std::unique_ptr<Pending> done = std::move(pending_);
  if (done->is_whole) since_last_ = Stopwatch();
  try {
    if (is_writing()) writing_.get();
    saved_images_ = done->log;
    saved_copies_ = done->copies;
    let_go_of_images(done->update.log, settings_.path);
    if (!done->is_whole) return;
    saved_epoch_ = done->update.epoch;
    saved_log_ = done->log;
    saved_anew_ = done->anew;
  } catch (...) {
    frames_.insert(frames_.begin(), std::make_move_iterator(done->update.frames.begin()),
                   std::make_move_iterator(done->update.frames.end()));
    throw;
  }
}

// More than `times` as many copies of frames as are written together wait for that.
bool Checkpoints::too_many_wait(const Mapper& mapper, std::size_t times) const {
  const FrameLog& log = mapper.parts().log();
  return log.copies() == LoggedCopies::kInFile && log.packed_bytes() - saved_copies_ > times * settings_.copies_bytes;
}

void Checkpoints::after_frame(const Mapper& mapper) {
  if (is_writing()) {
    const bool too_many = too_many_wait(mapper, kMostCopies);
    if (!too_many && writing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    try {
      collect();
    } catch (const std::exception& e) {
      if (too_many) throw;
      if (!std::exchange(warned_, true)) {
        settings_.warn(fmt::format("the map is not saved for now, mapping goes on: {}", e.what()));
      }
    }
  }
  if (since_last_.seconds() >= settings_.every_s) {
    pending_ = copy(mapper, false);
    writing_ = std::async(std::launch::async, [this] { writer_->write(pending_->update, false); });
  } else if (too_many_wait(mapper, warned_ ? kMostCopies : 1)) {
    pending_ = copy_images(mapper.parts().log());
    writing_ = std::async(std::launch::async, [this] { writer_->write_images(pending_->update.log); });
  }
}

void Checkpoints::finish(const Mapper& mapper, bool complete) {
  if (is_writing()) {
    try {
      collect();
    } catch (const std::exception&) {  // what it could not write is tried again now
    }
  }
  pending_ = copy(mapper, complete);
  writer_->write(pending_->update, true);
  collect();
  writer_->close();
  writer_.reset();
}

}  // namespace panoptic
