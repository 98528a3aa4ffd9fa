// Hash-based Owen scrambling in base 2, and Sobol generator matrices as a few bit operations.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/simd_types.h"

#include <cstdint>

#ifdef __AVX2__
#include <immintrin.h>
#endif

// A Word is a uint32_t, or a vector of them (Words4 and Words8 of renderer/base/simd_types.h).
namespace kindling::owen_sobol {

// Vectors wider than the target's registers are passed in memory. All functions are inlined, so no
// binary interface depends on it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

template <typename Word>
[[nodiscard]] inline Word reverse_bits(Word x) {
  x = (x >> 16) | (x << 16);
  x = ((x >> 8) & 0x00ff00ffU) | ((x & 0x00ff00ffU) << 8);
  x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
}

#ifdef __AVX2__
// The same by tables of sixteen bytes: the reversed low and high four bits of each byte, then the
// bytes of each word in reverse order. A third of the instructions.
[[nodiscard]] inline Words8 reverse_bits(Words8 x) {
  const __m256i low_bits = _mm256_set1_epi8(0x0f);
  const __m256i reversed_high = _mm256_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15, //
                                                 0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15);
  const __m256i reversed_low = _mm256_slli_epi16(reversed_high, 4);
  const __m256i last_byte_first = _mm256_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12, //
                                                   3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12);
  const auto words = reinterpret_cast<__m256i>(x);
  const __m256i low = _mm256_shuffle_epi8(reversed_low, _mm256_and_si256(words, low_bits));
  const __m256i high = _mm256_shuffle_epi8(reversed_high, _mm256_and_si256(_mm256_srli_epi16(words, 4), low_bits));
  return reinterpret_cast<Words8>(_mm256_shuffle_epi8(_mm256_or_si256(low, high), last_byte_first));
}
#endif

// Applies a random base-2 Owen scrambling to a number whose bits are reversed. In each step a bit
// depends only on itself and on lower bits, which are the higher bits of the number itself. The
// structure is that of Laine and Karras 2011; steps and constants are those of Vegdahl 2021,
// "Building a Better LK Hash", which removed the visible correlations of the original ones.
template <typename Word>
[[nodiscard]] inline Word scramble_reversed(Word x, Word seed) {
  x ^= x * 0x3d20adeaU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526c56U;
  x ^= x * 0x53a22864U;
  return x;
}

// Returns the second Sobol dimension of an index, with reversed bits. (The first dimension is the
// bit reversal of the index, so its reversed bits are the index itself.) The generator matrix is
// Pascal's triangle modulo 2: read as polynomials over GF(2), reversed(y)(t) = index(t + 1), which
// takes five butterflies instead of 32 matrix columns (see Ahmed 2024, "An Implementation Algorithm
// of 2D Sobol Sequence Fast, Elegant, and Compact").
template <typename Word>
[[nodiscard]] inline Word second_reversed(Word x) {
  x ^= (x >> 1) & 0x55555555U;
  x ^= (x >> 2) & 0x33333333U;
  x ^= (x >> 4) & 0x0f0f0f0fU;
  x ^= (x >> 8) & 0x00ff00ffU;
  return x ^ (x >> 16);
}

// Multiply the sixteen two-bit digits of x by w, or by w^2 = w + 1, in GF(4) = {0, 1, w, w + 1}.
// The digit 2 a + b stands for a w + b.
template <typename Word>
[[nodiscard]] inline Word times_w(Word x) {
  return ((x << 1) & 0xaaaaaaaaU) ^ (x & 0xaaaaaaaaU) ^ ((x >> 1) & 0x55555555U);
}
template <typename Word>
[[nodiscard]] inline Word times_w2(Word x) {
  return times_w(x) ^ x;
}

// Returns the index whose first two Sobol dimensions are the third and fourth dimension of `index`.
// Its base-4 digits, as a polynomial over GF(4), are shifted by w^2: result(t) = index(t + w^2),
// which takes four butterflies.
//
// Proof: the matrices of t -> t + a for the four elements a of GF(4) form a (0, 4)-sequence in base
// 4 (Faure 1982; Niederreiter 1987 for prime powers). Shifts add up, and second_reversed() is the
// shift by 1 except for an invertible map within each digit, which moves no interval of base 4. So
// with j = second_pair_index(i), the dimensions (i, second(i), j, second(j)) are a (0, 4)-sequence
// in base 4. The matrix is also upper triangular in base 2, with ones on the diagonal: j runs
// through the same 2^k indices as i, so (j, second(j)) is a (0, 2)-sequence in base 2, as (i,
// second(i)) is. Ahmed et al. 2024, "SZ Sequences: Binary-Based (0, 2^q)-Sequences", find by search
// that two of these fit into one (0, 4)-sequence. Of the shifts by w and by w^2, the latter has the
// better pairs of dimensions 1 and 3 at 8 samples.
template <typename Word>
[[nodiscard]] inline Word second_pair_index(Word x) {
  x ^= times_w2((x >> 2) & 0x33333333U);
  x ^= times_w((x >> 4) & 0x0f0f0f0fU);
  x ^= times_w2((x >> 8) & 0x00ff00ffU);
  return x ^ times_w(x >> 16);
}

// hash_u32() of each lane.
template <typename Word>
[[nodiscard]] inline Word hash_words(Word x) {
  x ^= x >> 16;
  x *= 0x7feb352dU;
  x ^= x >> 15;
  x *= 0x846ca68bU;
  return x ^ (x >> 16);
}

#pragma GCC diagnostic pop

} // namespace kindling::owen_sobol
