// Eight floats side by side with the operations of one, under names that fit a single float, too.
//
// A function template of a number type Real computes one result with `float` and eight with
// `Lanes`, from one source and with the same bits in each lane: IEEE 754 defines every operation
// here to the last bit. Branches become select(); a condition is a bool, or a LaneMask.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/elementary.h"
#include "renderer/base/math.h"
#include "renderer/base/simd_types.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace kindling {

// Vectors wider than the target's registers are passed in memory. All functions are inlined, so no
// binary interface depends on it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

// The result of a comparison: all bits of a lane are set where it is true.
using LaneMask = Int8;

struct Lanes {
  static constexpr size_t kCount = 8;

  Lanes() = default; // uninitialized, like a float
  // Implicit, so that numbers mix with lanes as they do with floats.
  Lanes(float x) : v{x, x, x, x, x, x, x, x} {}
  explicit Lanes(const Float8& lanes) : v(lanes) {}
  [[nodiscard]] static Lanes load(const float* values) { // any alignment
    Lanes result;
    __builtin_memcpy(&result.v, values, sizeof(result.v));
    return result;
  }
  void store(float* values) const { __builtin_memcpy(values, &v, sizeof(v)); }
  [[nodiscard]] float operator[](size_t lane) const { return v[lane]; }

  friend Lanes operator+(const Lanes& a, const Lanes& b) { return Lanes(a.v + b.v); }
  friend Lanes operator-(const Lanes& a, const Lanes& b) { return Lanes(a.v - b.v); }
  friend Lanes operator*(const Lanes& a, const Lanes& b) { return Lanes(a.v * b.v); }
  friend Lanes operator/(const Lanes& a, const Lanes& b) { return Lanes(a.v / b.v); }
  friend Lanes operator-(const Lanes& a) { return Lanes(-a.v); }
  friend LaneMask operator<(const Lanes& a, const Lanes& b) { return a.v < b.v; }
  friend LaneMask operator>(const Lanes& a, const Lanes& b) { return a.v > b.v; }
  friend LaneMask operator<=(const Lanes& a, const Lanes& b) { return a.v <= b.v; }
  friend LaneMask operator==(const Lanes& a, const Lanes& b) { return a.v == b.v; }
  friend LaneMask operator>=(const Lanes& a, const Lanes& b) { return a.v >= b.v; }

  Float8 v;
};

// The result of comparing numbers of a type.
template <typename Real>
using MaskOf = std::conditional_t<std::is_same_v<Real, Lanes>, LaneMask, bool>;

// The words of a number's bits.
template <typename Real>
using WordsOf = std::conditional_t<std::is_same_v<Real, Lanes>, Words8, uint32_t>;

[[nodiscard]] constexpr uint32_t bits_of(float x) { return std::bit_cast<uint32_t>(x); }
[[nodiscard]] inline Words8 bits_of(const Lanes& x) { return reinterpret_cast<Words8>(x.v); }
[[nodiscard]] constexpr float from_bits(uint32_t bits) { return std::bit_cast<float>(bits); }
[[nodiscard]] inline Lanes from_bits(const Words8& bits) { return Lanes(reinterpret_cast<Float8>(bits)); }

// Returns the number in [0, 1) of the upper 24 bits of each word: to_unit_float() of hash.h.
[[nodiscard]] inline Lanes to_unit_float(const Words8& x) {
  return Lanes(__builtin_convertvector((Int8)(x >> 8), Float8) * 0x1p-24f);
}

// Returns a where the condition holds, else b. Both are evaluated.
[[nodiscard]] constexpr float select(bool condition, float a, float b) { return condition ? a : b; }
[[nodiscard]] inline Lanes select(bool condition, const Lanes& a, const Lanes& b) { return condition ? a : b; }
[[nodiscard]] inline Lanes select(const LaneMask& condition, const Lanes& a, const Lanes& b) {
  return Lanes(condition ? a.v : b.v);
}
template <typename Condition, typename Real>
[[nodiscard]] Imath::Vec2<Real> select(const Condition& condition, const Imath::Vec2<Real>& a,
                                       const Imath::Vec2<Real>& b) {
  return {select(condition, a.x, b.x), select(condition, a.y, b.y)};
}
template <typename Condition, typename Real>
[[nodiscard]] Imath::Vec3<Real> select(const Condition& condition, const Imath::Vec3<Real>& a,
                                       const Imath::Vec3<Real>& b) {
  return {select(condition, a.x, b.x), select(condition, a.y, b.y), select(condition, a.z, b.z)};
}

