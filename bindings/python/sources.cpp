// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/source.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "bindings/python/arrays.h"
#include "bindings/python/bind.h"
#include "panoptic/bag.h"
#include "panoptic/simulation.h"

namespace panoptic::python {
namespace {

// Frames of a dataset in order, decoded ahead.
class Frames {
 public:
  Frames(std::shared_ptr<Dataset> dataset, const FrameRange& range)
      : dataset_(std::move(dataset)),
        left_(range.count(dataset_->size())),
        stream_(std::make_unique<FrameStream>(*dataset_, range)) {}

  std::shared_ptr<Frame> next() {
    const Use use(use_);
    while (left_ > 0) {
      std::optional<ReadResult> read = released([&] { return stream_->next(); });
      if (!read) break;
      --left_;
      if (read->frame) return std::make_shared<Frame>(kept(std::move(*read->frame)));
      skipped_.emplace_back(read->skipped.index, read->skipped.reason);
    }
    throw py::stop_iteration();
  }
  std::size_t left() const { return left_; }
  const std::vector<std::pair<std::int64_t, std::string>>& skipped() const { return skipped_; }

 private:
  std::shared_ptr<Dataset> dataset_;  // outlives the stream
  std::size_t left_;
  WithThreads<FrameStream> stream_;
  Exclusive use_{"sequence of frames"};
  std::vector<std::pair<std::int64_t, std::string>> skipped_;
};

std::size_t position_in(const Dataset& dataset, std::int64_t position) {
  const auto size = static_cast<std::int64_t>(dataset.size());
  if (position < 0) position += size;
  if (position < 0 || position >= size) throw py::index_error(fmt::format("there are {} frames", size));
  return static_cast<std::size_t>(position);
}

std::shared_ptr<Frame> read(const Dataset& dataset, std::int64_t position) {
  const std::size_t at = position_in(dataset, position);
  ReadResult result = released([&] { return dataset.read(at); });
  if (!result.frame) throw Error(fmt::format("frame {}: {}", result.skipped.index, result.skipped.reason));
  return std::make_shared<Frame>(kept(std::move(*result.frame)));
}

py::object pose(const Dataset& dataset, std::int64_t position) {
  const std::optional<Pose> known = dataset.pose(position_in(dataset, position));
  return known ? py::object(matrix_of(*known)) : py::none();
}

py::dict notes(const Dataset& dataset) {
  const RecordingNotes notes = dataset.notes();
  return py::dict(py::arg("assumed") = notes.assumed, py::arg("left_out") = notes.left_out,
                  py::arg("depth_scale") = notes.depth_scale);
}

std::shared_ptr<Dataset> open(const std::filesystem::path& recording, const std::optional<std::filesystem::path>& calibration,
                              std::optional<double> pair_tolerance_s, bool poses) {
  const std::filesystem::path camera = calibration.value_or(std::filesystem::path());
  const bool is_simulated = recording.string().starts_with("sim:");
  return released([&] {
    return std::shared_ptr<Dataset>(poses || is_simulated ? open_dataset(recording.string(), camera, pair_tolerance_s)
                                                          : open_without_poses(recording, camera, pair_tolerance_s));
  });
}

py::dict listing(const std::filesystem::path& path) {
  const BagListing bag = released([&] { return list_bag(path); });
  py::list topics;
  for (const ListedTopic& topic : bag.topics) {
    topics.append(py::dict(py::arg("name") = topic.name, py::arg("type") = topic.type, py::arg("messages") = topic.messages,
                           py::arg("role") = topic.role, py::arg("note") = topic.note));
  }
  return py::dict(py::arg("container") = bag.container, py::arg("begin_s") = bag.begin_s, py::arg("end_s") = bag.end_s,
                  py::arg("topics") = topics, py::arg("left_out") = bag.left_out);
}

}  // namespace

void bind_sources(py::module_& m) {
  py::class_<Frames, std::shared_ptr<Frames>>(m, "Frames", "Frames of a dataset in order, decoded ahead on another thread.")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", &Frames::next)
      .def("__len__", &Frames::left, "Positions that are left, for progress bars: unusable frames count too.")
      .def_property_readonly("skipped", &Frames::skipped, "(number, reason) of each frame so far that could not be used.");

  py::class_<Dataset, std::shared_ptr<Dataset>>(m, "Dataset",
                                                R"(A recording of posed RGB-D frames: iterate over it, or dataset[position].

A frame that cannot be used is left out when iterating, and listed in frames().skipped; dataset[position] raises Error for it.)")
      .def_property_readonly("description", &Dataset::description)
      .def("__len__", &Dataset::size)
      .def("__getitem__", &read, py::arg("position"))
      .def("pose", &pose, py::arg("position"),
           "(4, 4) float64 world_from_camera without decoding the images; None where it cannot be used.")
      .def_property_readonly(
          "notes", &notes,
          R"(What no file says and was assumed, files that were left out, and depth_scale: raw / depth_scale = metres, 0 = not known.)")
      .def("__iter__", [](std::shared_ptr<Dataset> d) { return std::make_shared<Frames>(std::move(d), FrameRange{}); })
      .def(
          "frames",
          [](std::shared_ptr<Dataset> d, const std::string& range) {
            return std::make_shared<Frames>(std::move(d), range.empty() ? FrameRange{} : parse_frame_range(range));
          },
          py::arg("range") = "", R"(The frames at positions "A:B:STEP", each part optional, B excluded.)")
      .def("__repr__", [](const Dataset& d) { return fmt::format("<Dataset {}>", d.description()); });

  m.def(
      "open_dataset", &open, py::arg("path"), py::arg("calibration") = py::none(), py::arg("pair_tolerance_s") = py::none(),
      py::arg("poses") = true,
      R"(Opens a recording (ScanNet, TUM RGB-D, phones, bags of ROS, plain folders ...), or a simulated home: open_dataset("sim:7,rooms=2").

Of a bag with several topics for one role: "walk.bag?depth=/d,color=/c". calibration: a TOML file that overrides what the recording
says. pair_tolerance_s: how far the stamps of a pair of images may differ. poses=False: the recording needs none, and those it has are
left out (simulated ones stay): a CameraTracker finds them.)");
  m.def("list_bag", &listing, py::arg("path"),
        "What is in a bag of ROS: container, begin_s, end_s, topics (each with name, type, messages, role, note), left_out.");
}

}  // namespace panoptic::python
