// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The command line of the commands that take map files.
#pragma once

#include <CLI/CLI.hpp>

#include "apps/panoptic/arguments.h"

namespace panoptic {

void add_threads(CLI::App& app, Arguments& a);
// info, mesh, query, regularize, rebuild, merge, diff, plan, export-web.
void add_map_commands(CLI::App& app, Arguments& a);

}  // namespace panoptic