// True if the condition holds in any lane, in all lanes.
[[nodiscard]] constexpr bool any(bool condition) { return condition; }
[[nodiscard]] constexpr bool all(bool condition) { return condition; }
#ifdef __AVX__
[[nodiscard]] inline uint32_t packed(const LaneMask& mask) {
  return static_cast<uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
}
#else
[[nodiscard]] inline uint32_t packed(const LaneMask& mask) {
  uint32_t bits = 0;
  for (uint32_t i = 0; i < Lanes::kCount; ++i) bits |= mask[i] != 0 ? 1U << i : 0U;
  return bits;
}
#endif
// The inverse: a mask of the lanes whose bits are set.
[[nodiscard]] inline LaneMask lane_mask(uint32_t bits) {
  const auto all = static_cast<int32_t>(bits);
  return (LaneMask{all, all, all, all, all, all, all, all} & LaneMask{1, 2, 4, 8, 16, 32, 64, 128}) != 0;
}
[[nodiscard]] inline bool any(const LaneMask& mask) { return packed(mask) != 0; }
[[nodiscard]] inline bool all(const LaneMask& mask) { return packed(mask) == 0xffU; }

// std::max, std::min, std::fabs, std::copysign and std::sqrt. The first two return their first
// argument if one is NaN.
[[nodiscard]] inline float maximum(float a, float b) { return std::max(a, b); }
[[nodiscard]] inline float minimum(float a, float b) { return std::min(a, b); }
[[nodiscard]] inline float absolute(float x) { return std::fabs(x); }
[[nodiscard]] inline float with_sign_of(float magnitude, float sign) { return std::copysign(magnitude, sign); }
[[nodiscard]] inline float square_root(float x) { return std::sqrt(x); }
[[nodiscard]] inline Lanes maximum(const Lanes& a, const Lanes& b) { return Lanes(b.v > a.v ? b.v : a.v); }
[[nodiscard]] inline Lanes minimum(const Lanes& a, const Lanes& b) { return Lanes(b.v < a.v ? b.v : a.v); }
[[nodiscard]] inline Lanes absolute(const Lanes& x) { return from_bits(bits_of(x) & 0x7fffffffU); }
[[nodiscard]] inline Lanes with_sign_of(const Lanes& magnitude, const Lanes& sign) {
  return from_bits((bits_of(magnitude) & 0x7fffffffU) | (bits_of(sign) & 0x80000000U));
}
[[nodiscard]] inline Lanes square(const Lanes& x) { return x * x; }
[[nodiscard]] inline Lanes square_root(const Lanes& x) {
#ifdef __AVX__
  return Lanes(static_cast<Float8>(_mm256_sqrt_ps(static_cast<__m256>(x.v))));
#else
  Lanes result;
  for (size_t i = 0; i < Lanes::kCount; ++i) result.v[i] = std::sqrt(x.v[i]);
  return result;
#endif
}

