// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// panoptic-bench: how long the fusion side takes on a recording, stage by stage, and how much memory.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "bench/endurance.h"
#include "bench/fusion_run.h"
#include "panoptic/base/config.h"
#include "panoptic/base/version.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/parallel.h"
#include "panoptic/profile.h"
#include "panoptic/simulation.h"
#include "panoptic/voxel_map.h"

namespace panoptic {
namespace {

struct BenchArguments {
  BenchSource source;
  BenchSettings settings;
  std::string config;
  std::vector<std::string> assignments;
  std::string frames;
  std::string json;
  std::string raw_frames;
  int threads = 0;
  EnduranceSettings endurance;  // frames = 0: not asked for
  bool is_streamed = false;
};

void add_options(CLI::App& app, BenchArguments& a) {
  app.add_option("recording", a.source.recording, "recording or sim:SEED[,rooms=R,frames=F,noise=P], as panoptic run takes it")
      ->required();
  app.add_option("--calibration", a.source.calibration, "TOML file that overrides intrinsics, depth scale and the colour camera");
  app.add_option("--frames", a.frames, "A:B or A:B:STEP, positions in the sequence from 0, B excluded");
  app.add_option("--predictions", a.source.predictions, "folder of predictions; without it labels are made up from --seed");
  app.add_option("--seed", a.source.seeded.seed, "of the made-up labels, default 1");
  app.add_option("--label-cell", a.source.seeded.cell_m, "edge in metres of the cubes that get a made-up label, default 1.2")
      ->check(CLI::Range(0.05, 100.0));
  app.add_option("--resize", a.source.resize, "factor for the edges of all images, default 1")->check(CLI::Range(0.05, 4.0));
  app.add_option("--copies", a.settings.copies, "map the recording this many times side by side, for a larger map; default 1")
      ->check(CLI::Range(1, 1000));
  app.add_option("--config", a.config, "TOML file of options");
  app.add_option("--set", a.assignments, "one option, key=value; may be repeated (keys: panoptic options)");
  app.add_option("--repeat", a.settings.repeats, "how often all is done; each frame counts with its best time; default 3")
      ->check(CLI::Range(1, 1000));
  app.add_option("--mesh-every", a.settings.mesh_every, "frames between two incremental meshes, default 10")
      ->check(CLI::Range(1, 100000));
  app.add_option("--threads", a.threads, "threads to use; 0 = one per core")->check(CLI::Range(0, 1024));
  app.add_option("--mesh", a.settings.mesh, "write the full mesh to this PLY file");
  app.add_option("--raw-frames", a.raw_frames, "write the decoded frames to this folder for other programs, and measure nothing");
  app.add_option("--json", a.json, "write the result to this file");
}

void add_endurance(CLI::App& app, BenchArguments& a) {
  CLI::Option* frames =
      app.add_option(
             "--endurance", a.endurance.frames,
             "instead: one map of so many frames on one thread, the recording again and again, with time, memory, objects "
             "and size on disk as they change")
          ->check(CLI::Range(1, 1000000000));
  app.add_option("--look-every", a.endurance.every, "frames between two looks at them, default 1000")
      ->check(CLI::Range(1, 1000000000))
      ->needs(frames);
  app.add_flag("--streamed", a.is_streamed, "read the recording while it is mapped, once, instead of decoding it beforehand")
      ->needs(frames);
  app.add_option("--save", a.endurance.save, "map file that is written anew at each look")->needs(frames);
}

Json to_json(const BenchArguments& a, const BenchFrames& recording, const BenchResult& result) {
  Json stages = Json::object();
  for (const auto& [name, samples] : result.stages) {
    double sum = 0;
    for (const double ms : samples) sum += ms;
    stages[name] = {{"count", samples.size()},
                    {"p50_ms", quantile(samples, 0.5)},
                    {"p95_ms", quantile(samples, 0.95)},
                    {"max_ms", quantile(samples, 1)},
                    {"mean_ms", sum / static_cast<double>(samples.size())}};
  }
  Json copies = Json::array();
  for (const CopyTimes& c : result.copies) copies.push_back({{"fusion_p50_ms", c.fusion_p50_ms}, {"map_blocks", c.map_blocks}});
  const double observed = std::max(1.0, static_cast<double>(result.observed_voxels));
  return {{"program", fmt::format("panoptic {}", version())},
          {"recording", recording.description},
          {"frames", result.frames},
          {"segments_mean", result.segments_mean},
          {"threads", thread_count()},
          {"repeats", a.settings.repeats},
          {"voxel_size_m", a.settings.options.map.voxel_size_m},
          {"method", a.settings.options.integrator.method},
          {"stages", std::move(stages)},
          {"copies", std::move(copies)},
          {"work_of_a_frame",
           {{"pixels", result.work.pixels},
            {"color_pixels", result.work.color_pixels},
            {"touched_voxels", result.work.touched_voxels},
            {"band_voxels", result.work.band_voxels}}},
          {"width_px", recording.frames.front().frame.depth.width()},
          {"height_px", recording.frames.front().frame.depth.height()},
          {"fusion_p50_ms_of_each_repeat", result.repeat_p50_ms},
          {"peak_rss_mb", result.peak_rss_mb},
          {"frames_mb", static_cast<double>(recording.bytes) / 1e6},
          {"blocks", result.blocks},
          {"map_mb", static_cast<double>(result.map_bytes) / 1e6},
          {"map_bytes_per_observed_voxel", static_cast<double>(result.map_bytes) / observed},
          {"mesh_triangles", result.mesh_triangles},
          {"map_hash", fmt::format("{:016x}", result.map_hash)}};
}

void print(const Json& result) {
  fmt::print("{}; {} frames, {} threads, voxels of {:.3g} m, {}, {:.1f} segments a frame\n",
             result["recording"].get<std::string>(), result["frames"].get<int>(), result["threads"].get<int>(),
             result["voxel_size_m"].get<double>(), result["method"].get<std::string>(), result["segments_mean"].get<double>());
  fmt::print("{:<18}{:>8}{:>10}{:>10}{:>10}\n", "stage", "count", "p50 ms", "p95 ms", "max ms");
  for (const auto& [name, stage] : result["stages"].items()) {
    fmt::print("{:<18}{:>8}{:>10.3f}{:>10.3f}{:>10.3f}\n", name, stage["count"].get<int>(), stage["p50_ms"].get<double>(),
               stage["p95_ms"].get<double>(), stage["max_ms"].get<double>());
  }
  fmt::print(
      "map {:.1f} MB in {} blocks, {:.1f} bytes per observed voxel; peak {:.0f} MB (without the decoded frames); hash {}\n",
      result["map_mb"].get<double>(), result["blocks"].get<int>(), result["map_bytes_per_observed_voxel"].get<double>(),
      result["peak_rss_mb"].get<double>(), result["map_hash"].get<std::string>());
}

Json to_json(const EnduranceLook& look) {
  return {{"frames", look.frames},       {"cpu_ms", look.cpu_ms},
          {"stages_ms", look.stages_ms}, {"rss_mb", look.rss_mb},
          {"map_mb", look.map_mb},       {"blocks", look.blocks},
          {"objects", look.objects},     {"observed_voxels", look.observed_voxels},
          {"file_mb", look.file_mb},     {"ids_given", look.ids_given}};
}

void print(const EnduranceResult& result) {
  fmt::print("{:>9}{:>9}{:>9}{:>9}{:>9}{:>11}{:>9}{:>9}\n", "frames", "CPU ms", "RSS MB", "map MB", "file MB", "Mvoxels",
             "objects", "ids");
  for (const EnduranceLook& l : result.looks) {
    fmt::print("{:>9}{:>9.2f}{:>9.1f}{:>9.1f}{:>9.2f}{:>11.3f}{:>9}{:>9}\n", l.frames, l.cpu_ms, l.rss_mb, l.map_mb, l.file_mb,
               static_cast<double>(l.observed_voxels) / 1e6, l.objects, l.ids_given);
  }
  fmt::print("peak {:.0f} MB; hash {:016x}\n", result.peak_rss_mb, result.map_hash);
}

void bench_endurance(BenchArguments& a) {
  a.endurance.options = a.settings.options;
  const auto dataset = a.is_streamed ? open_dataset(a.source.recording, a.source.calibration) : nullptr;
  const auto predictor = a.is_streamed ? predictor_of(a.source, *dataset) : nullptr;
  const BenchFrames decoded =
      a.is_streamed ? BenchFrames{dataset->description(), labels_of(predictor.get()), {}, 0} : load_bench_frames(a.source);
  set_thread_count(1);
  const NextFrame next = a.is_streamed ? streamed(a.source, *dataset, predictor.get()) : again_and_again(decoded);
  const EnduranceResult result = endure(next, decoded.labels, a.endurance);
  fmt::print("{}; voxels of {:.3g} m\n", decoded.description, a.settings.options.map.voxel_size_m);
  print(result);
  Json looks = Json::array();
  for (const EnduranceLook& look : result.looks) looks.push_back(to_json(look));
  if (a.json.empty()) return;
  write_json_file(a.json, {{"program", fmt::format("panoptic {}", version())},
                           {"recording", decoded.description},
                           {"voxel_size_m", a.settings.options.map.voxel_size_m},
                           {"decoded_mb", static_cast<double>(decoded.bytes) / 1e6},
                           {"peak_rss_mb", result.peak_rss_mb},
                           {"map_hash", fmt::format("{:016x}", result.map_hash)},
                           {"looks", std::move(looks)}});
}

void bench(BenchArguments& a) {
  Options& options = a.settings.options;
  if (!a.config.empty()) options = load_options(a.config);
  const Fields all = fields(options);
  for (const std::string& assignment : a.assignments) set_field(all, assignment);
  if (!a.frames.empty()) a.source.range = parse_frame_range(a.frames);
  set_thread_count(0);
  if (a.endurance.frames > 0) return bench_endurance(a);
  const BenchFrames recording = load_bench_frames(a.source);
  if (!a.raw_frames.empty()) return write_raw_frames(a.raw_frames, recording);
  set_thread_count(a.threads);
  const Json result = to_json(a, recording, run_bench(recording, a.settings));
  print(result);
  if (!a.json.empty()) write_json_file(a.json, result);
}

}  // namespace
}  // namespace panoptic

int main(int argc, char** argv) {
  panoptic::BenchArguments arguments;
  CLI::App app("Times of the fusion side on a recording that is decoded into memory beforehand.", "panoptic-bench");
  panoptic::add_options(app, arguments);
  panoptic::add_endurance(app, arguments);
  CLI11_PARSE(app, argc, argv);
  try {
    panoptic::bench(arguments);
  } catch (const std::exception& e) {
    fmt::print(stderr, "panoptic-bench: {}\n", e.what());
    return 1;
  }
  return 0;
}
