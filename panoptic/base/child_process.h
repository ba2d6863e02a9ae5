// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Other programs, started by this one, and the right to a folder that is theirs as well as ours.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace panoptic {

// A program that has ended.
struct EndedChild {
  int exit_code = 0;   // 128 + the signal if one ended it
  double peak_mb = 0;  // most memory that it had at a time
};

// The running program, to start it once more: the same file, even if another one was put in its place meanwhile.
inline constexpr const char* kThisProgram = "/proc/self/exe";

// Starts a program (found along PATH if it is a bare name) with its arguments; what it prints is added to the end of `log`, and
// nothing can be typed into it. It is killed when this process dies, however that happens. Call it from the main thread.
// Throws FileError if the log cannot be written, Error if the program cannot be started. Returns the number of the process.
int start_child(const std::vector<std::string>& command, const std::filesystem::path& log);

// Nothing as long as it runs. Once it has ended, the number is not valid any more. Both throw Error if it is none of a child.
std::optional<EndedChild> ended_child(int id);
EndedChild wait_for_child(int id);

void ask_child_to_end(int id);  // SIGTERM
void kill_child(int id);

// A right to a folder, by a lock on a file in it, which one process has alone or many share. It is also that of all children
// which are started meanwhile: it ends with the last of them, whatever happened to this process.
class FolderClaim {
 public:
  enum class Kind { kAlone, kShared };

  // Throws FileError if the file cannot be made or locked at all.
  FolderClaim(const std::filesystem::path& lock_file, Kind kind);
  ~FolderClaim();
  FolderClaim(const FolderClaim&) = delete;
  FolderClaim& operator=(const FolderClaim&) = delete;

  bool is_ours() const { return is_ours_; }  // false: somebody else has it

 private:
  int descriptor_ = -1;
  bool is_ours_ = false;
};

// The claim, waited for as long as somebody else has it, but no longer than that; nothing if they keep it. Children of a process
// that was killed die with it, but may need a moment. Throws FileError.
std::unique_ptr<FolderClaim> claim_folder(const std::filesystem::path& lock_file, FolderClaim::Kind kind, double patience_s);

}  // namespace panoptic
