// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A network with its description: from a colour image to what its decoder finds, and a watch over what it gives.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/options.h"
#include "panoptic/predict/decoders.h"
#include "panoptic/predict/model.h"
#include "panoptic/predict/network.h"

namespace panoptic {

class NetworkStage {
 public:
  // Loads the network and runs it once on an empty image. `task` is what it is used for: "semantic" or "instance". Throws Error
  // if it does not fit its description, or its outputs are not understood.
  NetworkStage(Model model, std::string_view task, const NetworkOptions& options, const LabelSet& labels);

  // One call at a time.
  Findings run(const ImageView<Rgb>& color);

  const Model& model() const { return model_; }
  const Network& network() const { return network_; }
  const Reading& reading() const { return reading_; }  // of the last image
  const std::vector<ClassId>& class_of() const { return class_of_; }

  // Whether its instances and its scores count beside those of other networks; both by default.
  bool gives_instances = true;
  bool gives_scores = true;

  // Lines that a person should read at once; each line is given once. Any thread may ask.
  std::vector<std::string> take_warnings();
  // Why nothing of what it gave so far is to be trusted; empty if that is not so.
  std::string trouble() const;
  // Its classes without a counterpart, with their shares of the pixels; empty if there are none.
  std::string unmatched() const;

 private:
  void warm_up();
  Findings read(std::vector<Tensor> outputs, const ImageView<Rgb>& color) const;
  void watch(const Findings& findings);
  void count_unmatched(const std::vector<Tensor>& outputs, const ImageView<Rgb>& color);
  void warn(std::string what);

  Model model_;
  std::string task_;
  const LabelSet labels_;
  std::vector<ClassId> class_of_;
  std::vector<ClassId> things_;  // the same, kUnknown where a class is no thing
  bool likeliest_first_;
  float unknown_share_;
  Network network_;
  Reading reading_;

  std::uint64_t frames_ = 0;
  std::uint64_t not_finite_ = 0;  // frames
  std::uint64_t silent_ = 0;      // frames in which nothing counted
  std::vector<std::uint64_t> cells_of_class_;
  mutable std::mutex mutex_;
  std::vector<std::string> warnings_;
};

}  // namespace panoptic
