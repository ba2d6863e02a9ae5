// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>

#include "panoptic/base/files.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

constexpr int kNotStarted = 127;  // as shells have it
constexpr int kKilledBy = 128;

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw FileError(fmt::format("cannot open {}: {}; check the path and its permissions", path.string(), os::reason(error)));
}

// If stdin, stdout or stderr is closed, a new descriptor would get its number, and what a child prints would go there. This
// one has another; `how`: F_DUPFD or F_DUPFD_CLOEXEC. Negative, with errno, if that fails.
int beyond_standard(int descriptor, int how) {
  if (descriptor < 0 || descriptor > STDERR_FILENO) return descriptor;
  const int beyond = ::fcntl(descriptor, how, STDERR_FILENO + 1);
  const int error = errno;
  ::close(descriptor);
  errno = error;
  return beyond;
}

int open_to_append(const std::filesystem::path& path) {
  const int descriptor = beyond_standard(::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666), F_DUPFD_CLOEXEC);
  if (descriptor < 0) fail(path, errno);
  return descriptor;
}

// Both ends close when the child becomes the program.
bool open_pipe(std::array<int, 2>& ends) {
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return false;
  for (int& end : ends) end = beyond_standard(end, F_DUPFD_CLOEXEC);
  return ends[0] >= 0 && ends[1] >= 0;
}

// The child from the fork on. Other threads of the parent may hold any lock, so nothing here takes memory.
[[noreturn]] void become(const std::vector<char*>& argv, int log, int failed, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kNotStarted);  // it died before it could be told
  for (const int signal : {SIGINT, SIGTERM}) ::signal(signal, SIG_DFL);
  const int nothing = ::open("/dev/null", O_RDONLY);
  if (nothing >= 0) ::dup2(nothing, STDIN_FILENO);
  ::dup2(log, STDOUT_FILENO);
  ::dup2(log, STDERR_FILENO);
  ::execvp(argv[0], argv.data());
  const int error = errno;
  [[maybe_unused]] const ssize_t told = ::write(failed, &error, sizeof error);
  ::_exit(kNotStarted);
}

// The reason why the child did not become the program; 0 if it did, which closes the pipe.
int failure_through(int pipe) {
  int error = 0;
  ssize_t got = 0;
  do {
    got = ::read(pipe, &error, sizeof error);
  } while (got < 0 && errno == EINTR);
  ::close(pipe);
  return got == sizeof error ? error : 0;
}

EndedChild to_ended(int status, const rusage& usage) {
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : kKilledBy + WTERMSIG(status);
  return {code, static_cast<double>(usage.ru_maxrss) * 1024 / 1e6};
}

[[noreturn]] void fail_to_wait(int id, int error) {
  throw Error(fmt::format("cannot wait for the process {}: {}; run the command again", id, os::reason(error)));
}

}  // namespace

int start_child(const std::vector<std::string>& command, const std::filesystem::path& log) {
  std::vector<char*> argv;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const int written = open_to_append(log);
  std::array<int, 2> failed{};
  const pid_t parent = ::getpid();
  pid_t child = -1;
  ::signal(SIGCHLD, SIG_DFL);  // where the parent of this process ignored it, children would vanish unseen
  if (open_pipe(failed)) child = ::fork();
  if (child == 0) become(argv, written, failed[1], parent);
  const int error = errno;
  ::close(written);
  if (child < 0) throw Error(fmt::format("cannot start {}: {}", command.front(), os::reason(error)));
  ::close(failed[1]);
  if (const int reason = failure_through(failed[0]); reason != 0) {
    wait_for_child(child);
    throw Error(fmt::format("cannot start {}: {}", command.front(), os::reason(reason)));
  }
  return child;
}

std::optional<EndedChild> ended_child(int id) {
  int status = 0;
  rusage usage{};
  const pid_t ended = ::wait4(id, &status, WNOHANG, &usage);
  if (ended < 0 && errno != EINTR) fail_to_wait(id, errno);
  if (ended != id) return std::nullopt;
  return to_ended(status, usage);
}

EndedChild wait_for_child(int id) {
  int status = 0;
  rusage usage{};
  while (::wait4(id, &status, 0, &usage) < 0) {
    if (errno != EINTR) fail_to_wait(id, errno);
  }
  return to_ended(status, usage);
}

void ask_child_to_end(int id) { ::kill(id, SIGTERM); }

void kill_child(int id) { ::kill(id, SIGKILL); }

// Children are to have the descriptor too.
FolderClaim::FolderClaim(const std::filesystem::path& lock_file, Kind kind)
    : descriptor_(beyond_standard(::open(lock_file.c_str(), O_RDWR | O_CREAT, 0666), F_DUPFD)) {
  if (descriptor_ < 0) fail(lock_file, errno);
  const int how = (kind == Kind::kAlone ? LOCK_EX : LOCK_SH) | LOCK_NB;
  is_ours_ = ::flock(descriptor_, how) == 0;
  const int error = errno;
  if (is_ours_ || error == EWOULDBLOCK) return;
  ::close(descriptor_);
  fail(lock_file, error);
}

FolderClaim::~FolderClaim() { ::close(descriptor_); }

std::unique_ptr<FolderClaim> claim_folder(const std::filesystem::path& lock_file, FolderClaim::Kind kind, double patience_s) {
  constexpr std::chrono::milliseconds kPause{50};
  const Stopwatch waited;
  for (;;) {
    auto claim = std::make_unique<FolderClaim>(lock_file, kind);
    if (claim->is_ours()) return claim;
    claim.reset();
    if (waited.seconds() >= patience_s) return nullptr;
    std::this_thread::sleep_for(kPause);
  }
}

}  // namespace panoptic
