// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs kept inputs without a fuzzer, so that every build and every compiler tries them: fuzz_replay FOLDER..., where
// FOLDER/<target> holds the inputs of a target.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "fuzz/input.h"
#include "panoptic/base/files.h"

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::size_t replay(const fs::path& folder) {
  std::size_t count = 0;
  for (const panoptic::fuzz::Target& target : panoptic::fuzz::targets()) {
    for (const fs::path& file : files_in(folder / target.name)) {
      std::printf("%s\n", file.c_str());
      std::fflush(stdout);  // the last one named is the one that did it
      const std::string bytes = panoptic::read_file(file);
      target.run(panoptic::fuzz::bytes_of(bytes));
      ++count;
    }
  }
  std::printf("%zu inputs in %s\n", count, folder.c_str());
  return count;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: fuzz_replay FOLDER...\n");
    return 2;
  }
  try {
    for (int i = 1; i < count; ++i) {
      if (replay(arguments[i]) == 0) return 1;  // a test that tries nothing must not pass
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuzz_replay: %s\n", error.what());
    return 1;
  }
}
