// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/pose_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "panoptic/base/files.h"
#include "panoptic/base/text.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_frame.h"
#include "panoptic/io/dataset_text.h"

namespace panoptic {
namespace {

enum class PoseLayout { kRows, kColumns, kRotationPosition, kPositionQuaternion, kQuaternionPosition };

// How the numbers of a line make a pose.
struct PoseForm {
  std::size_t count = 0;  // of numbers on the line
  std::size_t first = 0;  // where those of the pose begin; what is before is the key
  PoseLayout layout = PoseLayout::kRows;
  const char* words = "";
};

// Where several fit a count, the one that gives rotations counts, the earlier one where they are equal.
constexpr std::array<PoseForm, 14> kPoseForms = {{
    {16, 0, PoseLayout::kRows, "4x4 matrices row by row"},
    {16, 0, PoseLayout::kColumns, "4x4 matrices column by column"},
    {17, 1, PoseLayout::kRows, "4x4 matrices row by row after a number"},
    {17, 1, PoseLayout::kColumns, "4x4 matrices column by column after a number"},
    {12, 0, PoseLayout::kRows, "3x4 matrices row by row"},
    {12, 0, PoseLayout::kRotationPosition, "rotation row by row, then position"},
    {13, 1, PoseLayout::kRows, "3x4 matrices row by row after a number"},
    {13, 1, PoseLayout::kRotationPosition, "rotation row by row, then position, after a number"},
    {7, 0, PoseLayout::kPositionQuaternion, "position and quaternion"},
    {7, 0, PoseLayout::kQuaternionPosition, "quaternion and position"},
    {8, 1, PoseLayout::kPositionQuaternion, "position and quaternion after a number"},
    {8, 1, PoseLayout::kQuaternionPosition, "quaternion and position after a number"},
    {9, 1, PoseLayout::kPositionQuaternion, "position and quaternion between two numbers"},
    {9, 2, PoseLayout::kPositionQuaternion, "position and quaternion after two numbers"},
}};

// Where w stands in a quaternion: nothing = where it usually does.
using WFirst = std::optional<bool>;

Eigen::Matrix4d matrix_of(std::span<const double> n, const PoseForm& form, WFirst w_first) {
  n = n.subspan(form.first);
  const auto quaternion = [&](std::size_t at, bool first) {
    return first ? Eigen::Quaterniond(n[at], n[at + 1], n[at + 2], n[at + 3])
                 : Eigen::Quaterniond(n[at + 3], n[at], n[at + 1], n[at + 2]);
  };
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  switch (form.layout) {
    case PoseLayout::kRows:
      return *to_matrix(n.first(form.count - form.first));
    case PoseLayout::kColumns:
      return to_matrix(n.first(form.count - form.first))->transpose();
    case PoseLayout::kRotationPosition:
      for (Eigen::Index i = 0; i < 9; ++i) matrix(i / 3, i % 3) = n[static_cast<std::size_t>(i)];
      matrix.topRightCorner<3, 1>() = Vec3d(n[9], n[10], n[11]);
      return matrix;
    case PoseLayout::kPositionQuaternion:
      return to_matrix4({n[0], n[1], n[2]}, quaternion(3, w_first.value_or(false)));
    case PoseLayout::kQuaternionPosition:
      return to_matrix4({n[4], n[5], n[6]}, quaternion(0, w_first.value_or(true)));
  }
  return matrix;
}

struct PoseRow {
  std::size_t line = 0;
  std::string name;
  std::vector<double> numbers;
};

std::string form_text(const PoseForm& form, WFirst w_first) {
  const bool before = form.layout == PoseLayout::kQuaternionPosition;
  if (!before && form.layout != PoseLayout::kPositionQuaternion) return form.words;
  return fmt::format("{}, w {}", form.words, w_first.value_or(before) ? "first" : "last");
}

// Throws Error where a row has another count than the first, or no form has that count.
const PoseForm& form_of(const std::vector<PoseRow>& rows, const std::string& path, WFirst w_first) {
  const std::size_t count = rows.front().numbers.size();
  for (const PoseRow& row : rows) {
    if (row.numbers.size() == count) continue;
    throw Error(fmt::format("{}:{}: {} numbers, but {} in line {}; every line is one pose", path, row.line, row.numbers.size(),
                            count, rows.front().line));
  }
  const PoseForm* best = nullptr;
  std::ptrdiff_t most = -1;
  for (const PoseForm& form : kPoseForms) {
    if (form.count != count) continue;
    const auto rigid_rows = std::count_if(
        rows.begin(), rows.end(), [&](const PoseRow& row) { return check_pose(matrix_of(row.numbers, form, w_first)).used; });
    if (rigid_rows > most) best = &form;
    most = std::max(most, rigid_rows);
  }
  if (best != nullptr) return *best;
  throw Error(
      fmt::format("{}:{}: {} numbers, expected the 16 of a 4x4 matrix, 12 of a 3x4 or 7 of position and quaternion, each "
                  "also after a number or a name{}",
                  path, rows.front().line, count, count == 6 ? "; angles are not read" : ""));
}

// Rows that are matrices one row a line.
bool is_stacked(const std::vector<PoseRow>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const PoseRow& row) { return row.numbers.size() <= 4; }) &&
         std::any_of(rows.begin(), rows.end(), [](const PoseRow& row) { return row.numbers.size() == 4; });
}

