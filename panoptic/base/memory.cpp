// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/memory.h"

#include <atomic>

namespace panoptic {
namespace {

std::atomic<std::size_t> left_out{0};

}  // namespace

std::size_t left_out_of_limit() { return left_out.load(std::memory_order_relaxed); }

LeftOutOfLimit::~LeftOutOfLimit() {
  const std::size_t now = resident_bytes();
  if (now > before_) left_out.fetch_add(now - before_, std::memory_order_relaxed);
}

}  // namespace panoptic
