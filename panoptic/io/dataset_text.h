// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Small pieces that the folder formats share: numbers in text files, files with numbers in their names.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/geometry.h"

namespace panoptic {

// Calls back for every line that holds words (separated by blanks, tabs or commas) with its number, counted from 1. Comments
// (#), blank lines and a byte order mark are left out. Throws Error if the file cannot be read.
using LineCallback = std::function<void(std::size_t line, std::span<const std::string_view> words)>;
void for_each_line(const std::filesystem::path& path, const LineCallback& callback);

// The same for a text that was read already, with these separators or others.
constexpr std::string_view kWordSeparators = " \t\r,";
constexpr std::string_view kMatrixSeparators = " \t\r,;[](){}";  // also of matrices as numpy, Matlab and JSON print them
void for_each_line_of(std::string_view text, std::string_view separators, const LineCallback& callback);

// A first line of several words of which none is a number: "timestamp,filename".
bool is_heading(std::span<const std::string_view> words);

// "1.5", "-inf", "nan"; nothing if the word is anything else.
std::optional<double> to_number(std::string_view word);

// Throws Error with file and line if a word is no number.
std::vector<double> to_numbers(std::span<const std::string_view> words, const std::filesystem::path& path, std::size_t line);

// A path of a list that was made on Windows.
std::string with_slashes(std::string_view path);

// All numbers of a file, brackets around them or not. Throws Error if something in it is no number.
std::vector<double> read_numbers(const std::filesystem::path& path);
// The same for the text of that file.
std::vector<double> numbers_in(std::string_view text, const std::filesystem::path& path);

// 16 numbers row by row, or 12 (the last row is then 0 0 0 1); nothing for any other count.
std::optional<Eigen::Matrix4d> to_matrix(std::span<const double> numbers);

// fx, fy, cx, cy from these four numbers or from a 3x3, 3x4 or 4x4 matrix, row by row or column by column (the zeros tell);
// the size stays 0. Throws Error, beginning with `source`, if they are not usable.
Camera to_camera(std::span<const double> numbers, const std::string& source);
Camera read_camera_matrix(const std::filesystem::path& path);

// Files of one kind by their number, in numeric order: number -> path relative to the recording.
using NumberedFiles = std::map<std::int64_t, std::string>;

// Names made of exactly prefix, digits and one of the suffixes, in any case: "frame-" 000012 ".color.png". Empty if the folder is
// absent.
NumberedFiles numbered_files(const std::filesystem::path& root, const std::string& folder, std::string_view prefix,
                             std::span<const std::string_view> suffixes);

}  // namespace panoptic
