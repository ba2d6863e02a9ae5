// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A library to be loaded before the C library (LD_PRELOAD). It stands between a program and the system calls on the files below
// one folder, counts them, and lets chosen ones fail. Everything else goes through untouched. From the environment:
//   FAULTS_BELOW  the folder, an absolute path
//   FAULTS_CALLS  the calls that are counted and may fail, comma-separated: open, create (open for writing a file that may be
//                 new), read, write, sync, close, rename, remove, resize, folder (making one), look (stat), list
//   FAULTS_ERROR  the errno that they fail with; or "short": reads and writes move only a part
//   FAULTS_FROM   the number of the first call that fails, from 1; 0: none does
//   FAULTS_TIMES  how many fail in a row; 0: all that follow
//   FAULTS_LOG    a file in which the number of counted calls is found at the end, and each that failed, a line each
// NOLINTBEGIN: every function here is the C library's, by name, form and macros
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

enum Call { kOpen, kCreate, kRead, kWrite, kSync, kClose, kRename, kRemove, kResize, kFolder, kLook, kList, kCalls };
constexpr std::array<const char*, kCalls> kNames = {"open",   "create", "read",   "write",  "sync", "close",
                                                    "rename", "remove", "resize", "folder", "look", "list"};
constexpr int kDescriptors = 4096;

struct Plan {
  const char* below = nullptr;
  std::size_t below_length = 0;
  std::array<bool, kCalls> counted{};
  int error = 0;
  bool is_short = false;
  long from = 0;
  long times = 0;
  int log = -1;
};

std::array<std::atomic<bool>, kDescriptors> g_watched;
std::atomic<long> g_calls;

// The function of this name that would be called without this library.
#define NEXT(name) (reinterpret_cast<decltype(&(name))>(dlsym(RTLD_NEXT, #name)))

bool lists(const char* calls, const char* name) {
  const std::size_t length = std::strlen(name);
  for (const char* at = std::strstr(calls, name); at != nullptr; at = std::strstr(at + 1, name)) {
    if ((at == calls || at[-1] == ',') && (at[length] == ',' || at[length] == '\0')) return true;
  }
  return false;
}

long number_in(const char* variable) {
  const char* text = std::getenv(variable);
  return text == nullptr ? 0 : std::strtol(text, nullptr, 10);
}

