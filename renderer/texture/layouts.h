// The choice of a function with one instance for each texel layout.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/texel_fetch.h"

#include <cassert>
#include <cstdint>

namespace kindling::texture_detail {

// Returns f.operator()<Reader>() for a layout. A switch, because devices have no pointers to
// functions.
template <typename F>
[[gnu::always_inline]] inline auto with_layout(uint8_t layout, const F& f) {
#define KINDLING_LAYOUT(n)                                                                                             \
  case (n):                                                                                                            \
    return f.template operator()<ReaderOfLayout<(n)>>();
#define KINDLING_FOUR_LAYOUTS(n)                                                                                       \
  KINDLING_LAYOUT(n) KINDLING_LAYOUT((n) + 1) KINDLING_LAYOUT((n) + 2) KINDLING_LAYOUT((n) + 3)
  switch (layout) {
    KINDLING_FOUR_LAYOUTS(0)
    KINDLING_FOUR_LAYOUTS(4)
    KINDLING_FOUR_LAYOUTS(8)
    KINDLING_FOUR_LAYOUTS(12)
    KINDLING_FOUR_LAYOUTS(16)
    KINDLING_FOUR_LAYOUTS(20)
    KINDLING_FOUR_LAYOUTS(24)
    KINDLING_FOUR_LAYOUTS(28)
  }
#undef KINDLING_FOUR_LAYOUTS
#undef KINDLING_LAYOUT
  static_assert(kLayoutCount == 32);
  assert(layout < kLayoutCount);
  __builtin_unreachable();
}

} // namespace kindling::texture_detail
