// Compares the stored sums of films with light groups and passes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"

#include <gtest/gtest.h>

#include <cstring>
#include <span>
#include <string_view>
#include <vector>

namespace kindling::test {

inline std::span<const std::byte> plane_bytes_of(const Film& film, std::string_view name) {
  for (const Film::ConstPlane& plane : film.planes())
    if (plane.name == name) return plane.bytes;
  return {};
}

inline void expect_same_plane(const Film& a, const Film& b, std::string_view name) {
  const auto x = plane_bytes_of(a, name), y = plane_bytes_of(b, name);
  ASSERT_FALSE(x.empty()) << name;
  ASSERT_EQ(x.size(), y.size());
  EXPECT_EQ(std::memcmp(x.data(), y.data(), x.size()), 0) << name;
}

// The parts in a plane sum to another one of records of type Whole, to the bit.
template <typename Whole>
inline void expect_sums_to(const Film& film, std::string_view whole, std::string_view plane) {
  const auto beauty_bytes = plane_bytes_of(film, whole), part_bytes = plane_bytes_of(film, plane);
  const size_t pixels = beauty_bytes.size() / sizeof(Whole);
  ASSERT_FALSE(part_bytes.empty()) << plane;
  const size_t parts = part_bytes.size() / sizeof(RadianceSum) / pixels;
  const auto* const beauty = reinterpret_cast<const Whole*>(beauty_bytes.data());
  const auto* const sums = reinterpret_cast<const RadianceSum*>(part_bytes.data());
  size_t different = 0;
  for (size_t i = 0; i < pixels; ++i) {
    RadianceSum total{};
    for (size_t p = 0; p < parts; ++p) total.add(sums[i * parts + p]);
    for (int c = 0; c < 3; ++c) different += total.rgb[c] == beauty[i].rgb[c] ? 0 : 1;
  }
  EXPECT_EQ(different, 0U) << plane;
}
inline void expect_sums_to_beauty(const Film& film, std::string_view plane) {
  expect_sums_to<PixelSum>(film, "beauty", plane);
}
inline void expect_sums_to_splats(const Film& film, std::string_view plane) {
  expect_sums_to<SplatSum>(film, "splats", plane);
}

// Returns the mean luminance of interleaved RGB values.
inline double mean_luminance(const std::vector<float>& rgb) {
  double sum = 0.0;
  for (size_t i = 0; i + 2 < rgb.size(); i += 3)
    sum += 0.2126 * static_cast<double>(rgb[i]) + 0.7152 * static_cast<double>(rgb[i + 1]) +
           0.0722 * static_cast<double>(rgb[i + 2]);
  return sum / (static_cast<double>(rgb.size()) / 3.0);
}

} // namespace kindling::test
