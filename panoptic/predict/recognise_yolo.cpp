// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <map>

#include "panoptic/predict/decoders.h"
#include "panoptic/predict/output_shapes.h"
#include "panoptic/predict/yolo_form.h"

namespace panoptic {
namespace {

// The parts of a head, in the order of roles.
enum Part { kBoxes, kClasses, kMasks };
constexpr std::array<std::string_view, 3> kPartNames = {"boxes", "classes", "masks"};
using Order = std::array<std::size_t, 3>;  // of the three outputs of a grid: which is boxes, which classes, which masks

struct Grid {
  int channels = 0;
  int width = 0;
  int height = 0;
};

std::optional<Grid> grid_of(const Tensor& tensor, bool channels_last) {
  const auto shape = shape_of_rank(tensor, 3);
  if (!shape || tensor.is_whole) return std::nullopt;
  const std::vector<int>& s = *shape;
  return channels_last ? Grid{s[2], s[1], s[0]} : Grid{s[0], s[2], s[1]};
}

// Whether cells are squares of the input.
bool divides_input(const Grid& grid, const InputFormat& input) {
  return grid.width >= 1 && grid.height >= 1 && grid.channels >= 1 && input.width % grid.width == 0 &&
         input.height % grid.height == 0 && input.width / grid.width == input.height / grid.height;
}

// The boxes of a network with three strides, or four: one per cell of each.
bool is_count_of_boxes(int count, const InputFormat& input) {
  long long boxes = 0;
  for (const int stride : {8, 16, 32, 64}) {
    boxes += static_cast<long long>(input.width / stride) * (input.height / stride);
    if (stride >= 32 && (count == boxes || count == 3 * boxes)) return true;
  }
  return false;
}

// ---- one output with all boxes, and prototypes

struct Prototypes {
  std::size_t output = 0;
  int masks = 0;
  bool channels_last = false;
};

// A cube that covers the input with square cells: masks first, or last.
std::optional<Prototypes> find_prototypes(const std::vector<Tensor>& outputs, const InputFormat& input) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (outputs[i].shape.size() != 4) continue;
    for (const bool last : {false, true}) {
      const auto grid = grid_of(outputs[i], last);
      if (grid && divides_input(*grid, input)) return Prototypes{i, grid->channels, last};
    }
  }
  return std::nullopt;
}

// How many numbers a box has, and what they are.
std::optional<YoloForm> form_of(int numbers, int boxes, int classes, int masks, const InputFormat& input) {
  constexpr int kMostSuppressed = 1000;
  const bool may_be_raw = is_count_of_boxes(boxes, input) || boxes > kMostSuppressed;
  if (may_be_raw && numbers == 4 + classes + masks) return YoloForm::kRaw;
  if (may_be_raw && numbers == 5 + classes + masks) return YoloForm::kRawWithObjects;
  if (!may_be_raw && numbers == 6 + masks) return YoloForm::kSuppressed;
  if (numbers == 4 + classes + masks) return YoloForm::kRaw;
  return std::nullopt;
}

Numbers numbers_of_boxes(const Tensor& tensor, const Reading& reading, std::size_t classes) {
  const auto columns = static_cast<std::size_t>(tensor.shape.back());
  const std::size_t first = static_cast<YoloForm>(reading.form) == YoloForm::kRaw ? 4 : 5;
  bool are_probabilities = true;
  if (!reading.channels_last) {
    are_probabilities = are_shares(std::span(tensor.values).subspan(first * columns, classes * columns));
  } else {
    for (std::size_t i = 0; i < tensor.values.size() && are_probabilities; i += columns) {
      are_probabilities = are_shares(std::span(tensor.values).subspan(i + first, classes));
    }
  }
  return are_probabilities ? Numbers::kProbabilities : Numbers::kLogits;
}

constexpr std::array<std::string_view, 4> kFormTexts = {
    "the heads of a YOLO with masks", "boxes and masks of a YOLO, before suppression",
    "boxes and masks of a YOLO with objectness, before suppression", "boxes and masks of a YOLO, after suppression"};

