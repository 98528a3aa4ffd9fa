// Parsers of flag values and their error messages.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <optional>

namespace kindling::app {

namespace {

Error wrong(std::string_view text, std::string_view what, std::string_view accepted) {
  return {ErrorKind::usage, fmt::format("'{}' {}; use {}", text, what, accepted)};
}

// Parses all of `text` as a finite number. A leading '+' is allowed, spaces are not.
std::optional<double> to_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<int64_t> to_integer(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const size_t at = text.find(separator);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
}

// Parses N integers separated by commas.
template <size_t N>
std::optional<std::array<int64_t, N>> to_integers(std::string_view text) {
  const std::vector<std::string_view> parts = split(text, ',');
  if (parts.size() != N) return std::nullopt;
  std::array<int64_t, N> values{};
  for (size_t i = 0; i < N; ++i) {
    const std::optional<int64_t> value = to_integer(parts[i]);
    if (!value) return std::nullopt;
    values[i] = *value;
  }
  return values;
}

// Parses three numbers separated by commas, within the range of single precision.
std::optional<V3f> to_vector(std::string_view text) {
  const std::vector<std::string_view> parts = split(text, ',');
  if (parts.size() != 3) return std::nullopt;
  V3f value;
  for (int i = 0; i < 3; ++i) {
    const std::optional<double> number = to_number(parts[static_cast<size_t>(i)]);
    if (!number || std::abs(*number) > static_cast<double>(std::numeric_limits<float>::max())) return std::nullopt;
    value[i] = static_cast<float>(*number);
  }
  return value;
}

} // namespace

Result<int64_t> parse_integer(std::string_view text, int64_t min, int64_t max) {
  const std::optional<int64_t> value = to_integer(text);
  const std::string accepted = fmt::format("{} to {}", min, max);
  if (!value) return wrong(text, "is not a whole number", accepted);
  if (*value < min || *value > max) return wrong(text, "is out of range", accepted);
  return *value;
}

Result<double> parse_number(std::string_view text, double min, double max) {
  constexpr double kUnlimited = std::numeric_limits<double>::max();
  const std::string accepted = min == -kUnlimited  ? std::string("a decimal number")
                               : max == kUnlimited ? fmt::format("a number of {:g} or more", min)
                                                   : fmt::format("{:g} to {:g}", min, max);
  const std::optional<double> value = to_number(text);
  if (!value) return wrong(text, "is not a number", accepted);
  if (*value < min || *value > max) return wrong(text, "is out of range", accepted);
  // It would become 0 in the renderer's single precision.
  if (*value != 0.0 && std::abs(*value) < static_cast<double>(std::numeric_limits<float>::min()))
    return wrong(text, "is closer to 0 than single precision allows", accepted);
  return *value;
}

Result<V2i> parse_size(std::string_view text) {
  const std::string accepted = fmt::format("WIDTHxHEIGHT in pixels, each 1 to {}, as in 1280x720", kMaxImageSide);
  const std::vector<std::string_view> parts = split(text, 'x');
  if (parts.size() != 2) return wrong(text, "is not a size", accepted);
  const std::optional<int64_t> width = to_integer(parts[0]);
  const std::optional<int64_t> height = to_integer(parts[1]);
  if (!width || !height) return wrong(text, "is not a size", accepted);
  if (*width < 1 || *height < 1 || *width > kMaxImageSide || *height > kMaxImageSide)
    return wrong(text, "is out of range", accepted);
  return V2i(static_cast<int>(*width), static_cast<int>(*height));
}

Result<double> parse_scale(std::string_view text) {
  constexpr std::string_view kAccepted = "a factor above 0 and at most 64, as in 0.5 or 50%";
  std::string_view digits = text;
  double unit = 1.0;
  if (digits.ends_with('%')) {
    digits.remove_suffix(1);
    unit = 0.01;
  }
  const std::optional<double> value = to_number(digits);
  if (!value) return wrong(text, "is not a scale", kAccepted);
  const double scale = *value * unit;
  if (!(scale > 0.0) || scale > 64.0) return wrong(text, "is out of range", kAccepted);
  return scale;
}

Result<double> parse_duration(std::string_view text) {
  constexpr std::string_view kAccepted = "seconds, or with units as in 90s, 5m, 1.5h or 1h30m";
  double seconds = 0.0;
  double largest_unit = std::numeric_limits<double>::max();
  std::string_view rest = text;
  while (!rest.empty()) {
    const size_t digits = std::min(rest.find_first_not_of("0123456789."), rest.size());
    const std::optional<double> value = to_number(rest.substr(0, digits));
    if (!value) return wrong(text, "is not a duration", kAccepted);
    rest.remove_prefix(digits);
    double unit = 1.0;
    if (rest.empty()) {
      if (digits != text.size()) return wrong(text, "is not a duration", kAccepted);
    } else {
      unit = rest[0] == 's' ? 1.0 : rest[0] == 'm' ? 60.0 : rest[0] == 'h' ? 3600.0 : 0.0;
      rest.remove_prefix(1);
      if (unit == 0.0 || unit >= largest_unit) return wrong(text, "is not a duration", kAccepted);
      largest_unit = unit;
    }
    seconds += *value * unit;
  }
  if (!(seconds > 0.0)) return wrong(text, "is not a duration above 0", kAccepted);
  return seconds;
}

Result<uint64_t> parse_bytes(std::string_view text) {
  constexpr std::string_view kUnits = "KMGT";
  constexpr double kMax = 0x1p60;
  std::string_view number = text;
  double unit = 1.0;
  if (!text.empty()) {
    const size_t found = kUnits.find(text.back() >= 'a' ? static_cast<char>(text.back() - 'a' + 'A') : text.back());
    if (found != std::string_view::npos) {
      unit = std::exp2(10.0 * (static_cast<double>(found) + 1.0));
      number.remove_suffix(1);
    }
  }
  const std::optional<double> value = to_number(number);
  if (!value) return wrong(text, "is not a size", "bytes, or a number with K, M, G or T as in 512M or 1.5G");
  const double bytes = *value * unit;
  if (!(bytes >= 1.0 && bytes <= kMax)) return wrong(text, "is out of range", "at least one byte, as in 512M or 2G");
  return static_cast<uint64_t>(bytes);
}

Result<PixelRect> parse_crop(std::string_view text) {
  constexpr std::string_view kAccepted =
      "X0,Y0,X1,Y1 in pixels from the top left, X1 and Y1 not included, as in 0,0,640,360";
  const auto values = to_integers<4>(text);
  if (!values) return wrong(text, "is not a rectangle", kAccepted);
  for (const int64_t value : *values)
    if (value < 0 || value > kMaxImageSide) return wrong(text, "is out of range", kAccepted);
  const auto at = [&](size_t i) { return static_cast<int>((*values)[i]); };
  const PixelRect rect{{at(0), at(1)}, {at(2), at(3)}};
  if (rect.empty()) return wrong(text, "is an empty rectangle", kAccepted);
  return rect;
}

Result<V2i> parse_pixel(std::string_view text) {
  constexpr std::string_view kAccepted = "X,Y in pixels from the top left, as in 412,90";
  const auto values = to_integers<2>(text);
  if (!values) return wrong(text, "is not a pixel", kAccepted);
  for (const int64_t value : *values)
    if (value < 0 || value > kMaxImageSide) return wrong(text, "is out of range", kAccepted);
  return V2i(static_cast<int>((*values)[0]), static_cast<int>((*values)[1]));
}

Result<V3f> parse_vector(std::string_view text) {
  const std::optional<V3f> value = to_vector(text);
  if (!value) return wrong(text, "is not three numbers", "X,Y,Z as in 0,1.5,-2");
  return *value;
}

Result<Rgb> parse_color(std::string_view text) {
  constexpr std::string_view kAccepted = "R,G,B in linear light, none negative, as in 0.5,0.5,0.5";
  std::optional<Rgb> value = to_vector(text);
  if (!value)
    if (const std::optional<double> gray = to_number(text);
        gray && *gray <= static_cast<double>(std::numeric_limits<float>::max()))
      value = Rgb(static_cast<float>(*gray));
  if (!value) return wrong(text, "is not a color", kAccepted);
  if (min_component(*value) < 0.0f) return wrong(text, "is out of range", kAccepted);
  return *value;
}

Result<std::vector<std::string>> parse_list(std::string_view text) {
  std::vector<std::string> names;
  for (const std::string_view part : split(text, ',')) {
    if (part.empty()) return wrong(text, "has an empty name", "names separated by commas, without spaces");
    names.emplace_back(part);
  }
  return names;
}

} // namespace kindling::app
