// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The memory of what moves and of what is gone, as bytes of a map file.
#pragma once

#include <optional>

#include "panoptic/base/bytes.h"
#include "panoptic/base/compression.h"
#include "panoptic/map/presence_state.h"

namespace panoptic {

Bytes moving_bytes(const MovingState& state);
Bytes presence_bytes(const PresenceState& state);

// The states again; nothing if the bytes are of none.
std::optional<MovingState> moving_from(const Bytes& bytes);
std::optional<PresenceState> presence_from(const Bytes& bytes);

}  // namespace panoptic
