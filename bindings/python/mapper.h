// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "bindings/python/bind.h"
#include "bindings/python/frames.h"
#include "panoptic/mapper.h"
#include "panoptic/profile.h"

namespace panoptic::python {

// A mapper, and who uses it.
struct PythonMapper {
  PythonMapper(const Options& chosen, LabelSet labels) : options(chosen), mapper(chosen, std::move(labels)) {}

  FrameArrays numbered(FrameArrays arrays) const {
    if (arrays.index.is_none()) arrays.index = py::int_(next_index);
    return arrays;
  }

  Options options;
  Mapper mapper;
  bool finished = false;
  std::int64_t next_index = 0;  // of a frame that comes without one
  std::shared_ptr<Exclusive> use = std::make_shared<Exclusive>("mapper");
};

// Counts and times in milliseconds by stage.
py::dict stage_times(const Profile& profile);

// A call of `add` or `push` that fits none of their forms.
[[noreturn]] void refuse_call(const char* name, const py::args& args, const py::kwargs& named);

// The frame that `add` and `push` are given: a Frame, or its arrays. Throws Error.
class GivenFrame {
 public:
  GivenFrame(const py::object& frame, const FrameArrays& arrays);
  const Frame& operator*() const { return frame_ ? *frame_ : made_->frame; }

 private:
  std::shared_ptr<Frame> frame_;
  std::optional<LentFrame> made_;
};

}  // namespace panoptic::python