Match recognise_boxes(const std::vector<Tensor>& outputs, const Model& model) {
  const auto prototypes = find_prototypes(outputs, model.input);
  const int classes = static_cast<int>(model.classes.size());
  std::string why = "it lacks boxes 1 x (4 + classes + masks) x n";
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const auto shape = outputs[i].shape.size() == 4 ? std::nullopt : shape_of_rank(outputs[i], 2);
    if (!shape || outputs[i].is_whole || (*shape)[0] < 1 || (*shape)[1] < 1) continue;
    const int shorter = std::min((*shape)[0], (*shape)[1]);
    if (!prototypes) return {.why_not = "it gives boxes without masks: export the variant for segmentation"};
    for (const bool last : {false, true}) {
      const int numbers = (*shape)[last ? 1 : 0];
      const auto form = form_of(numbers, (*shape)[last ? 0 : 1], classes, prototypes->masks, model.input);
      if (!form) continue;
      Reading reading;
      reading.form = static_cast<int>(*form);
      reading.roles = {i, prototypes->output};
      reading.channels_last = last;
      reading.masks_last = prototypes->channels_last;
      const bool suppressed = *form == YoloForm::kSuppressed;
      reading.numbers = suppressed ? Numbers::kProbabilities : numbers_of_boxes(outputs[i], reading, model.classes.size());
      reading.text = fmt::format("{} ({})", kFormTexts[static_cast<std::size_t>(reading.form)], name_and_shape(outputs[i]));
      return {.reading = std::move(reading)};
    }
    if (shorter <= 4 + prototypes->masks) continue;
    why = fmt::format("its boxes have {} numbers, that is {} classes and {} masks, but the description has {} classes", shorter,
                      shorter - 4 - prototypes->masks, prototypes->masks, classes);
  }
  return {.why_not = why};
}

// ---- heads

