// Tables of functions with one instance for each texel layout.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/texel_fetch.h"

#include <array>
#include <utility>

namespace kindling::texture_detail {

// Returns the results of `pick.operator()<Reader>()` for all layouts, indexed by make_layout().
template <typename Pick>
constexpr auto for_each_layout(const Pick& pick) {
  return [&]<size_t... kLayouts>(std::index_sequence<kLayouts...>) {
    return std::array{pick.template operator()<ReaderOfLayout<kLayouts>>()...};
  }
  (std::make_index_sequence<kLayoutCount>());
}

} // namespace kindling::texture_detail
