// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <system_error>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/mapping/option_fields.h"

namespace {

int dispatch(const panoptic::Arguments& arguments) {
  if (arguments.command == "run") return panoptic::run(arguments);
  if (arguments.command == "predict") return panoptic::predict(arguments);
  if (arguments.command == "doctor") return panoptic::doctor(arguments);
  if (arguments.command == "check-network") return panoptic::check_network(arguments);
  if (arguments.command == "eval") return panoptic::evaluate(arguments);
  if (arguments.command == "eval-trajectory") return panoptic::evaluate_trajectory(arguments);
  if (arguments.command == "explain") return panoptic::explain(arguments);
  if (arguments.command == "simulate") return panoptic::simulate(arguments);
  if (arguments.command == "batch") return panoptic::batch(arguments);
  if (arguments.command == "benchmark") return panoptic::benchmark(arguments);
  if (arguments.command == "view" || arguments.command == "play") return panoptic::view(arguments);
  if (arguments.command == "export-web") return panoptic::export_web(arguments);
  if (arguments.command == "info") return panoptic::map_info(arguments);
  if (arguments.command == "mesh") return panoptic::map_mesh(arguments);
  if (arguments.command == "query") return panoptic::map_query(arguments);
  if (arguments.command == "regularize") return panoptic::map_regularize(arguments);
  if (arguments.command == "rebuild") return panoptic::map_rebuild(arguments);
  if (arguments.command == "merge") return panoptic::map_merge(arguments);
  if (arguments.command == "diff") return panoptic::map_diff(arguments);
  if (arguments.command == "plan") return panoptic::plan(arguments);
  if (arguments.command == "options") {
    panoptic::Options options;
    fmt::print("{}", panoptic::describe(panoptic::fields(options)));
  }
  return panoptic::kDone;
}

int failed(const std::string& what) {
  panoptic::tell(fmt::format("panoptic: {}\n", what));
  return panoptic::kWorldIsWrong;
}

// Fails if standard output could not be written: it may be all that the user wanted.
int close_output(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  return failed("the standard output could not be written: free space where it goes");
}

int run_command(int argc, char** argv) {
  try {
    return close_output(dispatch(panoptic::parse_arguments(argc, argv)));
  } catch (const panoptic::UsageError& e) {
    failed(e.what());
    return panoptic::kWrongUsage;
  } catch (const std::bad_alloc&) {
    return failed(panoptic::kOutOfMemoryAdvice);
  } catch (const std::system_error& e) {  // also of a print
    return std::ferror(stdout) != 0 ? close_output(panoptic::kWorldIsWrong) : failed(e.what());
  } catch (const std::exception& e) {
    return failed(e.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may grow no further is to be an error like a full disk
  return run_command(argc, argv);
}