// Those of math.h. Functions of vectors are templates, so that lists in braces stay floats.
[[nodiscard]] inline Lanes safe_sqrt(const Lanes& x) { return square_root(maximum(x, Lanes(0.0f))); }
[[nodiscard]] inline Lanes lerp(const Lanes& a, const Lanes& b, const Lanes& t) { return a + (b - a) * t; }
template <std::same_as<Lanes> Real>
[[nodiscard]] Imath::Vec3<Real> lerp(const Imath::Vec3<Real>& a, const Imath::Vec3<Real>& b, const Real& t) {
  return a + (b - a) * t;
}
template <std::same_as<Lanes> Real>
[[nodiscard]] Real max_component(const Imath::Vec3<Real>& v) {
  return maximum(v.x, maximum(v.y, v.z));
}
template <std::same_as<Lanes> Real>
[[nodiscard]] Real max_abs(const Imath::Vec3<Real>& v) {
  return maximum(absolute(v.x), maximum(absolute(v.y), absolute(v.z)));
}
template <std::same_as<Lanes> Real>
[[nodiscard]] LaneMask is_black(const Imath::Vec3<Real>& c) {
  return (c.x == 0.0f) & (c.y == 0.0f) & (c.z == 0.0f);
}
[[nodiscard]] inline Int8 cells_of(const Lanes& x, uint32_t last) { // cell_of()
  const Lanes clamped = minimum(maximum(Lanes(0.0f), x), Lanes(static_cast<float>(last)));
  return __builtin_convertvector(clamped.v, Int8);
}

// Returns what one of two functions returns: that of the first where the condition holds, else that
// of the second. Of eight lanes both are called.
template <typename F, typename G>
[[nodiscard]] auto select_result(bool condition, const F& f, const G& g) {
  return condition ? f() : g();
}
template <typename F, typename G>
[[nodiscard]] auto select_result(const LaneMask& condition, const F& f, const G& g) {
  return select(condition, f(), g());
}

[[nodiscard]] inline V3f lane_of(const Imath::Vec3<Lanes>& v, size_t lane) { return {v.x[lane], v.y[lane], v.z[lane]}; }

// Returns lane i ^ other of x in each lane i; other < 8.
[[nodiscard]] inline Lanes exchanged(const Lanes& x, uint32_t other) {
#ifdef __AVX2__
  const Int8 from = Int8{0, 1, 2, 3, 4, 5, 6, 7} ^ static_cast<int32_t>(other);
  return Lanes(
      static_cast<Float8>(_mm256_permutevar8x32_ps(static_cast<__m256>(x.v), reinterpret_cast<__m256i>(from))));
#else
  Lanes result;
  for (uint32_t i = 0; i < Lanes::kCount; ++i) result.v[i] = x.v[i ^ other];
  return result;
#endif
}
[[nodiscard]] inline Imath::Vec3<Lanes> exchanged(const Imath::Vec3<Lanes>& v, uint32_t other) {
  return {exchanged(v.x, other), exchanged(v.y, other), exchanged(v.z, other)};
}

// Memory in which lanes are filled or read one by one.
struct LaneNumbers {
  alignas(32) float values[Lanes::kCount];
  [[nodiscard]] Lanes load() const { return Lanes::load(values); }
  void store(const Lanes& x) { x.store(values); }
  [[nodiscard]] float& operator[](size_t lane) { return values[lane]; }
  [[nodiscard]] float operator[](size_t lane) const { return values[lane]; }
};
struct LaneVectors {
  LaneNumbers x, y, z;
  [[nodiscard]] Imath::Vec3<Lanes> load() const { return {x.load(), y.load(), z.load()}; }
  void store(const Imath::Vec3<Lanes>& v) { x.store(v.x), y.store(v.y), z.store(v.z); }
  void set(size_t lane, const V3f& v) { x[lane] = v.x, y[lane] = v.y, z[lane] = v.z; }
  [[nodiscard]] V3f operator[](size_t lane) const { return {x[lane], y[lane], z[lane]}; }
};