// 4 if every fourth row is 0 0 0 1 (or the rows make no 3x4 matrices), else 3.
std::size_t rows_of_matrix(const std::vector<PoseRow>& rows, std::size_t begin, std::size_t end) {
  const std::array<double, 4> last = {0, 0, 0, 1};
  const auto count = end - begin;
  const bool is_last = count >= 4 && std::equal(last.begin(), last.end(), rows[begin + 3].numbers.begin());
  return (count % 4 == 0 && is_last) || count % 3 != 0 ? 4 : 3;
}

// The matrices of rows [begin, end), all of 4 numbers, to the list.
void add_matrices(const std::vector<PoseRow>& rows, std::size_t begin, std::size_t end, const std::string& path, PoseList& list) {
  const std::size_t height = rows_of_matrix(rows, begin, end);
  if ((end - begin) % height != 0) {
    throw Error(fmt::format("{}:{}: {} rows of 4 numbers from here on make neither 4x4 nor 3x4 matrices", path, rows[begin].line,
                            end - begin));
  }
  for (std::size_t at = begin; at < end; at += height) {
    std::vector<double> numbers;
    for (std::size_t i = at; i < at + height; ++i) numbers.insert(numbers.end(), rows[i].numbers.begin(), rows[i].numbers.end());
    list.poses.push_back({0, {}, *to_matrix(numbers)});
  }
  list.form = fmt::format("{}x4 matrices, a row a line", height);
}

PoseList stacked_poses(const std::vector<PoseRow>& rows, const std::string& path) {
  PoseList list;
  for (std::size_t at = 0; at < rows.size();) {
    const PoseRow& head = rows[at];
    const bool has_head = head.numbers.size() < 4;
    const std::size_t begin = has_head ? at + 1 : at;
    std::size_t end = begin;
    while (end < rows.size() && rows[end].numbers.size() == 4) ++end;
    const std::size_t before = list.poses.size();
    if (end > begin) add_matrices(rows, begin, end, path, list);
    if (has_head != (list.key != PoseKey::kNone) && before > 0)
      throw Error(fmt::format("{}:{}: some matrices have a line before them and others do not", path, head.line));
    if (has_head) {
      if (list.poses.size() != before + 1)
        throw Error(
            fmt::format("{}:{}: expected one matrix after this line, found {}", path, head.line, list.poses.size() - before));
      list.key = head.name.empty() ? PoseKey::kNumber : PoseKey::kName;
      list.poses.back().name = head.name;
      if (!head.numbers.empty()) list.poses.back().number = head.numbers.front();
    }
    at = end;
  }
  if (list.key != PoseKey::kNone) list.form += " after a line for each";
  return list;
}

