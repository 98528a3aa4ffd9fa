// SIMD lanes of float or uint32_t for one target: AVX-512, AVX2 or plain loops.
// All targets give equal results. Included once per target, with KINDLING_SIMD as its namespace and
// KINDLING_SIMD_LEVEL as its level (512, 2 or 0).
//
// Operations are IEEE single precision without contraction. min and max return the second operand
// if either is NaN. Lanes8 and IntLanes8 have eight lanes, the children of a wide node. Lanes16 has
// sixteen, the vertices of a leaf block or the rays of a packet, in one register or two. WideLanes
// and WideIntLanes have kLanes, the number of triangles that the target tests at once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/includes.h"

#if KINDLING_SIMD_LEVEL >= 2
#include "accel/kdtree/kernels/simd_x86.h"
#else
#include "accel/kdtree/kernels/simd_portable.h"
#endif

namespace kindling::accel::kd::KINDLING_SIMD {

// Transposes four vectors: out[i] receives lane i of each.
inline void transpose(Float4 a, Float4 b, Float4 c, Float4 d, const std::array<float*, 4>& out) {
  Float4 lanes[4] = {a, b, c, d};
  accel::transpose(lanes);
  for (size_t i = 0; i < 4; ++i) std::memcpy(out[i], &lanes[i], sizeof(Float4));
}

#if KINDLING_SIMD_LEVEL == 0

// See the versions for AVX-512.
template <class VectorAt>
inline void transpose16(const VectorAt& vector_at, const std::array<float*, 4>& out) {
  for (uint32_t i = 0; i < 16; i += 4)
    transpose(vector_at(i), vector_at(i + 1), vector_at(i + 2), vector_at(i + 3),
              {out[0] + i, out[1] + i, out[2] + i, out[3] + i});
}
template <class To>
inline void scatter16(const Lanes16& x, const Lanes16& y, const Lanes16& z, const Lanes16& w, const To& to) {
  for (uint32_t i = 0; i < 16; ++i) {
    const float vector[4] = {x.v[i], y.v[i], z.v[i], w.v[i]};
    std::memcpy(to(i), vector, sizeof(vector));
  }
}

#endif

#if KINDLING_SIMD_LEVEL != 512

inline uint32_t numbers_above(const float* lanes, uint32_t x) {
  uint32_t bits = 0;
  for (uint32_t i = 0; i < 16; ++i) bits |= static_cast<uint32_t>(std::bit_cast<uint32_t>(lanes[i]) > x) << i;
  return bits;
}

#endif

} // namespace kindling::accel::kd::KINDLING_SIMD
