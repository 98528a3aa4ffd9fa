// Guides must not depend on the number of threads that learn them, because they determine images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/learn_guide.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cstring>

namespace kindling::test {

inline void expect_same_patches(const BrightPatches& one, const BrightPatches& other) {
  const std::span<const BrightPatch> a = one.patches(), b = other.patches();
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size_bytes()), 0);
}

// Learns with one thread and several times with four, expects the same bits, and returns the guide.
inline LearnedGuide learn_on_any_threads(std::span<const GuideRecord> records) {
  LearnedGuide alone;
  tbb::task_arena(1).execute([&] { alone = learn_guide(records, {}); });
  for (int i = 0; i < 3; ++i) {
    LearnedGuide together;
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
    tbb::task_arena(4).execute([&] { together = learn_guide(records, {}); });
    EXPECT_EQ(together.second_moment, alone.second_moment);
    EXPECT_EQ(together.second_moment_of_openings, alone.second_moment_of_openings);
    expect_same_patches(together.guide.patches, alone.guide.patches);
    expect_same_patches(together.patches_of_openings, alone.patches_of_openings);
  }
  return alone;
}

} // namespace kindling::test
