// Learned selection probabilities of the kinds of light.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kindling {

enum class LightKind : uint8_t { tree, directional, environment };
inline constexpr size_t kLightKinds = 3;

// Indexed by LightKind. Nonnegative, with any positive sum: kinds that the scene lacks are ignored.
using LightProbabilities = std::array<float, kLightKinds>;

} // namespace kindling