// Decimal commas show by numbers that have one comma each, several on a line, and no point anywhere: then commas become points.
void mend_decimal_commas(std::string& text) {
  bool found = false;
  for_each_line_of(text, " \t\r;", [&](std::size_t, std::span<const std::string_view> words) {
    const auto is_decimal = [](std::string_view word) {
      const std::size_t comma = word.find(',');
      return comma != std::string_view::npos && comma > 0 && comma + 1 < word.size() &&
             word.find(',', comma + 1) == std::string_view::npos;
    };
    const bool has_list = std::any_of(words.begin(), words.end(), [&](std::string_view word) {
      return word.find(',') != std::string_view::npos && !is_decimal(word);
    });
    found = found || (words.size() > 2 && !has_list && std::any_of(words.begin(), words.end(), is_decimal));
  });
  if (found && text.find('.') == std::string::npos) std::replace(text.begin(), text.end(), ',', '.');
}

PoseRow to_row(std::size_t line, std::span<const std::string_view> words, const std::string& path) {
  PoseRow row{line, {}, {}};
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::optional<double> number = to_number(words[i]);
    const bool at_an_end = i == 0 || i + 1 == words.size();
    if (number) {
      row.numbers.push_back(*number);
    } else if (at_an_end && row.name.empty()) {
      row.name = words[i];
    } else {
      throw Error(fmt::format("{}:{}: expected a number, found '{}'", path, line, words[i].substr(0, 40)));
    }
  }
  return row;
}

std::vector<PoseRow> rows_of(const std::string& text, const std::string& path) {
  std::vector<PoseRow> rows;
  bool first = true;
  for_each_line_of(text, kMatrixSeparators, [&](std::size_t line, std::span<const std::string_view> words) {
    if (!(first && is_heading(words))) rows.push_back(to_row(line, words, path));
    first = false;
  });
  return rows;
}

}  // namespace

std::optional<bool> names_w_first(std::string_view text) {
  const std::string lower = lower_case(text);
  const std::size_t w = std::min(lower.find("qw"), lower.find("q_w"));
  const std::size_t x = std::min(lower.find("qx"), lower.find("q_x"));
  if (w == std::string::npos || x == std::string::npos) return std::nullopt;
  return w < x;
}

PoseList read_pose_list(const std::filesystem::path& path) {
  std::string text = read_file(path);
  mend_decimal_commas(text);
  const std::vector<PoseRow> rows = rows_of(text, path.string());
  if (rows.empty()) return {};
  if (is_stacked(rows)) return stacked_poses(rows, path.string());
  const WFirst w_first = names_w_first(text);
  const PoseForm& form = form_of(rows, path.string(), w_first);
  PoseList list;
  list.form = form_text(form, w_first);
  const bool named = std::all_of(rows.begin(), rows.end(), [](const PoseRow& row) { return !row.name.empty(); });
  list.key = named ? PoseKey::kName : form.first > 0 ? PoseKey::kNumber : PoseKey::kNone;
  for (const PoseRow& row : rows) {
    if (!named && !row.name.empty())
      throw Error(fmt::format("{}:{}: expected a number, found '{}'", path.string(), row.line, row.name));
    list.poses.push_back({row.numbers.front(), row.name, matrix_of(row.numbers, form, w_first)});
  }
  return list;
}

std::optional<Eigen::Matrix4d> to_pose(std::span<const double> numbers) {
  constexpr std::size_t kMostInAFile = 16;  // a file of one pose has no key but a time stamp
  if (numbers.size() > kMostInAFile || numbers.size() == 9 || numbers.size() == 13) return std::nullopt;
  const PoseForm* best = nullptr;
  for (const PoseForm& form : kPoseForms) {
    if (form.count != numbers.size()) continue;
    if (best == nullptr) best = &form;
    if (!check_pose(matrix_of(numbers, form, {})).used) continue;
    best = &form;
    break;
  }
  return best == nullptr ? std::nullopt : std::optional(matrix_of(numbers, *best, {}));
}

Eigen::Matrix4d to_matrix4(const Vec3d& position, const Eigen::Quaterniond& rotation) {
  constexpr double kMaxNormError = 0.05;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topRightCorner<3, 1>() = position;
  const double norm = rotation.norm();
  if (std::abs(norm - 1) > kMaxNormError) matrix.topLeftCorner<3, 3>().setZero();
  if (std::abs(norm - 1) <= kMaxNormError) matrix.topLeftCorner<3, 3>() = rotation.normalized().toRotationMatrix();
  if (!std::isfinite(norm)) matrix(0, 0) = norm;
  return matrix;
}

}  // namespace panoptic