Plan plan_from_environment() {
  Plan plan;
  plan.below = std::getenv("FAULTS_BELOW");
  const char* calls = std::getenv("FAULTS_CALLS");
  if (plan.below == nullptr || calls == nullptr) return {};
  plan.below_length = std::strlen(plan.below);
  for (int call = 0; call < kCalls; ++call) plan.counted[call] = lists(calls, kNames[call]);
  const char* error = std::getenv("FAULTS_ERROR");
  plan.is_short = error != nullptr && std::strcmp(error, "short") == 0;
  plan.error = static_cast<int>(number_in("FAULTS_ERROR"));
  plan.from = number_in("FAULTS_FROM");
  plan.times = number_in("FAULTS_TIMES");
  if (const char* log = std::getenv("FAULTS_LOG")) {
    plan.log = NEXT(open)(log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  }
  return plan;
}

const Plan& plan() {
  static const Plan kPlan = plan_from_environment();
  return kPlan;
}

void log_line(const char* what, const char* path, long number) {
  if (plan().log < 0) return;
  char line[PATH_MAX + 64];
  const int length = std::snprintf(line, sizeof(line), "%s %ld %s\n", what, number, path);
  const ssize_t written = NEXT(write)(plan().log, line, static_cast<std::size_t>(length));
  static_cast<void>(written);
}

[[gnu::destructor]] void at_end() { log_line("calls", "", g_calls); }

// One more call of this kind: whether it is to fail.
bool fails(Call call, const char* path) {
  if (!plan().counted[call]) return false;
  const long number = ++g_calls;
  if (plan().from == 0 || number < plan().from) return false;
  if (plan().times != 0 && number >= plan().from + plan().times) return false;
  log_line(kNames[call], path, number);
  if (!plan().is_short) errno = plan().error;
  return true;
}

bool is_below(const char* path) {
  return path != nullptr && plan().below != nullptr && std::strncmp(path, plan().below, plan().below_length) == 0;
}

bool is_watched(int fd) { return fd >= 0 && fd < kDescriptors && g_watched[static_cast<std::size_t>(fd)]; }
void watch(int fd, bool watched) {
  if (fd >= 0 && fd < kDescriptors) g_watched[static_cast<std::size_t>(fd)] = watched;
}

struct Path {
  char text[2 * PATH_MAX] = "";
};

Path path_of(int fd) {
  Path path;
  char link[64];
  std::snprintf(link, sizeof(link), "/proc/self/fd/%d", fd);
  const ssize_t length = NEXT(readlink)(link, path.text, PATH_MAX - 1);
  path.text[length < 0 ? 0 : length] = '\0';
  return path;
}

Path path_at(int folder, const char* name) {
  Path path;
  if (name[0] == '/' || folder == AT_FDCWD) {
    std::snprintf(path.text, sizeof(path.text), "%s", name);
  } else {
    path = path_of(folder);
    const std::size_t length = std::strlen(path.text);
    std::snprintf(path.text + length, sizeof(path.text) - length, "/%s", name);
  }
  return path;
}

bool fails_on(int fd, Call call) { return is_watched(fd) && fails(call, path_of(fd).text); }

template <typename Open>
int open_watched(const char* path, int flags, const Open& open) {
  const bool below = is_below(path);
  if (below && fails((flags & O_CREAT) != 0 ? kCreate : kOpen, path)) return -1;
  const int fd = open();
  watch(fd, below);
  return fd;
}

mode_t mode_in(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

// How much of it is moved: all, a part, or nothing (then it fails).
bool part(int fd, Call call, std::size_t& count) {
  if (count == 0 || !fails_on(fd, call)) return true;
  if (!plan().is_short) return false;
  count = (count + 1) / 2;
  return true;
}

}  // namespace

#define MODE(flags)                              \
  va_list arguments;                             \
  va_start(arguments, flags);                    \
  const mode_t mode = mode_in(flags, arguments); \
  va_end(arguments)

extern "C" {

int open(const char* path, int flags, ...) {
  MODE(flags);
  return open_watched(path, flags, [&] { return NEXT(open)(path, flags, mode); });
}
int open64(const char* path, int flags, ...) {
  MODE(flags);
  return open_watched(path, flags, [&] { return NEXT(open64)(path, flags, mode); });
}
int openat(int folder, const char* name, int flags, ...) {
  MODE(flags);
  return open_watched(path_at(folder, name).text, flags, [&] { return NEXT(openat)(folder, name, flags, mode); });
}
int close(int fd) {
  const bool failing = fails_on(fd, kClose);
  const int error = errno;
  watch(fd, false);
  const int result = NEXT(close)(fd);  // also where it fails, as Linux does
  if (!failing || plan().is_short) return result;
  errno = error;
  return -1;
}

ssize_t read(int fd, void* to, size_t count) { return part(fd, kRead, count) ? NEXT(read)(fd, to, count) : -1; }
ssize_t pread(int fd, void* to, size_t count, off_t at) { return part(fd, kRead, count) ? NEXT(pread)(fd, to, count, at) : -1; }
ssize_t pread64(int fd, void* to, size_t count, off64_t at) {
  return part(fd, kRead, count) ? NEXT(pread64)(fd, to, count, at) : -1;
}
ssize_t write(int fd, const void* from, size_t count) { return part(fd, kWrite, count) ? NEXT(write)(fd, from, count) : -1; }
ssize_t pwrite(int fd, const void* from, size_t count, off_t at) {
  return part(fd, kWrite, count) ? NEXT(pwrite)(fd, from, count, at) : -1;
}
ssize_t pwrite64(int fd, const void* from, size_t count, off64_t at) {
  return part(fd, kWrite, count) ? NEXT(pwrite64)(fd, from, count, at) : -1;
}

int fsync(int fd) { return fails_on(fd, kSync) ? -1 : NEXT(fsync)(fd); }
int fdatasync(int fd) { return fails_on(fd, kSync) ? -1 : NEXT(fdatasync)(fd); }
int ftruncate(int fd, off_t size) noexcept { return fails_on(fd, kResize) ? -1 : NEXT(ftruncate)(fd, size); }
int ftruncate64(int fd, off64_t size) noexcept { return fails_on(fd, kResize) ? -1 : NEXT(ftruncate64)(fd, size); }
int posix_fallocate(int fd, off_t begin, off_t size) {
  return fails_on(fd, kResize) ? plan().error : NEXT(posix_fallocate)(fd, begin, size);
}
int posix_fallocate64(int fd, off64_t begin, off64_t size) {
  return fails_on(fd, kResize) ? plan().error : NEXT(posix_fallocate64)(fd, begin, size);
}

int rename(const char* from, const char* to) noexcept { return is_below(to) && fails(kRename, to) ? -1 : NEXT(rename)(from, to); }
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) noexcept {
  const Path path = path_at(to_folder, to);
  if (is_below(path.text) && fails(kRename, path.text)) return -1;
  return NEXT(renameat2)(from_folder, from, to_folder, to, flags);
}
int unlink(const char* path) noexcept { return is_below(path) && fails(kRemove, path) ? -1 : NEXT(unlink)(path); }
int unlinkat(int folder, const char* name, int flags) noexcept {
  const Path path = path_at(folder, name);
  return is_below(path.text) && fails(kRemove, path.text) ? -1 : NEXT(unlinkat)(folder, name, flags);
}
int remove(const char* path) noexcept { return is_below(path) && fails(kRemove, path) ? -1 : NEXT(remove)(path); }
int rmdir(const char* path) noexcept { return is_below(path) && fails(kRemove, path) ? -1 : NEXT(rmdir)(path); }
int mkdir(const char* path, mode_t mode) noexcept {
  return is_below(path) && fails(kFolder, path) ? -1 : NEXT(mkdir)(path, mode);
}

int stat(const char* path, struct stat* status) noexcept {
  return is_below(path) && fails(kLook, path) ? -1 : NEXT(stat)(path, status);
}
int stat64(const char* path, struct stat64* status) noexcept {
  return is_below(path) && fails(kLook, path) ? -1 : NEXT(stat64)(path, status);
}
int lstat(const char* path, struct stat* status) noexcept {
  return is_below(path) && fails(kLook, path) ? -1 : NEXT(lstat)(path, status);
}
int lstat64(const char* path, struct stat64* status) noexcept {
  return is_below(path) && fails(kLook, path) ? -1 : NEXT(lstat64)(path, status);
}
int fstat(int fd, struct stat* status) noexcept { return fails_on(fd, kLook) ? -1 : NEXT(fstat)(fd, status); }
int fstat64(int fd, struct stat64* status) noexcept { return fails_on(fd, kLook) ? -1 : NEXT(fstat64)(fd, status); }

DIR* opendir(const char* path) { return is_below(path) && fails(kList, path) ? nullptr : NEXT(opendir)(path); }
DIR* fdopendir(int fd) { return fails_on(fd, kList) ? nullptr : NEXT(fdopendir)(fd); }
int closedir(DIR* folder) {
  watch(dirfd(folder), false);
  return NEXT(closedir)(folder);
}
struct dirent* readdir(DIR* folder) {
  const Path path = path_of(dirfd(folder));
  return is_below(path.text) && fails(kList, path.text) ? nullptr : NEXT(readdir)(folder);
}

}  // extern "C"
// NOLINTEND
