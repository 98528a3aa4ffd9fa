// Reads LM-63: a line with the version, keywords, TILT, then numbers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/lights/parse_ies.h"

#include "renderer/import/files/failure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cfloat>
#include <charconv>
#include <cmath>

namespace kindling::gltf {
namespace {

// Tokenizer: lines first, then numbers.
class IesReader {
 public:
  explicit IesReader(std::string_view text) : rest_(text) {}

  [[noreturn]] void refuse(std::string_view message) const {
    kindling::gltf::fail({}, fmt::format("line {}: {}", line_, message));
  }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  [[nodiscard]] size_t left() const { return rest_.size(); }

  std::string_view line() {
    ++line_;
    const size_t end = rest_.find_first_of("\r\n");
    std::string_view result = rest_.substr(0, end);
    rest_.remove_prefix(std::min(rest_.size(), result.size()));
    if (rest_.size() > 1 && rest_[0] == '\r' && rest_[1] == '\n') rest_.remove_prefix(1);
    if (!rest_.empty()) rest_.remove_prefix(1);
    while (!result.empty() && std::isspace(static_cast<unsigned char>(result.back()))) result.remove_suffix(1);
    while (!result.empty() && std::isspace(static_cast<unsigned char>(result.front()))) result.remove_prefix(1);
    return result;
  }

  // Numbers are separated by spaces, line ends and commas; line ends have no meaning.
  float number(std::string_view what) {
    while (!rest_.empty() && (std::isspace(static_cast<unsigned char>(rest_.front())) || rest_.front() == ',')) {
      if (rest_.front() == '\n') ++line_;
      rest_.remove_prefix(1);
    }
    size_t length = 0;
    while (length < rest_.size() && !std::isspace(static_cast<unsigned char>(rest_[length])) && rest_[length] != ',')
      ++length;
    std::string_view word = rest_.substr(0, length);
    if (word.empty()) refuse(fmt::format("the file ends before {}", what));
    rest_.remove_prefix(length);
    std::string_view digits = word;
    if (digits.front() == '+') digits.remove_prefix(1);
    double value = 0.0; // a double, because files have numbers too small for a float
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size() ||
        !(std::fabs(value) <= static_cast<double>(FLT_MAX)))
      refuse(fmt::format("{} for {}, expected a number", in_quotes(word), what));
    return static_cast<float>(value);
  }

  int integer(std::string_view what, int min, int max) {
    const float value = number(what);
    if (value != std::floor(value) || value < static_cast<float>(min) || value > static_cast<float>(max))
      refuse(fmt::format("{} for {}, expected a whole number from {} to {}", value, what, min, max));
    return static_cast<int>(value);
  }

  std::vector<float> angles(int count, std::string_view what) {
    std::vector<float> values;
    for (int i = 0; i < count; ++i) {
      values.push_back(number(what));
      if (i > 0 && !(values[static_cast<size_t>(i)] > values[static_cast<size_t>(i) - 1]))
        refuse(fmt::format("{} after {} for {}, expected increasing angles", values.back(),
                           values[static_cast<size_t>(i) - 1], what));
    }
    return values;
  }

