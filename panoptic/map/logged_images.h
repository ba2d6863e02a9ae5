// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The packed images of a logged frame, wherever they are: still being packed, in memory, or in a map file.
#pragma once

#include <cstddef>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <utility>

#include "panoptic/base/compression.h"
#include "panoptic/frame.h"

namespace panoptic {

// Thread-safe.
class LoggedImages {
 public:
  // Reads them from where they lie. Called from any thread. Throws Error.
  using Read = std::function<Bytes()>;

  // Packs them on a thread of its own, and keeps them in memory.
  explicit LoggedImages(const Frame& frame);
  explicit LoggedImages(Read read) : read_(std::move(read)) {}

  // The bytes that pack_images gives; waits until they are packed. Throws Error if they cannot be read.
  std::shared_ptr<const Bytes> packed() const;
  // How many bytes were packed: 0 of those that were never in memory.
  std::size_t size() const;
  // They can be read from now on, and need no memory any more. REQUIRES that they are packed.
  void let_go(Read read);

 private:
  using Packing = std::shared_future<std::shared_ptr<const Bytes>>;

  mutable std::mutex mutex_;
  Packing packing_;  // not valid: they are in a file
  Read read_;
  std::size_t size_ = 0;  // of those that are in a file now
};

}  // namespace panoptic
