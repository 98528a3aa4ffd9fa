// Tests that the reader of any layout, which GPUs use, has the values of the readers of each.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/any_texel_reader.h"

#include "renderer/base/simd_types.h"
#include "renderer/texture/layouts.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdint>
#include <random>

namespace kindling::texture_detail {
namespace {

using Texel = std::array<std::byte, 16>;

// Random bits without infinities and NaN of halves and floats: exponents are below the largest.
Texel random_texel(std::mt19937& random) {
  Texel texel;
  for (std::byte& byte : texel) byte = static_cast<std::byte>(random() & 0xbfU);
  return texel;
}

template <typename Reader>
void expect_same(const Reader& expected, const AnyTexelReader& found, const Texel& texel) {
  EXPECT_EQ(found.bytes(), expected.bytes());
  EXPECT_EQ(found.scale(), expected.scale());
  EXPECT_EQ(found.channel_count(), expected.channel_count());
  EXPECT_EQ(found.has_alpha(), expected.has_alpha());
  for (int channel = 0; channel < expected.channel_count(); ++channel)
    EXPECT_EQ(std::bit_cast<uint32_t>(found.channel(texel.data(), channel)),
              std::bit_cast<uint32_t>(expected.channel(texel.data(), channel)));
  const Float4 all = found.all(texel.data()), expected_all = expected.all(texel.data());
  for (int channel = 0; channel < (expected.has_alpha() ? 4 : 3); ++channel)
    EXPECT_EQ(std::bit_cast<uint32_t>(all[channel]), std::bit_cast<uint32_t>(expected_all[channel]));
}

TEST(AnyTexelReader, HasTheValuesOfTheReaderOfEachLayout) {
  std::mt19937 random(7);
  for (uint8_t layout = 0; layout < kLayoutCount; ++layout) {
    SCOPED_TRACE(static_cast<int>(layout));
    for (int i = 0; i < 1000 && !::testing::Test::HasFailure(); ++i) {
      const Texel texel = random_texel(random);
      with_layout(layout, [&]<typename Reader>() { expect_same(Reader(), AnyTexelReader(layout), texel); });
    }
  }
}

} // namespace
} // namespace kindling::texture_detail
