// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/pictures.h"

#include <vector>

#include "panoptic/base/image_io.h"

namespace panoptic {
namespace {

constexpr int kJpegQuality = 80;

std::vector<std::uint8_t> overlay_of(const Image<PanopticId>& ids, const LabelSet& labels) {
  Image<Rgb> color(ids.width(), ids.height());
  Image<std::uint8_t> alpha(ids.width(), ids.height());
  PanopticId last = PanopticId::kUnknown;
  Rgb last_color;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const PanopticId id = ids[i];
    if (id == PanopticId::kUnknown) continue;
    if (id != last) last_color = color_of(id, labels);
    last = id;
    color[i] = last_color;
    alpha[i] = 255;
  }
  return encode_png(color, alpha);
}

}  // namespace

template <typename Pixels, typename Encode>
std::shared_ptr<const std::string> FramePictures::once(Encoded& slot, const std::shared_ptr<const Pixels>& image, Encode encode) {
  if (image == nullptr || image->empty()) return nullptr;
  const std::lock_guard lock(mutex_);
  if (slot.image.lock() != image) {
    const std::vector<std::uint8_t> bytes = encode(*image);
    slot = {image, std::make_shared<const std::string>(bytes.begin(), bytes.end())};
  }
  return slot.bytes;
}

std::shared_ptr<const std::string> FramePictures::frame_jpeg(const SnapshotFrame& frame) {
  return once(frame_, frame.color, [](const ImageView<Rgb>& image) { return encode_jpeg(image, kJpegQuality); });
}

std::shared_ptr<const std::string> FramePictures::labelled_jpeg(const SnapshotFrame& frame) {
  return once(labelled_, frame.labelled_color, [](const ImageView<Rgb>& image) { return encode_jpeg(image, kJpegQuality); });
}

std::shared_ptr<const std::string> FramePictures::overlay_png(const SnapshotFrame& frame, const LabelSet& labels) {
  return once(overlay_, frame.labelled_ids, [&](const Image<PanopticId>& ids) { return overlay_of(ids, labels); });
}

void FramePictures::clear() {
  const std::lock_guard lock(mutex_);
  frame_ = {};
  labelled_ = {};
  overlay_ = {};
}

}  // namespace panoptic
