// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/dataset_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "panoptic/base/files.h"
#include "panoptic/base/text.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

std::vector<std::string_view> split(std::string_view line, std::string_view separators) {
  std::vector<std::string_view> words;
  std::size_t begin = line.find_first_not_of(separators);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(separators, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(separators, end);
  }
  return words;
}

// The digits between prefix and suffix as a number; nothing if the name has another form.
std::optional<std::int64_t> number_in(std::string_view name, std::string_view prefix, std::string_view suffix) {
  if (name.size() <= prefix.size() + suffix.size() || !name.starts_with(prefix) || !name.ends_with(suffix)) return std::nullopt;
  const std::string_view digits = name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
  if (digits.front() == '-') return std::nullopt;
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return number;
}

// Intrinsics with their names: "fx: 585" a line, "fx = 585, fy = 585 ...", or a heading over the numbers. Nothing in a text that
// does not name all four.
std::optional<std::array<double, 4>> named_intrinsics(const std::string& text) {
  constexpr std::array<std::string_view, 4> kNames = {"fx", "fy", "cx", "cy"};
  std::vector<std::size_t> named;
  std::vector<double> numbers;
  for_each_line_of(text, " \t\r,;:=[](){}\"", [&](std::size_t, std::span<const std::string_view> words) {
    for (const std::string_view word : words) {
      const auto* name = std::find(kNames.begin(), kNames.end(), lower_case(word));
      if (name != kNames.end()) named.push_back(static_cast<std::size_t>(name - kNames.begin()));
      if (const auto number = to_number(word)) numbers.push_back(*number);
    }
  });
  std::array<double, 4> values{};
  if (named.size() != kNames.size() || numbers.size() != kNames.size()) return std::nullopt;
  for (std::size_t i = 0; i < named.size(); ++i) values.at(named[i]) = numbers[i];
  std::sort(named.begin(), named.end());
  if (std::adjacent_find(named.begin(), named.end()) != named.end()) return std::nullopt;
  return values;
}

}  // namespace

void for_each_line_of(std::string_view text, std::string_view separators, const LineCallback& callback) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {  // UTF-16, in which plain letters have a zero byte each
    std::string narrow(text.substr(2));
    std::erase(narrow, '\0');
    return for_each_line_of(narrow, separators, callback);
  }
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const char line_end = text.find('\n') == std::string_view::npos ? '\r' : '\n';  // some write \r alone
  std::size_t begin = 0;
  for (std::size_t line = 1; begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find(line_end, begin), text.size());
    const std::vector<std::string_view> words = split(text.substr(begin, end - begin), separators);
    if (!words.empty() && !words.front().starts_with('#')) callback(line, words);
    begin = end + 1;
  }
}

void for_each_line(const std::filesystem::path& path, const LineCallback& callback) {
  for_each_line_of(read_file(path), kWordSeparators, callback);
}

std::string with_slashes(std::string_view path) {
  std::string result(path);
  std::replace(result.begin(), result.end(), '\\', '/');
  return result;
}

bool is_heading(std::span<const std::string_view> words) {
  return words.size() > 1 &&
         std::none_of(words.begin(), words.end(), [](std::string_view w) { return to_number(w).has_value(); });
}

std::optional<double> to_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const std::string_view rest = word.substr(static_cast<std::size_t>(end - word.data()));
  if (error == std::errc::result_out_of_range) value = std::numeric_limits<double>::quiet_NaN();
  if (error == std::errc::invalid_argument) return std::nullopt;
  // Programs built with older Microsoft compilers print -1.#INF and 1.#QNAN.
  if (rest == "#INF" || rest == "#IND" || rest == "#QNAN" || rest == "#J") return std::numeric_limits<double>::quiet_NaN();
  return rest.empty() ? std::optional(value) : std::nullopt;
}

std::vector<double> to_numbers(std::span<const std::string_view> words, const std::filesystem::path& path, std::size_t line) {
  std::vector<double> numbers;
  numbers.reserve(words.size());
  for (const std::string_view word : words) {
    const std::optional<double> number = to_number(word);
    if (!number) throw Error(fmt::format("{}:{}: expected a number, found '{}'", path.string(), line, word));
    numbers.push_back(*number);
  }
  return numbers;
}

std::vector<double> numbers_in(std::string_view text, const std::filesystem::path& path) {
  std::vector<double> numbers;
  for_each_line_of(text, kMatrixSeparators, [&](std::size_t line, std::span<const std::string_view> words) {
    const std::vector<double> row = to_numbers(words, path, line);
    numbers.insert(numbers.end(), row.begin(), row.end());
  });
  return numbers;
}

std::vector<double> read_numbers(const std::filesystem::path& path) { return numbers_in(read_file(path), path); }

std::optional<Eigen::Matrix4d> to_matrix(std::span<const double> numbers) {
  constexpr std::size_t kFull = 16;
  constexpr std::size_t kWithoutLastRow = 12;
  if (numbers.size() != kFull && numbers.size() != kWithoutLastRow) return std::nullopt;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < numbers.size(); ++i)
    matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) = numbers[i];
  return matrix;
}

Camera to_camera(std::span<const double> numbers, const std::string& source) {
  constexpr std::size_t kBare = 4;
  constexpr std::size_t kThreeByThree = 9;
  const std::size_t columns = numbers.size() == kThreeByThree ? 3 : 4;
  if (numbers.size() != kBare && numbers.size() != kThreeByThree && !to_matrix(numbers)) {
    throw Error(fmt::format("{}: {} numbers, expected fx fy cx cy or a 3x3 or 4x4 intrinsic matrix", source, numbers.size()));
  }
  Camera camera;
  if (numbers.size() == kBare) {
    camera = {0, 0, numbers[0], numbers[1], numbers[2], numbers[3]};
  } else {
    const auto at = [&](std::size_t row, std::size_t column) { return numbers[row * columns + column]; };
    const bool by_columns = at(0, 2) == 0 && at(1, 2) == 0 && at(2, 0) != 0 && at(2, 1) != 0;
    camera = {0, 0, at(0, 0), at(1, 1), by_columns ? at(2, 0) : at(0, 2), by_columns ? at(2, 1) : at(1, 2)};
    if (at(2, 2) != 1 || (!by_columns && (at(2, 0) != 0 || at(2, 1) != 0))) camera.fx = 0;
  }
  const bool usable = std::isfinite(camera.fx) && std::isfinite(camera.fy) && std::isfinite(camera.cx) &&
                      std::isfinite(camera.cy) && camera.fx > 0 && camera.fy > 0;
  if (!usable) {
    throw Error(fmt::format("{}: no usable intrinsic matrix; expected [fx 0 cx; 0 fy cy; 0 0 1] in pixels", source));
  }
  return camera;
}

Camera read_camera_matrix(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  if (const auto named = named_intrinsics(text)) return to_camera(*named, path.string());
  return to_camera(numbers_in(text, path), path.string());
}

NumberedFiles numbered_files(const std::filesystem::path& root, const std::string& folder, std::string_view prefix,
                             std::span<const std::string_view> suffixes) {
  NumberedFiles files;
  for (const std::string& name : names_in_folder(root / folder)) {
    for (const std::string_view suffix : suffixes) {
      const std::optional<std::int64_t> number = number_in(lower_case(name), prefix, suffix);
      if (!number) continue;
      const std::string path = (std::filesystem::path(folder) / name).string();
      const auto [at, added] = files.emplace(*number, path);
      if (!added) at->second = std::min(at->second, path);  // 1.jpg beside 1.png: the same choice on every file system
    }
  }
  return files;
}

}  // namespace panoptic
