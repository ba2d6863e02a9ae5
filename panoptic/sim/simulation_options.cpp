// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <charconv>
#include <string_view>

#include "panoptic/error.h"
#include "panoptic/sim/simulation.h"

namespace panoptic {
namespace {

constexpr std::string_view kPrefix = "sim:";

[[noreturn]] void reject(const std::string& text, std::string_view part) {
  throw Error(fmt::format(
      "{}: '{}' is not understood; write sim:SEED, for example sim:7 or sim:7,rooms=2,frames=300,noise=none,dynamics=busy", text,
      part));
}

template <typename Number>
Number parse_number(const std::string& text, std::string_view part, std::string_view digits) {
  Number value{};
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || end != digits.data() + digits.size()) reject(text, part);
  return value;
}

void set(const std::string& text, std::string_view part, SimulationOptions& options) {
  const std::size_t equals = part.find('=');
  if (equals == std::string_view::npos) reject(text, part);
  const std::string_view key = part.substr(0, equals);
  const std::string_view value = part.substr(equals + 1);
  if (key == "rooms") {
    options.rooms = parse_number<int>(text, part, value);
  } else if (key == "frames") {
    options.frames = parse_number<int>(text, part, value);
  } else if (key == "jumps") {
    options.jumps = parse_number<int>(text, part, value);
  } else if (key == "noise") {
    options.noise = value;
    sensor_noise_preset(options.noise);
  } else if (key == "dynamics") {
    options.dynamics = value;
    dynamics_of(options.dynamics);
  } else {
    reject(text, part);
  }
}

}  // namespace

SimulationOptions parse_simulation(const std::string& text) {
  std::string_view rest = text;
  if (!rest.starts_with(kPrefix)) reject(text, rest);
  rest.remove_prefix(kPrefix.size());
  SimulationOptions options;
  std::string_view part = rest.substr(0, rest.find(','));
  options.seed = parse_number<std::uint64_t>(text, part, part);
  while (part.size() < rest.size()) {
    rest.remove_prefix(part.size() + 1);
    part = rest.substr(0, rest.find(','));
    set(text, part, options);
  }
  return options;
}

}  // namespace panoptic
