// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/progress.h"

#include <fmt/format.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <utility>

#include "panoptic/base/os.h"

namespace panoptic {
namespace {

constexpr double kTerminalInterval_s = 0.1;
constexpr double kLogInterval_s = 10;
constexpr std::size_t kBarWidth = 30;

volatile std::sig_atomic_t g_interrupted = 0;

void on_interrupt(int signal) {
  g_interrupted = 1;
  std::signal(signal, SIG_DFL);
}

std::string clock_text(double seconds) {
  const auto whole = std::lround(seconds);
  return whole >= 3600 ? fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
                       : fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

Progress::Progress(std::string unit, std::size_t total)
    : unit_(std::move(unit)), total_(total), terminal_(os::is_terminal(stderr)) {}

Progress::~Progress() {
  draw();
  if (terminal_) tell("\n");
}

void Progress::advance(std::size_t done) {
  done_ = done;
  if (done == 0 && !terminal_) return;  // a log need not be told that nothing has happened
  const double interval_s = terminal_ ? kTerminalInterval_s : kLogInterval_s;
  if (since_start_.seconds() - last_drawn_s_ >= interval_s) draw();
}

void Progress::draw() {
  const double elapsed_s = since_start_.seconds();
  last_drawn_s_ = elapsed_s;
  const double per_s = elapsed_s > 0 ? static_cast<double>(done_) / elapsed_s : 0;
  const std::string left = per_s > 0 && done_ < total_ ? clock_text(static_cast<double>(total_ - done_) / per_s) + " left"
                                                       : clock_text(elapsed_s) + " in all";
  const std::string text = fmt::format("{}/{} {}  {:.1f} {}/s  {}", done_, total_, unit_, per_s, unit_, left);
  if (terminal_) {
    const std::size_t full = total_ > 0 ? kBarWidth * done_ / total_ : kBarWidth;
    tell(fmt::format("\r[{:=<{}}{:{}}] {}\033[K", "", full, "", kBarWidth - full, text));
  } else {
    tell(text + "\n");
  }
}

void tell(const std::string& text) {
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

void watch_for_interrupt() {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
}

bool interrupted() { return g_interrupted != 0; }

}  // namespace panoptic
