// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/recording_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "panoptic/base/config.h"
#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/calibration.h"
#include "panoptic/io/image_names.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr double kFarthest_m = 1e4;  // single floats still tell millimetres there
constexpr double kLongest_s = 1e6;
constexpr double kPause_s = 2;  // longer than anything that moves is waited for: what is seen then is not followed from before

// An entry as TOML has it.
struct Entry {
  std::string path;
  std::string calibration;
  std::optional<double> pair_tolerance_s;
  std::string predictions;
  bool tracked = false;
  std::vector<double> rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::vector<double> translation = {0, 0, 0};
};

Fields fields(Entry& e) {
  return {{"path", &e.path, "the recording, or sim:SEED...", required()},
          {"calibration", &e.calibration, "TOML file that overrides what the format says", {}},
          {"pair_tolerance_s", &e.pair_tolerance_s, "between colour and depth of a pair", in_range(0, kLongest_s)},
          {"predictions", &e.predictions, "folder of its predictions", {}},
          {"tracked", &e.tracked, "its camera was tracked: its own poses are not read", {}},
          {"rotation", &e.rotation, "of the recording in the common world, 9 numbers, row by row", {}},
          {"translation", &e.translation, "where its origin lies there, 3 numbers, metres", in_range(-kFarthest_m, kFarthest_m)}};
}

// Paths in the file are relative to it.
std::string beside(const fs::path& file, const std::string& path) {
  if (path.empty() || path.starts_with("sim:")) return path;
  return (fs::absolute(file).parent_path() / path).lexically_normal().string();
}

ListedRecording to_listed(const Entry& entry, const fs::path& file) {
  return {entry.path,
          beside(file, entry.path),
          beside(file, entry.calibration),
          entry.pair_tolerance_s,
          beside(file, entry.predictions),
          entry.tracked,
          pose_of(entry.rotation, entry.translation, fmt::format("{}: {}: ", file.string(), entry.path))};
}

std::int64_t number_of(const ReadResult& read) { return read.frame ? read.frame->index : read.skipped.index; }

// The time stamp of the first frame that can be read, from the beginning or from the end; 0 if there is none.
double time_at(const Dataset& dataset, bool from_end) {
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    const ReadResult read = dataset.read(from_end ? dataset.size() - 1 - i : i);
    if (read.frame) return read.frame->time_s;
  }
  return 0;
}

// Refuses what the command line gives for one recording where a list gives it for each.
void refuse_for_list(const fs::path& list, const fs::path& calibration, std::optional<double> pair_tolerance_s) {
  if (!calibration.empty()) {
    throw Error(fmt::format("{}: a list says the calibration of each of its recordings; write {} there", list.string(),
                            calibration.string()));
  }
  if (pair_tolerance_s) {
    throw Error(
        fmt::format("{}: a list says pair_tolerance_s of each of its recordings; leave out --pair-tolerance", list.string()));
  }
}

}  // namespace

bool is_recording_list(const fs::path& path) { return ending_of(path) == ".toml" && is_file(path); }

std::vector<ListedRecording> read_recording_list(const fs::path& path) {
  std::vector<Entry> entries;
  const AppendTable append = [&]() -> Fields { return fields(entries.emplace_back()); };
  read_toml_file(path, {{"recording", append, "a recording of the list", required()}});
  std::vector<ListedRecording> listed;
  for (const Entry& entry : entries) listed.push_back(to_listed(entry, path));
  if (listed.empty())
    throw Error(fmt::format("{}: names no recording; give one [[recording]] with a path for each", path.string()));
  return listed;
}

std::string to_toml(const std::vector<ListedRecording>& recordings) {
  std::string text;
  for (const ListedRecording& r : recordings) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = r.world_from_recording.linear();
    const Vec3d translation = r.world_from_recording.translation();
    Entry entry{r.recording,
                r.calibration,
                r.pair_tolerance_s,
                r.predictions,
                r.tracked,
                {rotation.data(), rotation.data() + rotation.size()},
                {translation.data(), translation.data() + translation.size()}};
    text += "[[recording]]\n" + to_toml(fields(entry)) + "\n";
  }
  return text;
}

void require_posed(const ListedRecording& recording) {
  if (!recording.tracked) return;
  throw Error(fmt::format(
      "{}: its camera was tracked (tracked = true), so it has poses in the map that was made of this list alone; go on "
      "from that map (--in), or leave out tracked to take the poses of the recording",
      recording.name));
}

