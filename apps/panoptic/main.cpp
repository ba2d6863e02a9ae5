// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <new>

#include "apps/panoptic/commands.h"

namespace {

int dispatch(const panoptic::Arguments& arguments) {
  if (arguments.command == "run") return panoptic::run(arguments);
  if (arguments.command == "predict") return panoptic::predict(arguments);
  if (arguments.command == "doctor") return panoptic::doctor(arguments);
  if (arguments.command == "eval") return panoptic::evaluate(arguments);
  if (arguments.command == "explain") return panoptic::explain(arguments);
  if (arguments.command == "simulate") return panoptic::simulate(arguments);
  if (arguments.command == "benchmark") return panoptic::benchmark(arguments);
  if (arguments.command == "view") return panoptic::view(arguments);
  if (arguments.command == "info") return panoptic::map_info(arguments);
  if (arguments.command == "mesh") return panoptic::map_mesh(arguments);
  if (arguments.command == "query") return panoptic::map_query(arguments);
  if (arguments.command == "regularize") return panoptic::map_regularize(arguments);
  if (arguments.command == "options") {
    panoptic::Options options;
    fmt::print("{}", panoptic::describe(panoptic::fields(options)));
  }
  return panoptic::kDone;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return dispatch(panoptic::parse_arguments(argc, argv));
  } catch (const panoptic::UsageError& e) {
    fmt::print(stderr, "panoptic: {}\n", e.what());
    return panoptic::kWrongUsage;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "panoptic: {}\n", panoptic::kOutOfMemory);
  } catch (const std::exception& e) {
    fmt::print(stderr, "panoptic: {}\n", e.what());
  }
  return panoptic::kWorldIsWrong;
}
