// Reciprocity of layered materials.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/bsdf/layered_materials.h"

#include <gtest/gtest.h>

namespace kindling::test {

inline void expect_reciprocal(const LayeredMaterial& m, Random& random, const char* what) {
  for (int i = 0; i < 200; ++i) {
    const V3f a = random_direction(random);
    V3f b = random_direction(random);
    const bool through = random.next_1d() < 0.3f;
    // Below the surface the roles swap: wi becomes the view, in a frame that is flipped about x.
    const auto turned = [](const V3f& w) { return V3f(w.x, -w.y, -w.z); };
    if (through) b = -b;
    const Rgb forward = LayeredBsdf(m.base, m.layers, a).eval(b).value / std::abs(b.z);
    const Rgb backward =
        (through ? LayeredBsdf(m.base, m.layers, turned(b)).eval(turned(a)) : LayeredBsdf(m.base, m.layers, b).eval(a))
            .value /
        a.z;
    const float scale = std::max(max_component(forward), 1e-5f);
    ASSERT_LT((forward - backward).length() / scale, 3e-4f)
        << what << describe(m, a.z) << " " << forward << " " << backward;
  }
}

} // namespace kindling::test
