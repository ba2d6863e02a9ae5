// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/logged_images.h"

#include <utility>

#include "panoptic/map/frame_images.h"

namespace panoptic {

LoggedImages::LoggedImages(const Frame& frame)
    : packing_(
          std::async(std::launch::async, [whole = kept(frame)] { return std::make_shared<const Bytes>(pack_images(whole)); })) {}

LoggedImages::Packing LoggedImages::packing() const {
  const std::lock_guard lock(mutex_);
  return packing_;
}

std::shared_ptr<const Bytes> LoggedImages::packed() const {
  if (const Packing packing = this->packing(); packing.valid()) return packing.get();
  return std::make_shared<const Bytes>(read_());  // set once, before packing_ was let go
}

std::size_t LoggedImages::size() const {
  const Packing packing = this->packing();
  return packing.valid() ? packing.get()->size() : size_;
}

void LoggedImages::let_go(Read read) {
  const std::lock_guard lock(mutex_);
  if (packing_.valid()) size_ = packing_.get()->size();
  read_ = std::move(read);
  packing_ = {};
}

}  // namespace panoptic
