// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Where things are on this machine. One generated source knows it, so that a compiler cache has all the others in any folder.
#pragma once

#include <filesystem>

namespace panoptic::test {

std::filesystem::path source_folder();

// Both end with the process.
const char* program_file();
const char* interpose_file();  // empty where it is not built

}  // namespace panoptic::test
