// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/logged_images.h"

#include <utility>

#include "panoptic/map/frame_images.h"

namespace panoptic {

// The task lives as long as its result, so it gives the frame up when that is packed.
LoggedImages::LoggedImages(const Frame& frame)
    : packing_(std::async(std::launch::async, [whole = std::make_unique<Frame>(kept(frame))]() mutable {
        const std::unique_ptr<Frame> once = std::move(whole);
        return std::make_shared<const Bytes>(pack_images(*once));
      })) {}

std::shared_ptr<const Bytes> LoggedImages::packed() const {
  Packing packing;
  Read read;
  {
    const std::lock_guard lock(mutex_);
    packing = packing_;
    read = read_;
  }
  return packing.valid() ? packing.get() : std::make_shared<const Bytes>(read());
}

std::size_t LoggedImages::size() const {
  Packing packing;
  {
    const std::lock_guard lock(mutex_);
    if (!packing_.valid()) return size_;
    packing = packing_;
  }
  return packing.get()->size();
}

void LoggedImages::let_go(Read read) {
  const std::lock_guard lock(mutex_);
  if (packing_.valid()) size_ = packing_.get()->size();
  read_ = std::move(read);
  packing_ = {};
}

}  // namespace panoptic
