// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Decoders turn output tensors into classes per pixel or into instances. To add a decoder, write a function of one of the two
// types and give it a line in the table in decoders.cpp; model descriptions name it (`decoder = "..."`).
#pragma once

#include <vector>

#include "panoptic/predict/model.h"
#include "panoptic/predict/preprocess.h"
#include "panoptic/segmentation.h"

namespace panoptic {

struct DecodeContext {
  const Model& model;
  const std::vector<ClassId>& class_of;  // per network class, see map_classes
  Placement placement;
  bool likeliest_first = false;  // semantic networks: their classes stay apart until the likeliest is chosen (the paper)
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

// The mean of several networks' scores, on the finest of their grids; a class that a network lacks has probability 0 there.
// Networks have only the label set in common, so where a network has several values for one class, its highest one stands for
// it. Probabilities of kUnknown are multiplied with unknown_share. REQUIRES at least one.
ClassScores average(std::vector<ClassScores> networks, float unknown_share);

// The class of each pixel: that of its likeliest value after bilinear interpolation between the cells; ties go to the value
// listed first.
Image<ClassId> most_likely(const ClassScores& scores, int image_width, int image_height);

// Each throws Error if the tensors are not what the decoder reads: wrong number, shapes, or class count.
using SemanticDecoder = ClassScores (*)(const std::vector<Tensor>& outputs, const DecodeContext& context);
using InstanceDecoder = std::vector<Instance> (*)(const std::vector<Tensor>& outputs, const DecodeContext& context);

// The decoder that the model names. Throws Error listing those that exist for the task.
SemanticDecoder semantic_decoder(const Model& model);
InstanceDecoder instance_decoder(const Model& model);

// Decodes one output, logits 1 x classes x any height x any width. Softmax over the network's classes.
ClassScores decode_semantic_logits(const std::vector<Tensor>& outputs, const DecodeContext& context);

// Decodes YOLOv8-seg before its own post-processing, S strides: S box distributions (4 sides x bins), S class logits, S mask
// coefficients, prototypes. Returns instances by descending score. class_of must hold things only; other classes count as
// unknown.
std::vector<Instance> decode_yolo_seg(const std::vector<Tensor>& outputs, const DecodeContext& context);

}  // namespace panoptic
