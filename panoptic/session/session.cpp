// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/session/session.h"

#include <utility>

#include "panoptic/base/error.h"
#include "panoptic/fusion/reference_labels.h"
#include "panoptic/predict/predictor_files.h"

namespace panoptic {

Session::Session(const Options& options, LabelSet labels)
    : labels_(std::move(labels)),
      map_(options.map),
      objects_(labels_.first_thing()),
      registration_(options.depth),
      tracker_(options.tracker, labels_),
      integrator_(options.integrator, map_),
      mesher_(options.mesher) {}

std::optional<std::string> Session::add(const Frame& frame, const Segmentation& segmentation) {
  std::optional<std::string> reason = why_unusable(frame);
  if (!reason) {
    if (const char* why = why_unusable(segmentation, frame.color.width(), frame.color.height())) reason = why;
  }
  if (reason) {
    frames_.count_skipped({frame.index, *reason});
    return reason;
  }
  const Stopwatch fusion;
  double before = 0;
  const auto stage_done = [&](const char* name) {
    profile_.add(name, fusion.seconds() - std::exchange(before, fusion.seconds()));
  };

  const RegisteredFrame& registered = registration_.apply(frame, segmentation);
  stage_done("register");
  reference_labels(map_, frame, registered, reference_);  // Eq. 2
  stage_done("reference");
  const auto& ids = tracker_.assign(registered, segmentation.segments, reference_, frame.index, objects_);  // Eq. 3-5, 12
  stage_done("track");
  integrator_.integrate(frame, registered, ids, map_);  // Eq. 6-11
  stage_done("integrate");
  profile_.add("fusion", fusion.seconds());

  up_sum_ -= frame.world_from_camera.linear().col(1);
  frames_.count_used();
  return std::nullopt;
}

Mesh Session::mesh() {
  const Stopwatch stopwatch;
  mesher_.update(map_);
  Mesh mesh = mesher_.assemble(map_, objects_, labels_);
  profile_.add("mesh", stopwatch.seconds());
  return mesh;
}

Vec3d Session::up() const { return up_sum_.norm() > 0 ? Vec3d(up_sum_.normalized()) : Vec3d(-Vec3d::UnitY()); }

std::unique_ptr<Predictor> make_predictor(const Options& options) {
  const bool networks = !options.networks.semantic.empty() || !options.networks.instance.empty();
  if (!options.predictions.empty() && networks) {
    throw Error("both a prediction folder and networks are given; choose one");
  }
  if (!options.predictions.empty()) return make_file_predictor(options.predictions);
  if (networks) return make_network_predictor(options.networks, load_label_set(options.labels));
  return nullptr;
}

LabelSet labels_of(const Options& options, const Predictor* predictor) {
  return predictor != nullptr ? predictor->labels() : load_label_set(options.labels);
}

}  // namespace panoptic
