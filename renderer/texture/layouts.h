// One function for each layout of texels, in a table by the number of the layout.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/texel_fetch.h"

#include <array>
#include <utility>

namespace kindling::texture_detail {

// `pick.operator()<Reader>()` for each layout, in the order of make_layout().
template <typename Pick>
constexpr auto for_each_layout(const Pick& pick) {
  return [&]<size_t... kLayouts>(std::index_sequence<kLayouts...>) {
    return std::array{pick.template operator()<ReaderOfLayout<kLayouts>>()...};
  }
  (std::make_index_sequence<kLayoutCount>());
}

} // namespace kindling::texture_detail