// Exchanges rows and columns: lane j of vector i becomes lane i of vector j.
inline void transpose(Lanes (&m)[Lanes::kCount]) {
  Float8 pairs[Lanes::kCount], quads[Lanes::kCount];
  for (size_t i = 0; i < 8; i += 2) { // within halves
    pairs[i] = __builtin_shufflevector(m[i].v, m[i + 1].v, 0, 8, 1, 9, 4, 12, 5, 13);
    pairs[i + 1] = __builtin_shufflevector(m[i].v, m[i + 1].v, 2, 10, 3, 11, 6, 14, 7, 15);
  }
  for (size_t i = 0; i < 8; i += 4) {
    quads[i] = __builtin_shufflevector(pairs[i], pairs[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
    quads[i + 1] = __builtin_shufflevector(pairs[i], pairs[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    quads[i + 2] = __builtin_shufflevector(pairs[i + 1], pairs[i + 3], 0, 1, 8, 9, 4, 5, 12, 13);
    quads[i + 3] = __builtin_shufflevector(pairs[i + 1], pairs[i + 3], 2, 3, 10, 11, 6, 7, 14, 15);
  }
  for (size_t i = 0; i < 4; ++i) {
    m[i].v = __builtin_shufflevector(quads[i], quads[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    m[i + 4].v = __builtin_shufflevector(quads[i], quads[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

// Returns the columns of eight rows of four numbers; rows may have any alignment.
[[nodiscard]] inline std::array<Lanes, 4> load_columns(const std::array<const float*, Lanes::kCount>& rows) {
  Float8 halves[4], pairs[4];
  for (size_t i = 0; i < 4; ++i) { // rows i and i + 4
    Float4 low, high;
    __builtin_memcpy(&low, rows[i], sizeof(low));
    __builtin_memcpy(&high, rows[i + 4], sizeof(high));
    halves[i] = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  }
  for (size_t i = 0; i < 4; i += 2) { // within halves
    pairs[i] = __builtin_shufflevector(halves[i], halves[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
    pairs[i + 1] = __builtin_shufflevector(halves[i], halves[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
  }
  return {Lanes(__builtin_shufflevector(pairs[0], pairs[2], 0, 1, 8, 9, 4, 5, 12, 13)),
          Lanes(__builtin_shufflevector(pairs[0], pairs[2], 2, 3, 10, 11, 6, 7, 14, 15)),
          Lanes(__builtin_shufflevector(pairs[1], pairs[3], 0, 1, 8, 9, 4, 5, 12, 13)),
          Lanes(__builtin_shufflevector(pairs[1], pairs[3], 2, 3, 10, 11, 6, 7, 14, 15))};
}

// Eight rows of eight numbers in memory: lanes become the members of eight structs.
struct LaneRows {
  alignas(32) float rows[Lanes::kCount][Lanes::kCount];
  [[nodiscard]] const float* operator[](size_t row) const { return rows[row]; }
  // Row i gets lane i of all columns; these are transposed.
  void store_columns(Lanes (&columns)[Lanes::kCount]) {
    transpose(columns);
    for (size_t i = 0; i < Lanes::kCount; ++i) columns[i].store(rows[i]);
  }
};

// Calls a function of floats for each lane; the compiler makes vector code of it where it can.
template <typename F>
[[nodiscard]] inline Lanes for_each_lane(const F& f, const Lanes& x) {
  LaneNumbers in, out;
  in.store(x);
  for (size_t i = 0; i < Lanes::kCount; ++i) out[i] = f(in[i]);
  return out.load();
}
template <typename F>
[[nodiscard]] inline Lanes for_each_lane(const F& f, const Lanes& x, const Lanes& y) {
  LaneNumbers in_x, in_y, out;
  in_x.store(x);
  in_y.store(y);
  for (size_t i = 0; i < Lanes::kCount; ++i) out[i] = f(in_x[i], in_y[i]);
  return out.load();
}
namespace elementary {
[[nodiscard]] inline Lanes atan2(const Lanes& y, const Lanes& x) {
  return for_each_lane([](float a, float b) { return atan2(a, b); }, y, x);
}
} // namespace elementary

// Returns the length of a vector, accurate for tiny ones as well: Imath's length().
[[nodiscard]] inline float length_of(const V3f& v) { return v.length(); }
[[nodiscard]] inline Lanes length_of(const Imath::Vec3<Lanes>& v) {
  const Lanes length2 = v.length2();
  Lanes result = square_root(length2);
  const LaneMask tiny = length2 < 2.0f * std::numeric_limits<float>::min();
  if (any(tiny)) [[unlikely]] {
    for (size_t i = 0; i < Lanes::kCount; ++i)
      if (tiny[i] != 0) result.v[i] = V3f(v.x[i], v.y[i], v.z[i]).length();
  }
  return result;
}

#pragma GCC diagnostic pop

} // namespace kindling
