// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/base/config.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/profile.h"
#include "panoptic/sim/contact_sheet.h"
#include "panoptic/sim/export.h"
#include "panoptic/sim/ground_truth.h"
#include "panoptic/sim/home_statistics.h"

namespace panoptic {
namespace {

void apply_flags(const Arguments& a, ExportOptions& options) {
  if (!a.predictions.empty()) set_predictions(options, a.predictions);
  const Fields all = fields(options);
  for (const std::string& setting : a.settings) set_field(all, setting);
  if (a.seed) options.seed = *a.seed;
  if (a.rooms) options.rooms = *a.rooms;
  if (a.frame_count) options.frames = *a.frame_count;
  if (a.noise) options.noise = *a.noise;
  if (a.dynamics) options.dynamics = *a.dynamics;
  if (a.jumps) options.jumps = *a.jumps;
}

// Defaults, then --config, then the flags.
ExportOptions export_options(const Arguments& a) {
  ExportOptions options;
  if (!a.config.empty()) read_toml_file(a.config, fields(options));
  try {
    apply_flags(a, options);
    simulation_options(options);
  } catch (const Error& e) {
    throw UsageError(e.what());
  }
  return options;
}

void print_home(const Simulation& simulation) {
  const Home home = final_home(simulation.world());
  fmt::print("{}\n{}", simulation.description(), to_text(statistics(home), home));
  std::fflush(stdout);
}

// The size of the files, as far as the disk tells: the scan is whole, and the number is only for the eye.
std::uintmax_t bytes_below(const std::filesystem::path& folder) {
  std::uintmax_t bytes = 0;
  std::error_code error;
  for (auto entry = std::filesystem::recursive_directory_iterator(folder, error);
       !error && entry != std::filesystem::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code unknown;
    const std::uintmax_t size = entry->is_regular_file(unknown) ? entry->file_size(unknown) : 0;
    if (!unknown) bytes += size;
  }
  return bytes;
}

void print_closing(const Simulation& simulation, const ExportOptions& options, const std::string& output, double seconds) {
  const auto frames = static_cast<double>(simulation.size());
  const std::string scene = scene_name(simulation.options().seed);
  fmt::print("\n{} frames in {:.1f} s, {:.1f} frames/s, {:.0f} kB a frame\n", simulation.size(), seconds, frames / seconds,
             static_cast<double>(bytes_below(output)) / frames / 1e3);
  fmt::print(
      "look at   {0}/plan.png\nrecording {0}/{1}.sens\ntruth     {0}/{1}_vh_clean_2.ply\nmap it    panoptic run {0}{2} -o OUT\n",
      output, scene, options.predictions == "none" ? "" : fmt::format(" --predictions {}/predictions", output));
}

int write_contact_sheet(const Arguments& arguments, const ExportOptions& options) {
  constexpr int kHomes = 6;
  write_png(arguments.contact_sheet, contact_sheet(simulation_options(options), kHomes));
  fmt::print("{} homes from seed {} in {}\n", kHomes, options.seed, arguments.contact_sheet);
  return kDone;
}

}  // namespace

ScanTruth simulated_truth(const std::string& simulation) { return ground_truth(Simulation(parse_simulation(simulation))); }

int simulate(const Arguments& arguments) {
  const ExportOptions options = export_options(arguments);
  if (arguments.output.empty() && arguments.contact_sheet.empty())
    throw UsageError("simulate needs -o DIR; see panoptic simulate --help");
  set_thread_count(arguments.threads);
  if (!arguments.contact_sheet.empty()) return write_contact_sheet(arguments, options);

  const Simulation simulation(simulation_options(options));
  print_home(simulation);
  watch_for_interrupt();
  const Stopwatch stopwatch;
  bool whole = false;
  {
    Progress progress("frames", simulation.size());
    whole = export_scan(simulation, options, arguments.output, [&](std::size_t done) {
      progress.advance(done);
      return !interrupted();
    });
  }
  if (!whole) {
    tell(fmt::format("interrupted: nothing is left in {}\n", arguments.output));
    return kInterrupted;
  }
  print_closing(simulation, options, arguments.output, stopwatch.seconds());
  return kDone;
}

}  // namespace panoptic
