// Splits text; numbers do not depend on the locale.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/polygons/text_scanner.h"

#include <algorithm>
#include <charconv>

namespace kindling::polygons {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

template <typename Number>
std::optional<Number> convert(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  Number number{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (end != word.data() + word.size() || word.empty()) return std::nullopt;
  if (error == std::errc::invalid_argument) return std::nullopt;
  return number; // out of range: the largest, or 0
}

} // namespace

bool TextScanner::next_line() {
  if (rest_.empty()) return false;
  const size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
  line_ = rest_.substr(0, end);
  rest_.remove_prefix(end);
  if (rest_.starts_with("\r\n"))
    rest_.remove_prefix(2);
  else if (!rest_.empty())
    rest_.remove_prefix(1);
  ++number_;
  return true;
}

std::string_view TextScanner::word() {
  const auto begin = std::find_if_not(line_.begin(), line_.end(), is_blank);
  const auto end = std::find_if(begin, line_.end(), is_blank);
  const std::string_view word(begin, end);
  line_.remove_prefix(static_cast<size_t>(end - line_.begin()));
  return word;
}

std::string_view TextScanner::word_of_any_line() {
  for (;;) {
    if (const std::string_view found = word(); !found.empty()) return found;
    if (!next_line()) return {};
  }
}

std::optional<double> to_number(std::string_view word) { return convert<double>(word); }
std::optional<int64_t> to_integer(std::string_view word) { return convert<int64_t>(word); }

} // namespace kindling::polygons
