// How the families of lights share the light samples where that has been learned.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kindling {

enum class LightFamily : uint8_t { tree, directional, environment };
inline constexpr size_t kLightFamilies = 3;

// By LightFamily; not negative, with any positive sum: families that a scene does not have are left out.
using LightShares = std::array<float, kLightFamilies>;

} // namespace kindling
