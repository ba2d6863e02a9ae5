// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

namespace panoptic {

// Whether something that was handed over is used, or can be.
struct [[nodiscard]] Outcome {
  bool used = true;
  std::string reason = {};  // one line for a person why it is not used; empty if it is

  static Outcome refused(std::string reason) { return {false, std::move(reason)}; }

  bool operator==(const Outcome&) const = default;
};

}  // namespace panoptic
