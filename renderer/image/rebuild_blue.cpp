// Finds the channels that hold x and y, and computes z.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/rebuild_blue.h"

#include <half.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

namespace kindling::image_detail {

namespace {

template <typename T>
double fraction_of(T value) {
  const auto number = static_cast<double>(value);
  return std::is_integral_v<T> ? number / static_cast<double>(std::numeric_limits<T>::max()) : number;
}

template <typename T>
T stored(double fraction) {
  if constexpr (std::is_integral_v<T>)
    return static_cast<T>(std::lround(fraction * static_cast<double>(std::numeric_limits<T>::max())));
  else
    return static_cast<T>(static_cast<float>(fraction));
}

template <typename T>
T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

// Returns the channel that holds y, if x and y are all that the image holds.
template <typename T>
std::optional<size_t> channel_of_y(const Image& image, bool constant_blue) {
  if (image.channels == 2) return 1;
  if (image.channels < 3) return std::nullopt;
  if (constant_blue) return 1;
  const auto channels = static_cast<size_t>(image.channels);
  const T alpha = channels == 4 && !image.pixels.empty() ? load<T>(image.pixels.data() + 3 * sizeof(T)) : T{};
  bool no_blue = true, gray = true, constant_alpha = true;
  for (size_t at = 0; at < image.pixels.size() && (no_blue || gray); at += channels * sizeof(T)) {
    const std::byte* pixel = image.pixels.data() + at;
    const T red = load<T>(pixel), green = load<T>(pixel + sizeof(T)), blue = load<T>(pixel + 2 * sizeof(T));
    no_blue = no_blue && blue == T{};
    gray = gray && red == green && green == blue;
    constant_alpha = constant_alpha && (channels < 4 || load<T>(pixel + 3 * sizeof(T)) == alpha);
  }
  if (no_blue) return 1;
  if (gray && !constant_alpha) return 3;
  return std::nullopt;
}

template <typename T>
void rebuild(Image& image, bool constant_blue) {
  const std::optional<size_t> y_channel = channel_of_y<T>(image, constant_blue);
  if (!y_channel) return;
  const size_t from_bytes = static_cast<size_t>(image.channels) * sizeof(T);
  Image rgb{image.width, image.height, 3, image.type, {}};
  rgb.pixels.resize(rgb.byte_count());
  std::byte* to = rgb.pixels.data();
  for (size_t at = 0; at < image.pixels.size(); at += from_bytes, to += 3 * sizeof(T)) {
    const T red = load<T>(image.pixels.data() + at), green = load<T>(image.pixels.data() + at + *y_channel * sizeof(T));
    const double x = 2.0 * fraction_of(red) - 1.0, y = 2.0 * fraction_of(green) - 1.0;
    const double square = 1.0 - x * x - y * y;
    const T direction[3] = {red, green, stored<T>(0.5 + 0.5 * (square > 0.0 ? std::sqrt(square) : 0.0))};
    std::memcpy(to, direction, sizeof direction);
  }
  image = std::move(rgb);
}

} // namespace

void rebuild_blue(Image& image, bool constant_blue) {
  switch (image.type) {
  case PixelType::u8: return rebuild<uint8_t>(image, constant_blue);
  case PixelType::u16: return rebuild<uint16_t>(image, constant_blue);
  case PixelType::f16: return rebuild<Imath::half>(image, constant_blue);
  case PixelType::f32: return rebuild<float>(image, constant_blue);
  }
}

} // namespace kindling::image_detail
