// Compares images to the bit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace kindling::test {

inline bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

// All that the films' AOVs and mattes have: `part` shows the pixels of its crop as `whole` does,
// whose crop is the whole image or contains that.
inline void expect_same_bits(const Film& part, const Film& whole, const std::string& what) {
  const PixelRect &crop = part.crop(), &all = whole.crop();
  for (const AovInfo& info : kAovs) {
    const auto channels = static_cast<size_t>(info.channels), row = static_cast<size_t>(crop.width()) * channels;
    const std::vector<float> found = part.resolve(info.aov), expected = whole.resolve(info.aov);
    for (int y = crop.min.y; y < crop.max.y; ++y) {
      const size_t from = static_cast<size_t>(y - all.min.y) * static_cast<size_t>(all.width()) +
                          static_cast<size_t>(crop.min.x - all.min.x);
      ASSERT_EQ(std::memcmp(&found[static_cast<size_t>(y - crop.min.y) * row], &expected[from * channels],
                            row * sizeof(float)),
                0)
          << info.name << " differs in row " << y << " with " << what;
    }
  }
  ASSERT_EQ(part.light_groups(), whole.light_groups());
  const auto row = static_cast<size_t>(crop.width()) * 3;
  for (size_t g = 0; g < whole.light_groups().size(); ++g) {
    const std::vector<float> found = part.resolve_light_group(g), expected = whole.resolve_light_group(g);
    for (int y = crop.min.y; y < crop.max.y; ++y) {
      const size_t from = static_cast<size_t>(y - all.min.y) * static_cast<size_t>(all.width()) +
                          static_cast<size_t>(crop.min.x - all.min.x);
      ASSERT_EQ(
          std::memcmp(&found[static_cast<size_t>(y - crop.min.y) * row], &expected[from * 3], row * sizeof(float)), 0)
          << whole.light_groups()[g] << " differs in row " << y << " with " << what;
    }
  }
  if (part.mattes().empty()) return;
  std::vector<MatteTerm> found, expected;
  for (int y = crop.min.y; y < crop.max.y; ++y)
    for (int x = crop.min.x; x < crop.max.x; ++x) {
      part.mattes().list(static_cast<size_t>((y - crop.min.y) * crop.width() + x - crop.min.x), found);
      whole.mattes().list(static_cast<size_t>((y - all.min.y) * all.width() + x - all.min.x), expected);
      ASSERT_EQ(found.size(), expected.size()) << "mattes at " << x << ", " << y << " with " << what;
      for (size_t i = 0; i < found.size(); ++i)
        ASSERT_TRUE(found[i].ids == expected[i].ids && found[i].weight == expected[i].weight)
            << "mattes at " << x << ", " << y << " with " << what;
    }
}

} // namespace kindling::test
