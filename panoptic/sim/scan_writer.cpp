// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/scan_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/io/dynamics.h"
#include "panoptic/io/scannet_scan.h"

namespace panoptic {
namespace {

constexpr std::size_t kTruthFrames = 600;  // in about as many frames a hand-held camera has seen everything it sees

std::size_t truth_stride(const ExportOptions& options, std::size_t frames) {
  if (options.truth_stride > 0) return static_cast<std::size_t>(options.truth_stride);
  return std::max<std::size_t>(frames / kTruthFrames, 1);
}

std::vector<std::uint8_t> label_png(const Image<ClassId>& class_id) {
  constexpr std::size_t kClasses = 64;
  std::array<std::uint16_t, kClasses> category{};
  for (std::uint16_t i = 0; i < kClasses; ++i) category[i] = scannet_category(static_cast<ClassId>(i));
  Image<std::uint16_t> image(class_id.width(), class_id.height());
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = category[std::min<std::size_t>(number(class_id[i]), kClasses - 1)];
  return encode_png(image);
}

// 8 bits as in ScanNet, or 16 where a home has more things than that.
std::vector<std::uint8_t> instance_png(const Image<std::uint16_t>& instance, std::uint16_t highest) {
  if (highest > std::numeric_limits<std::uint8_t>::max()) return encode_png(instance);
  Image<std::uint8_t> image(instance.width(), instance.height());
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<std::uint8_t>(instance[i]);
  return encode_png(image);
}

std::uint16_t highest_instance(const MovingHome& world) {
  std::uint16_t highest = 0;
  for (const SceneObject& object : world.home.scene.objects) highest = std::max(highest, object.instance);
  for (const Mover& mover : world.movers) highest = std::max(highest, mover.instance);
  return highest;
}

// White where people and pets are.
std::vector<std::uint8_t> moving_png(const Rendering& rendering) {
  Image<std::uint8_t> image(rendering.depth.width(), rendering.depth.height());
  for (std::size_t i = 0; i < rendering.fate.size(); ++i) image[i] = rendering.fate[i] == Fate::kMoves ? 255 : 0;
  return encode_png(image);
}

// Number, then the rows of world_from_camera.
std::string pose_line(std::size_t position, const Pose& pose) {
  std::string line = fmt::format("{}", position);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) fmt::format_to(std::back_inserter(line), " {:.9g}", pose.matrix()(row, column));
  }
  return line + "\n";
}

constexpr const char* kIdentityText = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";

std::string meta_text(const Simulation& simulation) {
  const Camera& c = simulation.camera();
  std::string text = fmt::format("axisAlignment = {}\ncolorHeight = {}\ncolorToDepthExtrinsics = {}\ncolorWidth = {}\n",
                                 kIdentityText, c.height, kIdentityText, c.width);
  text += fmt::format("depthHeight = {}\ndepthWidth = {}\n", c.height, c.width);
  for (const char* camera : {"color", "depth"}) {
    text +=
        fmt::format("fx_{0} = {1:.9g}\nfy_{0} = {2:.9g}\nmx_{0} = {3:.9g}\nmy_{0} = {4:.9g}\n", camera, c.fx, c.fy, c.cx, c.cy);
  }
  return text + fmt::format("numColorFrames = {0}\nnumDepthFrames = {0}\nnumIMUmeasurements = 0\nsceneType = Apartment\n",
                            simulation.size());
}

}  // namespace

ExportedFrame make_frame(const Simulation& simulation, const ExportOptions& options, std::size_t position) {
  SimulatedFrame simulated = simulation.simulate(position);
  ExportedFrame frame;
  frame.position = position;
  frame.sens = encode_sens_frame(simulated.frame, options.jpeg_quality);
  frame.label_png = label_png(simulated.rendering.class_id);
  frame.instance_png = instance_png(simulated.rendering.instance, highest_instance(simulation.world()));
  if (simulation.moves()) frame.moving_png = moving_png(simulated.rendering);
  if (options.predictions != "none") {
    frame.prediction = predict_with_noise(options.prediction_noise, simulation.options().seed, simulated, simulation.labels());
  }
  frame.reported_pose = simulated.frame.world_from_camera;
  frame.true_pose = simulated.true_world_from_camera;
  if (position % truth_stride(options, simulation.size()) == 0) frame.truth = std::move(simulated);
  return frame;
}

ScanWriter::ScanWriter(std::filesystem::path folder, const Simulation& simulation, const ExportOptions& options)
    : folder_(std::move(folder)),
      simulation_(simulation),
      scene_(scene_name(simulation.options().seed)),
      sens_(stem(".sens"), simulation.camera()),
      labels_(stem("_2d-label.zip")),
      instances_(stem("_2d-instance.zip")) {
  if (simulation.moves()) require_writable_folder(folder_ / kMovingFolder);
  if (options.predictions == "none") return;
  predictions_.emplace(folder_ / "predictions", simulation.labels(),
                       fmt::format("simulated, preset {}, seed {}", options.predictions, simulation.options().seed));
}

std::filesystem::path ScanWriter::stem(const std::string& suffix) const { return folder_ / (scene_ + suffix); }

void ScanWriter::write(const ExportedFrame& frame) {
  sens_.write(frame.sens);
  labels_.add(fmt::format("label/{}.png", frame.position), frame.label_png);
  instances_.add(fmt::format("instance/{}.png", frame.position), frame.instance_png);
  if (!frame.moving_png.empty()) {
    write_file(folder_ / kMovingFolder / moving_mask_name(static_cast<std::int64_t>(frame.position)), frame.moving_png);
  }
  if (predictions_) predictions_->write(static_cast<std::int64_t>(frame.position), frame.prediction);
  if (frame.truth) truth_.add(*frame.truth);
  true_poses_ += pose_line(frame.position, frame.true_pose);
  drifted_ = drifted_ || !frame.reported_pose.isApprox(frame.true_pose, 1e-12);
}

void ScanWriter::finish() {
  sens_.finish();
  labels_.finish();
  instances_.finish();
  if (drifted_) write_file(stem("_true_poses.txt"), true_poses_);
  write_file(stem(".txt"), meta_text(simulation_));
  write_scan_truth(folder_, truth_.finish(simulation_));
}

}  // namespace panoptic
