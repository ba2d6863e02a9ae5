// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Room for rows of floats that is used again and again. It begins on a cache line, so that a row of 16 fills one and not halves
// of two, and is not cleared: what the operating system does for fresh memory costs as much as the sums that go there.
#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace panoptic {

class FloatRows {
 public:
  // At least `count` floats of any value; what was there before is lost if they do not fit.
  float* make_room(std::size_t count) {
    if (count > capacity_) {
      capacity_ = 0;
      floats_.reset();
      floats_.reset(static_cast<float*>(::operator new(count * sizeof(float), kAlignment)));
      capacity_ = count;
    }
    return floats_.get();
  }
  float* data() { return floats_.get(); }
  const float* data() const { return floats_.get(); }
  std::size_t capacity() const { return capacity_; }

 private:
  static constexpr std::align_val_t kAlignment{64};
  struct Free {
    void operator()(float* floats) const { ::operator delete(floats, kAlignment); }
  };

  std::unique_ptr<float, Free> floats_;
  std::size_t capacity_ = 0;
};

}  // namespace panoptic
