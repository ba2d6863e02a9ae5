// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/apps/program.h"
#include "tests/fresh_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <map>
#include <sstream>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "tests/fusion/scenes.h"
#include "tests/places.h"

namespace panoptic::test {
namespace {

[[noreturn]] void become_program(const std::vector<std::string>& arguments, const std::filesystem::path& out,
                                 const std::filesystem::path& err) {
  std::vector<char*> argv{const_cast<char*>(program_file())};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDOUT_FILENO);
  dup2(open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDERR_FILENO);
  execv(program_file(), argv.data());
  _exit(127);
}

RunningProgram start(const std::vector<std::string>& arguments, const std::function<void()>& in_child) {
  static int started = 0;  // programs may run inside others' time
  const std::filesystem::path folder = fresh_folder(fmt::format("program_{}", started++));
  const pid_t pid = fork();
  if (pid == 0) {
    if (in_child) in_child();
    become_program(arguments, folder / "out", folder / "err");
  }
  return {pid, folder / "out", folder / "err"};
}

ProgramResult result_of(const RunningProgram& program) {
  int status = 0;
  waitpid(program.pid, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_file(program.out), read_file(program.err)};
}

void write_orbit_frame(const std::filesystem::path& stem, int index) {
  const Frame frame = orbit_frame(index);
  Image<std::uint16_t> depth_mm(frame.depth.width(), frame.depth.height());
  for (std::size_t p = 0; p < depth_mm.size(); ++p)
    depth_mm[p] = static_cast<std::uint16_t>(std::min(frame.depth[p], 60.0F) * 1000);
  write_png(stem.string() + ".depth.png", depth_mm);
  write_png(stem.string() + ".color.png", frame.color.copied());
  std::ostringstream pose;
  pose.precision(12);
  pose << frame.world_from_camera.matrix() << "\n";
  write_file(stem.string() + ".pose.txt", pose.str());
}

}  // namespace

ProgramResult run_program(const std::vector<std::string>& arguments, const std::function<void()>& in_child,
                          const std::function<void(const RunningProgram&)>& while_running) {
  const RunningProgram program = start(arguments, in_child);
  if (while_running) while_running(program);
  return result_of(program);
}

std::vector<ProgramResult> run_at_once(const std::vector<std::vector<std::string>>& programs) {
  std::vector<RunningProgram> running;
  for (const std::vector<std::string>& arguments : programs) running.push_back(start(arguments, {}));
  std::vector<ProgramResult> results;
  for (const RunningProgram& program : running) results.push_back(result_of(program));
  return results;
}

bool wait_for_text(const RunningProgram& program, const std::filesystem::path& file, const std::string& text) {
  constexpr useconds_t kPause_us = 5000;
  for (;;) {
    siginfo_t ended{};  // looked at without taking it: run_program collects the child
    const bool over =
        waitid(P_PID, static_cast<id_t>(program.pid), &ended, WEXITED | WNOHANG | WNOWAIT) != 0 || ended.si_pid != 0;
    std::error_code absent;
    if (std::filesystem::exists(file, absent) && read_file(file).find(text) != std::string::npos) return true;
    if (over) return false;
    usleep(kPause_us);
  }
}

Frame orbit_frame(int index) {
  const Surface scene = nearest_of({sphere({0, 0, 0}, 0.6), plane(Vec3d::UnitY(), 0.6)});
  const double angle = 0.08 * index;
  const Camera camera{160, 120, 146.25, 146.25, 80, 60};
  return render(scene, camera, look_at({2 * std::cos(angle), -0.9, 2 * std::sin(angle)}, {0, 0, 0}), index);
}

void fill_once(const std::filesystem::path& folder, const std::string& name, const std::function<void()>& make) {
  static std::map<std::string, std::map<std::string, std::string>> made;  // bytes by file, by name
  const auto [files, is_new] = made.try_emplace(name);
  if (!is_new) {
    for (const auto& [file, bytes] : files->second) write_file(folder / file, bytes);
    return;
  }
  make();
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files->second[entry.path().filename().string()] = read_file(entry.path());
}

void write_orbit_recording(const std::filesystem::path& folder, int frames) {
  std::filesystem::create_directories(folder);
  fill_once(folder, fmt::format("orbit of {} frames", frames), [&] {
    write_file(folder / "camera-intrinsics.txt", "146.25 0 80\n0 146.25 60\n0 0 1\n");
    for (int i = 0; i < frames; ++i) write_orbit_frame(folder / fmt::format("frame-{:06}", i), i);
  });
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) result.push_back(line);
  return result;
}

}  // namespace panoptic::test
