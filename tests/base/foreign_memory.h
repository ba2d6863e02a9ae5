// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>

#include "panoptic/image.h"

namespace panoptic::test {

enum class RowOrder { kTopFirst, kTopLast };

// An image in the memory of another program: some bytes between its rows, which can lie from the last to the first. The memory is
// overwritten before it is given back, so that whoever reads it later reads nonsense (NaN, white) even if nobody else got it.
template <typename T>
class ForeignMemory {
 public:
  ForeignMemory(const ImageView<T>& image, std::size_t gap_bytes, RowOrder order = RowOrder::kTopFirst)
      : row_bytes_(static_cast<std::size_t>(image.width()) * sizeof(T) + gap_bytes),
        size_(row_bytes_ * static_cast<std::size_t>(image.height())),
        bytes_(new char[size_]) {
    std::memset(bytes_.get(), kNonsense, size_);
    const auto step = static_cast<std::ptrdiff_t>(row_bytes_);
    char* first = bytes_.get() + (order == RowOrder::kTopLast ? size_ - row_bytes_ : 0);
    view_ = ImageView<T>(reinterpret_cast<const T*>(first), image.width(), image.height(),
                         order == RowOrder::kTopLast ? -step : step);
    for (int v = 0; v < image.height(); ++v) {
      std::memcpy(const_cast<T*>(view_.row(v)), image.row(v), static_cast<std::size_t>(image.width()) * sizeof(T));
    }
  }
  ~ForeignMemory() { std::memset(bytes_.get(), kNonsense, size_); }
  ForeignMemory(const ForeignMemory&) = delete;
  ForeignMemory& operator=(const ForeignMemory&) = delete;

  const ImageView<T>& view() const { return view_; }

 private:
  static constexpr int kNonsense = 0xFF;

  std::size_t row_bytes_;
  std::size_t size_;
  std::unique_ptr<char[]> bytes_;
  ImageView<T> view_;
};

}  // namespace panoptic::test
