// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Decoders turn output tensors into classes per pixel, into instances, or into both. A network's outputs say themselves what they
// are: recognise() tells from names, shapes and ranges which decoder reads them and how. To add a decoder, write a function that
// recognises its outputs and one that decodes them, and give both a line in the table in decoders.cpp; a model description may
// name it (`decoder = "..."`).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/predict/model.h"
#include "panoptic/predict/preprocess.h"
#include "panoptic/segmentation.h"

namespace panoptic {

struct DecodeContext {
  const Model& model;
  const std::vector<ClassId>& class_of;  // per network class, see map_classes
  Placement placement;
  bool likeliest_first = false;      // semantic networks: their classes stay apart until the likeliest is chosen (the paper)
  const LabelSet* labels = nullptr;  // networks for both: only things have instances; nullptr: all classes do

  // The class of instances of a network class: its counterpart, if that is a thing.
  ClassId thing_of(std::size_t network_class) const {
    const ClassId id = class_of[network_class];
    return labels == nullptr || labels->is_thing(id) ? id : ClassId::kUnknown;
  }
};

// Probabilities on a grid over the image, at the network's own resolution, so that several networks can be averaged before a
// pixel's class is chosen. Either one value per class of the label set, in which the probabilities of all network classes with
// this counterpart are added; or, likeliest first, one value per network class.
struct ClassScores {
  std::vector<ClassId> classes;  // of each value, what it is in the label set; kUnknown: network classes without a counterpart
  int width = 0;                 // of the grid
  int height = 0;
  double cells_per_px_x = 1;  // grid = (image + 0.5) * cells_per_px - 0.5
  double cells_per_px_y = 1;
  std::vector<float> values;  // row by row, the classes of one cell side by side
};

// The positions of some classes' values in a list `classes` that is made here: each class once, kUnknown first.
std::vector<std::size_t> positions_of(const std::vector<ClassId>& class_of, std::vector<ClassId>& classes);

// The mean of several networks' scores, on the finest of their grids; a class that a network lacks has probability 0 there.
// Networks have only the label set in common, so where a network has several values for one class, its highest one stands for
// it. Probabilities of kUnknown are multiplied with unknown_share. REQUIRES at least one.
ClassScores average(std::vector<ClassScores> networks, float unknown_share);

// The class of each pixel: that of its likeliest value after bilinear interpolation between the cells; ties go to the value
// listed first. Where no value is above 0 the network says nothing, and the pixel is unknown.
Image<ClassId> most_likely(const ClassScores& scores, int image_width, int image_height);

// How class values are meant.
enum class Numbers { kLogits, kProbabilities, kClassNumbers };

// The number that a network gives to the first of its classes in detections.
enum class LabelsFrom { kZero, kOne, kCoco };  // kCoco: the category numbers of COCO, 1 to 90 with gaps, for its 80 classes

// How the outputs of a network are read. Made anew for every frame: it depends on nothing but shapes and, where those leave
// several possibilities, on values.
struct Reading {
  std::string_view decoder;        // its name in descriptions
  std::string_view task;           // "semantic", "instance" or "panoptic"
  std::string text;                // for a person
  std::vector<std::size_t> roles;  // the outputs in the order that the decoder wants them
  Numbers numbers = Numbers::kLogits;
  bool channels_last = false;
  int width = 0;  // semantic: of the grid
  int height = 0;
  int form = 0;             // a decoder's own variants
  bool masks_last = false;  // prototypes: height x width x masks
  LabelsFrom labels_from = LabelsFrom::kZero;
};

// The answer of a recogniser: how to read the outputs, or why they are not of its kind. `choices` is not empty where they may be
// read in several ways, and says how to choose.
struct Match {
  std::optional<Reading> reading = {};
  std::string why_not = {};
  std::string choices = {};
};

// The findings in one frame. A network of instances has no scores, a semantic one no instances.
struct Findings {
  std::optional<ClassScores> scores = {};
  std::vector<Instance> instances = {};
};

// Finds out what the outputs are. `task` is what the network is used for. Throws Error naming the model's file: nothing fits
// (with the reasons), several things do (with the choices), or what fits is for another task.
Reading recognise(const std::vector<Tensor>& outputs, const Model& model, std::string_view task);

// Reads the outputs of one frame as recognise() said. class_of must hold things only where instances are meant; other classes
// count as unknown there. Instances come by descending score.
Findings decode(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context);

// The decoders' own functions; recognise() and decode() call them.
Match recognise_semantic(const std::vector<Tensor>& outputs, const Model& model);
Findings decode_semantic(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context);
Match recognise_yolo(const std::vector<Tensor>& outputs, const Model& model);
Findings decode_yolo(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context);
Match recognise_mask_rcnn(const std::vector<Tensor>& outputs, const Model& model);
Findings decode_mask_rcnn(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context);
Match recognise_queries(const std::vector<Tensor>& outputs, const Model& model);
Findings decode_queries(std::vector<Tensor> outputs, const Reading& reading, const DecodeContext& context);

}  // namespace panoptic
