// How the kinds of light share the light samples where that has been learned.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kindling {

enum class LightKind : uint8_t { tree, directional, environment };
inline constexpr size_t kLightKinds = 3;

// By LightKind; not negative, with any positive sum: kinds that a scene does not have are left out.
using LightProbabilities = std::array<float, kLightKinds>;

} // namespace kindling
