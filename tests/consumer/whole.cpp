// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Opens a simulated home, which needs every part of the library.
#include <panoptic/simulation.h>

#include <cstdio>

int main() {
  const auto dataset = panoptic::open_dataset("sim:1");
  std::printf("%s\n", dataset->description().c_str());
  return dataset->size() > 0 ? 0 : 1;
}