 private:
  std::string_view rest_;
  int line_ = 0;
};

constexpr int kMaxAngles = 4096;

// True if the third factor is the ballast-lamp factor: 2002 reserves it, 2019 stores the file's
// origin there.
bool has_lamp_factor(std::string_view version) {
  return version.find("2002") == std::string_view::npos && version.find("2019") == std::string_view::npos;
}

bool one_of(float value, std::initializer_list<float> accepted) {
  return std::any_of(accepted.begin(), accepted.end(), [&](float a) { return std::fabs(value - a) < 0.01f; });
}

void check_range(const IesReader& reader, const Photometry& web) {
  const float v0 = web.vertical_deg.front();
  const float v1 = web.vertical_deg.back();
  const float h0 = web.horizontal_deg.front();
  const float h1 = web.horizontal_deg.back();
  if (web.kind != Photometry::Kind::c) {
    if (v0 < -90.01f || v1 > 90.01f)
      reader.refuse(fmt::format("vertical angles from {} to {}, expected -90 to 90 for types A and B", v0, v1));
    if (h0 < -90.01f || h1 > 90.01f)
      reader.refuse(fmt::format("horizontal angles from {} to {}, expected -90 to 90 for types A and B", h0, h1));
    return;
  }
  if (v0 < -0.01f || v1 > 180.01f)
    reader.refuse(fmt::format("vertical angles from {} to {}, expected 0 to 180 for type C", v0, v1));
  const bool around = one_of(h0, {0.0f}) && (web.horizontal_deg.size() == 1 || one_of(h1, {90.0f, 180.0f, 360.0f}));
  if (!around && !(one_of(h0, {90.0f}) && one_of(h1, {270.0f}))) {
    // Some files omit 360 degrees, which equals 0.
    if (!(one_of(h0, {0.0f}) && h1 > 180.0f && h1 < 360.0f))
      reader.refuse(
          fmt::format("horizontal angles from {} to {}, expected for type C: 0 alone, 0 to 90, 180 or 360, or "
                      "90 to 270",
                      h0, h1));
  }
}

// Repeats the first horizontal angle at 360 degrees where the file omits it.
void close_circle(Photometry& web) {
  if (web.kind != Photometry::Kind::c || web.horizontal_deg.size() < 2) return;
  const float last = web.horizontal_deg.back();
  if (web.horizontal_deg.front() > 0.01f || last < 180.01f || last > 359.99f) return;
  web.horizontal_deg.push_back(360.0f);
  const std::vector<float> first(web.candela.begin(),
                                 web.candela.begin() + static_cast<std::ptrdiff_t>(web.vertical_deg.size()));
  web.candela.insert(web.candela.end(), first.begin(), first.end());
}

void skip_tilt(IesReader& reader) {
  static_cast<void>(reader.number("the lamp's geometry to the luminaire"));
  const int pairs = reader.integer("the number of tilt angles", 0, kMaxAngles);
  for (int i = 0; i < 2 * pairs; ++i) static_cast<void>(reader.number("a tilt angle or factor"));
}

Photometry parse(std::string_view text) {
  IesReader reader(text);
  std::string_view version;
  std::string_view tilt;
  for (bool first = true; tilt.empty(); first = false) {
    if (reader.at_end()) reader.refuse("no line 'TILT=' before the end, expected a file of IES LM-63");
    const std::string_view line = reader.line();
    if (first && line.substr(0, 3) == "IES") version = line;
    if (line.substr(0, 5) == "TILT=") tilt = line.substr(5);
  }
  if (tilt == "INCLUDE") skip_tilt(reader);

  static_cast<void>(reader.number("the number of lamps"));
  static_cast<void>(reader.number("the lumens per lamp"));
  float factor = reader.number("the candela multiplier");
  const int vertical = reader.integer("the number of vertical angles", 1, kMaxAngles);
  const int horizontal = reader.integer("the number of horizontal angles", 1, kMaxAngles);
  const int type = reader.integer("the photometric type", 1, 3);
  for (const char* what : {"the units", "the width", "the length", "the height"})
    static_cast<void>(reader.number(what));
  factor *= reader.number("the ballast factor");
  const float lamp_factor = reader.number("the ballast-lamp photometric factor");
  if (has_lamp_factor(version)) factor *= lamp_factor;
  static_cast<void>(reader.number("the watts"));
  if (!(factor >= 0.0f && factor < 1e30f))
    reader.refuse(fmt::format("factors that multiply to {}, expected a number from 0", factor));

  Photometry web;
  web.kind = type == 1 ? Photometry::Kind::c : type == 2 ? Photometry::Kind::b : Photometry::Kind::a;
  web.vertical_deg = reader.angles(vertical, "a vertical angle");
  web.horizontal_deg = reader.angles(horizontal, "a horizontal angle");
  check_range(reader, web);
  const size_t count = static_cast<size_t>(vertical) * static_cast<size_t>(horizontal);
  if (count > reader.left()) reader.refuse(fmt::format("the file ends before its {} candela values", count));
  for (size_t i = 0; i < count; ++i) {
    const float value = reader.number("a candela value") * factor;
    if (!(value >= -1e-3f && value < 1e30f)) reader.refuse(fmt::format("{} candela, expected a number from 0", value));
    web.candela.push_back(std::max(value, 0.0f));
  }
  close_circle(web);
  return web;
}

} // namespace

Result<Photometry> parse_ies(std::string_view text) {
  try {
    return parse(text);
  } catch (const ImportFailure& failure) {
    return failure.error;
  }
}

} // namespace kindling::gltf
