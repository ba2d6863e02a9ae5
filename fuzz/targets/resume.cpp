// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <optional>

#include "fuzz/input.h"
#include "fuzz/small_map.h"
#include "panoptic/base/compression.h"
#include "panoptic/mapfile/run_notes.h"

namespace panoptic::fuzz {

// Fuzzes the data that a run keeps in its map file to go on from there: the counters, then three states.
void resume(Input input) {
  static const Scratch kScratch("resume");
  static SavedMap saved = [] {
    save_small_map(kScratch.path() / "a.panoptic");
    return load_map(kScratch.path() / "a.panoptic");
  }();
  constexpr const char* kNames[] = {"together", "overruled", "regularized"};
  const std::vector<Input> parts = parts_of(input, 1 + std::size(kNames));
  saved.notes.texts["session"] = std::string(text_of(parts[0]));
  for (std::size_t i = 0; i < std::size(kNames); ++i) {
    saved.notes.states[kNames[i]] = i + 1 < parts.size() ? Bytes(parts[i + 1].begin(), parts[i + 1].end()) : Bytes();
  }
  std::optional<SavedState> state;
  if (!succeeds([&] { state = saved_state(saved); })) return;
  const MapNotes written = notes_of(*state);
  for (const auto& [name, text] : written.texts) saved.notes.texts[name] = text;
  for (const auto& [name, bytes] : written.states) saved.notes.states[name] = bytes;
  require(succeeds([&] { state = saved_state(saved); }), "a state that was written can be read");
  const MapNotes again = notes_of(*state);
  require(again.texts == written.texts && again.states == written.states, "a state survives writing and reading");
}

}  // namespace panoptic::fuzz
