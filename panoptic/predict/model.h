// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The description of a network's input and output: the TOML file beside its weights (docs/networks.md).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "panoptic/labels.h"
#include "panoptic/predict/network.h"

namespace panoptic {

// The image that goes in: value = (pixel * scale - mean) / deviation per channel, pixel 0..255.
struct InputFormat {
  int width = 0;
  int height = 0;
  std::string channels = "rgb";    // or "bgr"
  std::string resize = "stretch";  // or "letterbox": keeps the aspect, image top left, the rest padded
  int pad_value = 0;               // 0..255, before normalisation
  double scale = 1.0 / 255;
  std::vector<double> mean{0, 0, 0};  // in the order of `channels`
  std::vector<double> std{1, 1, 1};
};

struct Thresholds {
  float score = 0.3F;       // instances below are dropped
  float nms_iou = 0.5F;     // of two boxes of one class that overlap more, the better one stays
  float mask = 0.5F;        // a pixel belongs to the object above
  int min_area_px = 1;      // smaller masks are dropped
  int max_instances = 100;  // per frame, the best ones
};

struct Model {
  std::filesystem::path path;  // the TOML file
  std::string name;
  std::string task;                            // "semantic", "instance" or "panoptic"; empty = as it is used
  std::string decoder;                         // empty = as the outputs look
  std::map<std::string, std::string> outputs;  // what the outputs do not say themselves
  std::string weights;
  std::string weights_opencv;  // where OpenCV needs other weights than ONNX Runtime; empty = the same
  std::vector<std::string> weights_folders;
  InputFormat input;
  Thresholds thresholds;
  std::vector<std::string> classes;                                      // in the network's order
  std::map<std::string, std::map<std::string, std::string>> class_maps;  // label set -> network class -> label set's class
};

// Reads and checks a model description; the weights are not touched. Throws Error naming file, line and remedy.
Model load_model(const std::filesystem::path& path);

// The file of weights for an engine: relative to the TOML file, then in $PANOPTIC_MODELS, then in weights_folders (relative
// to the TOML file). Throws Error naming every place tried.
std::filesystem::path find_weights(const Model& model, Engine engine);

// The class in the label set of each network class, kUnknown where it has none. Uses [class_map.<label set's name>], or else
// names that mean the same (class_names.h). Throws Error if the map names a class that does not exist, or if nothing maps.
std::vector<ClassId> map_classes(const Model& model, const LabelSet& labels);

}  // namespace panoptic
