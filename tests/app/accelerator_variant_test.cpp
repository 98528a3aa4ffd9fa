// Names of accelerators with their settings, and limits on instruction sets.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/options/accelerator_variant.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

using namespace kindling::app;

TEST(AcceleratorVariant, ParsesNames) {
  const auto variants =
      parse_accelerator_variants("kdtree,embree:best,embree:fast:non-robust,embree:robust,brute-force,kdtree:portable");
  ASSERT_TRUE(variants.ok()) << variants.error().message;
  std::vector<std::string> names;
  for (const AcceleratorVariant& variant : variants.value()) names.push_back(variant.name());
  EXPECT_EQ(names, (std::vector<std::string>{"kdtree", "embree:best", "embree:fast:non-robust", "embree", "brute-force",
                                             "kdtree:portable"}));
  EXPECT_EQ(variants.value()[2].quality, accel::Quality::fast);
  EXPECT_FALSE(variants.value()[2].robust);
  EXPECT_TRUE(variants.value()[1].robust);
}

TEST(AcceleratorVariant, RefusesWrongNames) {
  const auto expect_refused = [](const char* text, const std::string& words) {
    const auto variants = parse_accelerator_variants(text);
    ASSERT_FALSE(variants.ok()) << text;
    EXPECT_EQ(variants.error().kind, ErrorKind::usage);
    EXPECT_NE(variants.error().message.find(words), std::string::npos) << variants.error().message;
  };
  expect_refused("", "");
  expect_refused("bvh", "unknown accelerator 'bvh'; use kdtree, embree or brute-force");
  expect_refused("embree:finest", "unknown setting 'finest' of embree; use fast, balanced or best");
  expect_refused("embree:", "unknown setting '' of embree");
  expect_refused("kdtree:non-robust", "kdtree is always robust");
  expect_refused("embree:portable", "embree has no kernels for portable that this processor runs; use sse2");
  expect_refused("kdtree:sse2", "kdtree has no kernels for sse2 that this processor runs; use portable");
  expect_refused("brute-force:avx2", "brute-force has no instruction sets to choose from");
  expect_refused("brute-force:best", "brute-force has no qualities");
  expect_refused("embree,kdtree,embree:balanced", "embree is given twice");
}

TEST(AcceleratorVariant, InstructionSetCanBeLimited) {
  using accel::SimdTarget;
  std::vector<AcceleratorVariant> variants =
      parse_accelerator_variants("kdtree,embree,brute-force,kdtree:portable,embree:sse2").value();
  limit_instruction_set(variants, SimdTarget::sse42);
  const bool has_sse42 = accel::embree_simd_targets().back() >= SimdTarget::sse42;
  EXPECT_EQ(variants[0].simd, SimdTarget::portable);
  EXPECT_EQ(variants[1].simd, has_sse42 ? SimdTarget::sse42 : SimdTarget::sse2);
  EXPECT_EQ(variants[2].simd, std::nullopt);
  EXPECT_EQ(variants[3].simd, SimdTarget::portable);
  EXPECT_EQ(variants[4].simd, SimdTarget::sse2); // its own
  EXPECT_EQ(parse_instruction_set("sse2").value(), SimdTarget::sse2);
  EXPECT_EQ(parse_instruction_set("portable").error().kind, ErrorKind::usage);
  EXPECT_NE(parse_instruction_set("neon").error().message.find("'neon' is not an instruction set"), std::string::npos);
}

} // namespace
} // namespace kindling::test