// The part that an output is by its name. cv2, cv3 and cv4 are what Ultralytics calls these parts of its heads.
std::optional<Part> part_in_name(const Tensor& tensor) {
  const std::string& name = tensor.name;
  const bool is_short =
      name.size() > 1 && std::all_of(name.begin() + 1, name.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  const auto says = [&](std::initializer_list<std::string_view> words, char letter) {
    return (is_short && std::tolower(static_cast<unsigned char>(name[0])) == letter) ||
           std::any_of(words.begin(), words.end(), [&](std::string_view word) { return name_contains(tensor, word); });
  };
  if (says({"cv2", "box", "dfl", "reg"}, 'b')) return kBoxes;
  if (says({"cv3", "cls", "class", "conf", "score"}, 'c')) return kClasses;
  if (says({"cv4", "coef", "mask"}, 'm')) return kMasks;
  return std::nullopt;
}

// Objects are rare, so class values are nearly all below 0, or small probabilities; distributions and coefficients are not.
bool looks_like_classes(const Tensor& tensor) {
  constexpr double kMostAbove = 0.05;
  if (are_shares(tensor.values)) {
    return std::count_if(tensor.values.begin(), tensor.values.end(), [](float v) { return v > 0 && v < 0.5F; }) > 0;
  }
  const auto above = std::count_if(tensor.values.begin(), tensor.values.end(), [](float v) { return !(v < 0); });
  return static_cast<double>(above) <= kMostAbove * static_cast<double>(tensor.values.size());
}

// The shapes of the heads of one grid.
struct HeadShape {
  const std::vector<Tensor>& outputs;
  const Model& model;
  int masks = 0;
  bool channels_last = false;

  int channels(std::size_t output) const { return grid_of(outputs[output], channels_last)->channels; }
};

std::vector<Order> orders_of(const std::vector<std::size_t>& members, const HeadShape& shape) {
  constexpr int kMinBins = 2;
  std::vector<Order> orders;
  Order order = {0, 1, 2};
  do {
    const int sides = shape.channels(members[order[kBoxes]]);
    if (sides % 4 == 0 && sides >= 4 * kMinBins && shape.channels(members[order[kMasks]]) == shape.masks &&
        shape.channels(members[order[kClasses]]) == static_cast<int>(shape.model.classes.size())) {
      orders.push_back(order);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return orders;
}

// Where the numbers of channels leave several orders: what the description says, then the names, then the values, then the order
// that a description with `decoder` promises.
void choose_order(const std::vector<std::size_t>& members, const HeadShape& shape, std::vector<Order>& orders) {
  const std::string chosen = output_setting("order",
                                            {"boxes classes masks", "boxes masks classes", "classes boxes masks",
                                             "classes masks boxes", "masks boxes classes", "masks classes boxes"},
                                            shape.model);
  prefer(orders, [&](const Order& order) {
    std::array<std::string_view, 3> said;
    for (std::size_t part = 0; part < 3; ++part) said[order[part]] = kPartNames[part];
    return chosen == fmt::format("{} {} {}", said[0], said[1], said[2]);
  });
  prefer(orders, [&](const Order& order) {
    for (std::size_t part = 0; part < 3; ++part) {
      const auto named = part_in_name(shape.outputs[members[order[part]]]);
      if (named && *named != static_cast<Part>(part)) return false;
    }
    return true;
  });
  if (orders.size() > 1) {
    prefer(orders, [&](const Order& order) {
      return looks_like_classes(shape.outputs[members[order[kClasses]]]) &&
             !looks_like_classes(shape.outputs[members[order[kBoxes]]]);
    });
  }
  if (!shape.model.decoder.empty()) prefer(orders, [](const Order& order) { return order == Order{0, 1, 2}; });
}

// Outputs by the width of their grid, the widest first; those with a single channel that sum up classes are left out.
using OutputsByGrid = std::map<int, std::vector<std::size_t>, std::greater<>>;
OutputsByGrid by_grid(const std::vector<Tensor>& outputs, const Model& model, bool channels_last) {
  OutputsByGrid grids;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const auto grid = grid_of(outputs[i], channels_last);
    if (outputs[i].shape.size() != 4 || !grid || !divides_input(*grid, model.input)) return {};
    grids[grid->width].push_back(i);
  }
  for (auto& [width, members] : grids) {
    for (std::size_t k = members.size(); k-- > 0 && members.size() > 3;) {
      if (grid_of(outputs[members[k]], channels_last)->channels == 1)
        members.erase(members.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }
  return grids;
}

Match recognise_heads(const std::vector<Tensor>& outputs, const Model& model, bool channels_last) {
  auto grids = by_grid(outputs, model, channels_last);
  if (grids.size() < 2) return {.why_not = fmt::format("it has {} outputs that are no grids over the input", outputs.size())};
  const auto finest = grids.begin();
  if (finest->second.size() != 1) return {.why_not = "the finest grid is not that of prototypes alone"};
  const std::size_t prototypes = finest->second[0];
  grids.erase(finest);
  const HeadShape shape{outputs, model, grid_of(outputs[prototypes], channels_last)->channels, channels_last};
  std::array<std::vector<std::size_t>, 3> parts;
  for (const auto& [width, members] : grids) {
    if (members.size() != 3)
      return {.why_not =
                  fmt::format("the grid {} cells wide has {} outputs, not boxes, classes and masks", width, members.size())};
    std::vector<Order> orders = orders_of(members, shape);
    if (orders.empty()) {
      return {.why_not = fmt::format(
                  "on the grid {} cells wide are {}, {} and {} channels, which are not 4 x bins, {} classes and {} masks", width,
                  shape.channels(members[0]), shape.channels(members[1]), shape.channels(members[2]), model.classes.size(),
                  shape.masks)};
    }
    choose_order(members, shape, orders);
    if (orders.size() > 1) {
      return {.choices =
                  "boxes, classes and masks have equal numbers of channels: say which come first on each grid, as in [outputs] "
                  "order = \"boxes classes masks\""};
    }
    for (std::size_t part = 0; part < 3; ++part) parts[part].push_back(members[orders[0][part]]);
  }
  Reading reading;
  for (const auto& part : parts) reading.roles.insert(reading.roles.end(), part.begin(), part.end());
  reading.roles.push_back(prototypes);
  reading.form = static_cast<int>(YoloForm::kHeads);
  reading.channels_last = channels_last;
  reading.masks_last = channels_last;
  const bool are_probabilities =
      std::all_of(parts[kClasses].begin(), parts[kClasses].end(), [&](std::size_t i) { return are_shares(outputs[i].values); });
  reading.numbers = are_probabilities ? Numbers::kProbabilities : Numbers::kLogits;
  reading.text =
      fmt::format("{}, {} strides, {}", kFormTexts[0], grids.size(), are_probabilities ? "class probabilities" : "class logits");
  return {.reading = std::move(reading)};
}

}  // namespace

Match recognise_yolo(const std::vector<Tensor>& outputs, const Model& model) {
  if (outputs.empty()) return {.why_not = "it has 0 outputs"};
  Match heads;
  for (const bool last : {false, true}) {
    Match match = recognise_heads(outputs, model, last);
    if (match.reading || !match.choices.empty()) return match;
    if (!last) heads = std::move(match);
  }
  const bool are_boxes =
      std::any_of(outputs.begin(), outputs.end(), [](const Tensor& t) { return t.shape.size() == 3 || t.shape.size() == 2; });
  return are_boxes ? recognise_boxes(outputs, model) : heads;
}

}  // namespace panoptic
