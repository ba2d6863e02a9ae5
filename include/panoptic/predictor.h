// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// From a frame to what is in it: the other interface that users implement, and two that come with the library.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/labels.h"
#include "panoptic/options.h"
#include "panoptic/segmentation.h"

namespace panoptic {

// A predictor taken apart, for running its networks side by side: the first two may be called at once, each by one thread at a
// time. join(semantic(color), instances(color)) is what predict gives for a frame with that colour image (Eq. 1). Valid as long
// as the predictor lives.
struct PredictorHalves {
  std::function<Image<ClassId>(const ImageView<Rgb>& color)> semantic;
  std::function<std::vector<Instance>(const ImageView<Rgb>& color)> instances;
  std::function<Segmentation(const Image<ClassId>& semantic, const std::vector<Instance>& instances)> join;
};

// How predicting went, for the end of a run.
struct PredictorReport {
  std::vector<std::string> notes;  // one line each
  std::string trouble;             // why the predictions are of no use, in one line; empty if they are not
};

class Predictor {
 public:
  Predictor() = default;
  Predictor(const Predictor&) = delete;
  Predictor& operator=(const Predictor&) = delete;
  virtual ~Predictor() = default;

  // The classes that segments refer to.
  virtual const LabelSet& labels() const = 0;

  // Panoptic labels at the size of the frame's colour image (Eq. 1), or an empty segmentation where this frame has none.
  // Not thread-safe: one call at a time. Throws Error if the engine or a file fails.
  virtual Segmentation predict(const Frame& frame) = 0;

  // The two halves; nothing where predict is one piece. While halves are at work, predict is not to be called.
  virtual std::optional<PredictorHalves> halves() { return std::nullopt; }

  // Lines about the predictions so far that a person should read at once; each is given once. Any thread may ask.
  virtual std::vector<std::string> take_warnings() { return {}; }
  // Not while predict or a half is at work.
  virtual PredictorReport report() const { return {}; }
};

// The predictor of the paper: semantic networks (one or several) and an instance network, joined by Eq. 1. One network that finds
// both (queries with classes and masks) stands for the other where that is not given.
// Loads the networks and runs each once on an empty image, so that a network that does not fit its description is found here
// and not in the first frame. At least one of the two must be given. Throws Error.
std::unique_ptr<Predictor> make_network_predictor(const NetworkOptions& options, LabelSet labels);

// A predictor that reads earlier predictions: runs without networks that give the same map every time. `path` is a folder that
// PredictionWriter filled, or COCO panoptic: its JSON file or a folder with that as the only JSON file. Frames are found by
// Frame::index; a frame without prediction gives an empty segmentation. Without `labels` the predictions bring their own label
// set; with `labels`, our own format must have the same one and COCO categories are mapped to it by name. Among the options of
// joining (SegmentationOptions) only keep_whole_classes can still be chosen: pixels behind the instances in front are not in
// the file. Throws Error naming the file that is missing, damaged or of another size than the frame.
std::unique_ptr<Predictor> make_file_predictor(const std::filesystem::path& path, const std::optional<LabelSet>& labels = {},
                                               bool keep_whole_classes = true);

// The predictor that the options ask for: the prediction folder, else the networks, else nullptr (geometry and colour alone).
// Throws Error.
std::unique_ptr<Predictor> make_predictor(const Options& options);

// The same for the frames of this dataset: if the options name neither and it is a list of recordings (docs/datasets.md), the
// predictions that the list names for each.
class Dataset;
std::unique_ptr<Predictor> make_predictor(const Options& options, const Dataset& dataset);

// The label set of a run: the predictor's, or without one what the options name.
LabelSet labels_of(const Options& options, const Predictor* predictor);

}  // namespace panoptic
