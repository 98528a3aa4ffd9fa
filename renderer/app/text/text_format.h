// Numbers and tables as people read them. Pure functions.
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
// "0.042 ms", "35.1 ms", then as format_seconds() does: what may take microseconds.
[[nodiscard]] std::string format_short_time(double seconds);
// "812 B", "1.5 KiB", "512 MiB", "3.25 GiB".
[[nodiscard]] std::string format_bytes(uint64_t bytes);
// "812", "12.3 k", "4.57 M", "1.20 G": three digits, SI prefixes.
[[nodiscard]] std::string format_count(double count);
// 16 hexadecimal digits.
[[nodiscard]] std::string format_hash(uint64_t hash);

// One word of a POSIX shell: quoted only where it must be.
[[nodiscard]] std::string shell_quote(std::string_view word);

// One value of a line of comma-separated ones (RFC 4180): quoted if a comma, a quote or a line break is in it.
[[nodiscard]] std::string csv_field(std::string_view text);

// A table with a line of headings; columns are as wide as their widest cell, numbers (by `right`) to the right.
class TextTable {
 public:
  struct Column {
    std::string heading;
    bool right = false;
    bool whole = false; // its cells are not cut
  };
  explicit TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {}
  // One cell per column; cells are made printable and cut at kMaxCell where their column does not say otherwise.
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
