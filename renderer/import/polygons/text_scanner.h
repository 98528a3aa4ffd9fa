// Words and numbers of text files, line by line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace kindling::polygons {

class TextScanner {
 public:
  explicit TextScanner(std::string_view text) : rest_(text) {}

  // Goes to the next line; false at the end. Lines end with LF, CR LF or CR.
  bool next_line();
  // The next word of the line, between blanks; empty at its end.
  std::string_view word();
  // The next word of this line or a later one; empty at the end of the text.
  std::string_view word_of_any_line();

  [[nodiscard]] std::string_view line() const { return line_; } // without what was read of it
  [[nodiscard]] size_t line_number() const { return number_; }  // from 1
  [[nodiscard]] std::string place() const { return "line " + std::to_string(number_); }
  [[nodiscard]] std::string_view rest() const { return rest_; } // the lines after this one

 private:
  std::string_view rest_;
  std::string_view line_;
  size_t number_ = 0;
};

// The whole word as a number; nullopt if it is none. A leading + is accepted, nan and inf are read.
[[nodiscard]] std::optional<double> to_number(std::string_view word);
[[nodiscard]] std::optional<int64_t> to_integer(std::string_view word);

} // namespace kindling::polygons
