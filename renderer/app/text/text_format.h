// Formats numbers, durations, names and tables for people. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/text.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// "0.012 s", "4.56 s", "12.3 s", then "1:23" and "1:02:03".
[[nodiscard]] std::string format_seconds(double seconds);
// "0.042 ms", "35.1 ms", then as format_seconds(), for times that may be microseconds.
[[nodiscard]] std::string format_short_time(double seconds);
// "812 B", "1.5 KiB", "512 MiB", "3.25 GiB".
[[nodiscard]] std::string format_bytes(uint64_t bytes);
// "812", "12.3 k", "4.57 M", "1.20 G": three digits, SI prefixes.
[[nodiscard]] std::string format_count(double count);
// "5m", "90s": a value of parse_duration(), for defaults in help texts.
[[nodiscard]] std::string format_duration(double seconds);
// 16 hexadecimal digits.
[[nodiscard]] std::string format_hash(uint64_t hash);

// Returns one word of a POSIX shell, quoted only if necessary.
[[nodiscard]] std::string shell_quote(std::string_view word);

// Returns one field of comma-separated values (RFC 4180), quoted if it holds a comma, a quote or a
// line break.
[[nodiscard]] std::string csv_field(std::string_view text);

// A table with a line of headings. Columns are as wide as their widest cell; those with `right` are
// aligned to the right.
class TextTable {
 public:
  struct Column {
    std::string heading;
    bool right = false;
    bool whole = false; // cells are not truncated
  };
  explicit TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {}
  // Adds a row of one cell per column. Cells are made printable, and truncated at kMaxCell unless
  // the column is whole.
  void add(std::vector<std::string> cells);
  [[nodiscard]] bool empty() const { return rows_.empty(); }
  // Each line begins with two spaces and ends with '\n'.
  [[nodiscard]] std::string str() const;

  static constexpr size_t kMaxCell = 60;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

} // namespace kindling::app
