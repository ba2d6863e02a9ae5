// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// "Why is this a chair?": what a run on disk (docs/outputs.md) says about one object.
#pragma once

#include <filesystem>
#include <string>

#include "panoptic/run_files.h"

namespace panoptic {

struct Evidence {
  PanopticId asked_id = PanopticId::kUnknown;
  RunObject object;  // another one if the object that was asked for became part of it
};

// Throws Error as run_files.h does, or if there is no such object.
Evidence read_evidence(const std::filesystem::path& run, PanopticId id);

// Several lines for a person.
std::string to_text(const Evidence& evidence);

}  // namespace panoptic