RecordingList::RecordingList(const fs::path& path, const OpenListed& open) {
  for (ListedRecording& listed : read_recording_list(path)) {
    try {
      append(std::move(listed), open);
    } catch (const Error& e) {
      throw Error(fmt::format("{}: {}", path.string(), e.what()));
    }
  }
}

void RecordingList::append(ListedRecording listed, const OpenListed& open) {
  if (is_recording_list(listed.recording)) throw Error(fmt::format("{} is a list itself; name its recordings here", listed.name));
  if (!listed.predictions.empty() && !is_there(listed.predictions)) {
    throw Error(fmt::format("there are no predictions at {}: check the path", listed.predictions));
  }
  Part part{std::move(listed), nullptr, size_, 0, 0, 0};
  part.dataset = open(part.listed);
  const std::size_t frames = part.dataset->size();
  if (frames == 0) throw Error(fmt::format("{} has no frames; leave it out of the list", part.listed.name));
  const std::int64_t last = number_of(part.dataset->read(frames - 1));
  if (!parts_.empty()) {
    part.first_number = parts_.back().last_number + 1;
    part.time_shift_s = last_time_s_ + kPause_s - time_at(*part.dataset, false);
  }
  if (last < 0 || last >= std::numeric_limits<std::int64_t>::max() - part.first_number) {
    throw Error(fmt::format("{}: its last frame has the number {}, behind which no others can go on", part.listed.name, last));
  }
  part.last_number = part.first_number + last;
  last_time_s_ = time_at(*part.dataset, true) + part.time_shift_s;
  size_ += frames;
  parts_.push_back(std::move(part));
}

std::string RecordingList::description() const {
  std::string text = fmt::format("{} recordings, {} frames", parts_.size(), size_);
  for (const Part& part : parts_) text += fmt::format("; {}: {}", part.listed.name, part.dataset->description());
  return text;
}

const RecordingList::Part& RecordingList::part_of(std::size_t position) const {
  PANOPTIC_ASSERT(position < size_);
  const auto after = std::upper_bound(parts_.begin(), parts_.end(), position,
                                      [](std::size_t p, const Part& part) { return p < part.first_position; });
  return *(after - 1);
}

ReadResult RecordingList::read(std::size_t position) const {
  const Part& part = part_of(position);
  ReadResult result = part.dataset->read(position - part.first_position);
  const std::int64_t own = number_of(result);
  const std::int64_t number = part.first_number + own;
  if (own < 0 || number > part.last_number) {
    return {std::nullopt,
            {part.last_number, fmt::format("not in the order of the recording: frame {} of {}", own, part.listed.name)}};
  }
  result.skipped.index = number;
  if (!result.frame) return result;
  result.frame->index = number;
  result.frame->time_s += part.time_shift_s;
  result.frame->world_from_camera = part.listed.world_from_recording * result.frame->world_from_camera;
  return result;
}

std::optional<Pose> RecordingList::pose(std::size_t position) const {
  const Part& part = part_of(position);
  std::optional<Pose> pose = part.dataset->pose(position - part.first_position);
  if (pose) *pose = part.listed.world_from_recording * *pose;
  return pose;
}

RecordingNotes RecordingList::notes() const {
  RecordingNotes all;
  const auto append_named = [](const std::string& name, const std::vector<std::string>& lines, std::vector<std::string>& to) {
    for (const std::string& line : lines) to.push_back(fmt::format("{}: {}", name, line));
  };
  for (const Part& part : parts_) {
    const RecordingNotes notes = part.dataset->notes();
    append_named(part.listed.name, notes.assumed, all.assumed);
    append_named(part.listed.name, notes.left_out, all.left_out);
  }
  return all;
}

const RecordingList* as_recording_list(const Dataset& dataset) { return dynamic_cast<const RecordingList*>(&dataset); }

std::unique_ptr<Dataset> open_recording_list(const fs::path& path, const fs::path& calibration,
                                             std::optional<double> pair_tolerance_s, const OpenListed& open) {
  refuse_for_list(path, calibration, pair_tolerance_s);
  return std::make_unique<RecordingList>(path, open);
}

}  // namespace panoptic
