// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "panoptic/error.h"
#include "panoptic/predict/decoders.h"
#include "panoptic/predict/output_shapes.h"

namespace panoptic {
namespace {

// One way to read one output.
struct Layout {
  std::size_t output = 0;
  std::string_view name;  // "nchw": classes first; "nhwc": classes last; "map": one number a pixel
  int width = 0;
  int height = 0;

  bool has_classes() const { return name != "map"; }
  long long cells() const { return static_cast<long long>(width) * height; }
};

// Whether a grid covers the input at one scale in both directions, give or take a cell.
bool covers_input(int width, int height, const InputFormat& input) {
  const double off = std::abs(static_cast<double>(width) * input.height - static_cast<double>(height) * input.width);
  return width >= 1 && height >= 1 && off <= input.width + input.height;
}

// The grid of so many cells in one row: the input divided by a stride.
bool find_grid(int cells, const InputFormat& input, Layout& layout) {
  for (const int stride : {1, 2, 4, 8, 16, 32}) {
    for (const int up : {0, stride - 1}) {
      layout.width = (input.width + up) / stride;
      layout.height = (input.height + up) / stride;
      if (layout.cells() == cells && cells > 1) return true;  // one cell: a classifier of images
    }
  }
  return false;
}

// Three dimensions, of which one may be the classes, or two with all cells in one row.
void add_layouts(const Tensor& tensor, std::size_t output, const Model& model, std::vector<Layout>& layouts) {
  const int classes = static_cast<int>(model.classes.size());
  const auto shape = tensor.shape.size() == 4 && tensor.shape[0] == 1 ? shape_of_rank(tensor, 3) : std::optional(tensor.shape);
  const auto add = [&](std::string_view name, int width, int height) {
    if (width >= 1 && height >= 1) layouts.push_back({output, name, width, height});
  };
  const std::vector<int>& s = *shape;
  if (s.size() == 3 && s[0] == classes) add("nchw", s[2], s[1]);
  if (s.size() == 3 && s[2] == classes) add("nhwc", s[1], s[0]);
  if (s.size() == 3 && s[0] == 1 && classes > 1) add("map", s[2], s[1]);
  if (s.size() == 3 && s[2] == 1 && s[0] != 1 && classes > 1) add("map", s[1], s[0]);
  if (s.size() == 2 && tensor.is_whole) add("map", s[1], s[0]);
  const std::vector<int> row = s.size() == 3 && s[0] == 1 && tensor.shape.size() == 3 ? std::vector<int>{s[1], s[2]} : s;
  Layout flat{output, "nchw"};
  if (row.size() == 2 && row[0] == classes && find_grid(row[1], model.input, flat)) layouts.push_back(flat);
  flat.name = "nhwc";
  if (row.size() == 2 && row[1] == classes && find_grid(row[0], model.input, flat)) layouts.push_back(flat);
  flat.name = "map";
  const bool may_be_row = tensor.is_whole || s.size() == 3;
  if (row.size() == 2 && row[0] == 1 && may_be_row && find_grid(row[1], model.input, flat)) layouts.push_back(flat);
}

// A map is of class numbers, or of the only probability of one or two classes.
bool is_map(const Tensor& tensor, const Model& model) {
  return tensor.is_whole || model.classes.size() <= 2 || are_whole(tensor.values);
}

std::vector<Layout> layouts_of(const std::vector<Tensor>& outputs, const Model& model) {
  std::vector<Layout> layouts;
  const std::optional<std::size_t> named = output_named_for("semantic", outputs, model, [](const Tensor&) { return true; });
  const std::string chosen = output_setting("layout", {"nchw", "nhwc", "map"}, model);
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (named && *named != i) continue;
    std::vector<Layout> own;
    add_layouts(outputs[i], i, model, own);
    std::erase_if(own, [&](const Layout& l) {
      const bool fits = chosen.empty() ? covers_input(l.width, l.height, model.input) : l.name == chosen;
      const bool has_numbers = l.has_classes() ? !outputs[i].is_whole : is_map(outputs[i], model);
      return l.cells() == 1 || !fits || !has_numbers;
    });
    layouts.insert(layouts.end(), own.begin(), own.end());
  }
  return layouts;
}

// Leaves the main one of several outputs: auxiliary heads say so in their names or are coarser, and class values say more than
// the numbers of the likeliest classes.
void choose_output(const std::vector<Tensor>& outputs, std::vector<Layout>& layouts) {
  prefer(layouts, [&](const Layout& l) { return !name_contains(outputs[l.output], "aux"); });
  prefer(layouts, [](const Layout& l) { return l.has_classes(); });
  long long finest = 0;
  for (const Layout& l : layouts) finest = std::max(finest, l.cells());
  prefer(layouts, [&](const Layout& l) { return l.cells() == finest; });
  if (layouts.size() > 1) {
    prefer(layouts, [&](const Layout& l) { return is_named(outputs[l.output], {"out", "output", "main", "logits", "pred"}); });
  }
}

// Whether the classes of cells all over the grid are shares that sum to one.
bool sum_to_one(const Tensor& tensor, const Layout& layout, std::size_t classes) {
  constexpr std::size_t kMostCells = 4096;
  constexpr float kTolerance = 0.02F;  // of 16-bit floats
  const auto cells = static_cast<std::size_t>(layout.cells());
  const bool last = layout.name == "nhwc";
  const std::size_t step = std::max<std::size_t>(1, cells / kMostCells);
  for (std::size_t i = 0; i < cells; i += step) {
    float sum = 0;
    for (std::size_t c = 0; c < classes; ++c) sum += last ? tensor.values[i * classes + c] : tensor.values[c * cells + i];
    if (!(std::abs(sum - 1) <= kTolerance)) return false;
  }
  return true;
}

// Values within [0, 1] are probabilities: of one another's rest (softmax) or each for itself (sigmoid). Logits go below 0.
Numbers numbers_in(const Tensor& tensor, const Layout& layout, const Model& model) {
  const std::string chosen = output_setting("values", {"logits", "probabilities", "class numbers"}, model);
  if (chosen == "logits") return Numbers::kLogits;
  if (chosen == "probabilities") return Numbers::kProbabilities;
  const bool is_single = !layout.has_classes();
  if (is_single && (tensor.is_whole || chosen == "class numbers" || are_whole(tensor.values))) return Numbers::kClassNumbers;
  if (!are_shares(tensor.values)) return Numbers::kLogits;
  const std::size_t classes = model.classes.size();
  if (is_single || classes == 1 || sum_to_one(tensor, layout, classes)) return Numbers::kProbabilities;
  const bool is_dead = std::all_of(tensor.values.begin(), tensor.values.end(), [&](float v) { return v == tensor.values[0]; });
  return is_dead ? Numbers::kLogits : Numbers::kProbabilities;
}

std::string_view text_of(Numbers numbers) {
  if (numbers == Numbers::kClassNumbers) return "class numbers";
  return numbers == Numbers::kLogits ? "class logits" : "class probabilities";
}

// A reason why an output that has the classes is not read nevertheless.
std::string why_not_this(const Layout& layout, const InputFormat& input) {
  if (layout.cells() == 1) return "; one value a class is what classifiers of whole images give";
  if (covers_input(layout.width, layout.height, input)) return "";
  return fmt::format(
      "; a grid of {} x {} does not cover an input of {} x {} at one scale: transposed? If it does, say [outputs] layout = "
      "\"{}\"",
      layout.width, layout.height, input.width, input.height, layout.name);
}

std::string why_not(const std::vector<Tensor>& outputs, const Model& model) {
  std::string hint;
  std::vector<Layout> layouts;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    add_layouts(outputs[i], i, model, layouts);
    for (const int extent : outputs[i].shape) {
      if (extent == static_cast<int>(model.classes.size()) + 1) {
        hint = fmt::format("; with {} classes it would be: does the description lack one, for the background?", extent);
      }
    }
  }
  for (const Layout& layout : layouts) {
    if (layout.has_classes()) hint = why_not_this(layout, model.input);
  }
  return fmt::format("no output has the {} classes of the description on a grid, or class numbers{}", model.classes.size(), hint);
}

}  // namespace

Match recognise_semantic(const std::vector<Tensor>& outputs, const Model& model) {
  std::vector<Layout> layouts = layouts_of(outputs, model);
  if (layouts.empty()) return {.why_not = why_not(outputs, model)};
  choose_output(outputs, layouts);
  if (layouts.size() > 1) {
    std::vector<std::string> choices;
    const bool same_output = layouts[0].output == layouts[1].output;
    for (const Layout& l : layouts) {
      choices.push_back(same_output ? fmt::format("layout = \"{}\"", l.name)
                                    : fmt::format("semantic = \"{}\"", outputs[l.output].name));
    }
    return {.choices = fmt::format("choose in the description: [outputs] {}", fmt::join(choices, " or "))};
  }
  const Layout& layout = layouts[0];
  const Tensor& tensor = outputs[layout.output];
  Reading reading;
  reading.roles = {layout.output};
  reading.numbers = numbers_in(tensor, layout, model);
  reading.channels_last = layout.name == "nhwc";
  reading.width = layout.width;
  reading.height = layout.height;
  reading.text =
      fmt::format("{} ({}) on a grid of {} x {}", text_of(reading.numbers), name_and_shape(tensor), layout.width, layout.height);
  return {.reading = std::move(reading)};
}

}  // namespace panoptic
