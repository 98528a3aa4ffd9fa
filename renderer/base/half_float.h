// Conversion of halves (IEEE 754 binary16) to floats, which is exact.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/on_gpu.h"

#include <half.h>

#include <bit>
#include <cstdint>

#ifdef __F16C__
#include <immintrin.h>
#endif

namespace kindling {

// A processor without F16C looks it up in Imath's table; GPUs have an instruction.
[[nodiscard]] inline float half_to_float(uint16_t bits) {
#if KINDLING_ON_GPU
  return static_cast<float>(std::bit_cast<_Float16>(bits));
#elif defined(__F16C__)
  return _cvtsh_ss(bits);
#else
  return imath_half_to_float(bits);
#endif
}

} // namespace kindling
