// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/input.h"
#include "panoptic/base/config.h"
#include "panoptic/io/calibration.h"
#include "panoptic/io/recording_list.h"
#include "panoptic/labels.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/options.h"
#include "panoptic/predict/model.h"

namespace panoptic::fuzz {
namespace {

void options(std::string_view text) {
  Options read;
  read_toml_text(text, "input", fields(read));
  Options again;
  const std::string written = to_toml(fields(read));
  require(succeeds([&] { read_toml_text(written, "written", fields(again)); }), "options that were written can be read");
  require(to_toml(fields(again)) == written, "options survive writing and reading");
}

void model(const std::filesystem::path& path) {
  const Model read = load_model(path);
  static const LabelSet kLabels = load_label_set("indoor");
  succeeds([&] { map_classes(read, kLabels); });
  succeeds([&] { find_weights(read, Engine::kOnnxRuntime); });
}

// The files of recordings: a list, and a calibration.
void recording(const std::filesystem::path& path) {
  succeeds([&] { read_recording_list(path); });
  Calibration read;
  read_calibration(path, read);
  succeeds([&] { fitted(read, {640, 480}, {1296, 968}, "input"); });
}

}  // namespace

// The first byte says what kind of file the rest is.
void toml(Input input) {
  static const Scratch kScratch("toml");
  if (input.empty()) return;
  const Input text = input.subspan(1);
  const std::filesystem::path path = kScratch.put("a.toml", text);
  succeeds([&] {
    switch (input[0] % 5) {
      case 0:
        return options(text_of(text));
      case 1:
        return model(path);
      case 2:
        return recording(path);
      case 3:
        load_label_set(path.string());
        return;
      default:
        Options set;
        return set_field(fields(set), text_of(text));
    }
  });
}

}  // namespace panoptic::fuzz
