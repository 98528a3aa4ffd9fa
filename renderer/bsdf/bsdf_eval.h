// The value and the densities of a BSDF in a direction, for one direction or for several in lanes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/base/lanes.h"
#include "renderer/base/math.h"
#include "renderer/base/on_gpu.h"

#include <array>
#include <cassert>
#include <cstddef>
#include <span>

namespace kindling {

// Directions that are evaluated together: in the lanes of vectors, which the threads of a GPU do
// not have.
inline constexpr size_t kEvalsTogether = KINDLING_ON_GPU ? 1 : Lanes::kCount;
inline constexpr size_t kMinEvalsTogether = 3; // fewer are evaluated faster one by one

template <typename Real>
struct BsdfEvalOf {
  Imath::Vec3<Real> value{Real(0.0f)}; // f(wo, wi) |cos_theta_i|
  Real pdf = 0.0f;                     // solid-angle density of sample() for wi
  Real reflection_pdf = 0.0f;          // of sample_reflection()
};
using BsdfEval = BsdfEvalOf<float>;

// At most kEvalsTogether unit directions, coordinate by coordinate.
class EvalDirections {
 public:
  EvalDirections() = default;
  explicit EvalDirections(std::span<const V3f> directions) {
    for (const V3f& direction : directions) add(direction);
  }
#if !KINDLING_ON_GPU
  // The first `count` of eight.
  EvalDirections(const Imath::Vec3<Lanes>& directions, size_t count) : count_(count) {
    assert(count <= kEvalsTogether);
    directions.x.store(x_.data());
    directions.y.store(y_.data());
    directions.z.store(z_.data());
  }
#endif

  void add(const V3f& direction) {
    assert(count_ < kEvalsTogether);
    x_[count_] = direction.x, y_[count_] = direction.y, z_[count_] = direction.z;
    ++count_;
  }
  void clear() { count_ = 0; }
  [[nodiscard]] size_t size() const { return count_; }
  [[nodiscard]] V3f operator[](size_t number) const { return {x_[number], y_[number], z_[number]}; }

#if !KINDLING_ON_GPU
  // Returns them in lanes, if there are any; lanes that are left over have the last one.
  [[nodiscard]] Imath::Vec3<Lanes> lanes() const {
    assert(count_ > 0);
    const LaneMask used = LaneMask{0, 1, 2, 3, 4, 5, 6, 7} < static_cast<int32_t>(count_);
    const auto filled = [&](const Numbers& numbers) {
      return select(used, Lanes::load(numbers.data()), Lanes(numbers[count_ - 1]));
    };
    return {filled(x_), filled(y_), filled(z_)};
  }
#endif

 private:
  using Numbers = std::array<float, kEvalsTogether>;

  alignas(32) Numbers x_, y_, z_; // not initialized, so that they cost nothing
  size_t count_ = 0;
};

// Returns the local coordinates of directions.
[[nodiscard]] inline EvalDirections to_local(const Frame& frame, const EvalDirections& directions) {
#if !KINDLING_ON_GPU
  if (directions.size() >= kMinEvalsTogether) return {frame.to_local(directions.lanes()), directions.size()};
#endif
  EvalDirections local;
  for (size_t i = 0; i < directions.size(); ++i) local.add(frame.to_local(directions[i]));
  return local;
}

// BsdfEvals of several directions, number by number. Not initialized, so that they cost nothing.
struct BsdfEvals {
  using Numbers = std::array<float, kEvalsTogether>;
  alignas(32) Numbers red, green, blue; // of the values
  alignas(32) Numbers pdfs, reflection_pdfs;

  void set(size_t number, const BsdfEval& eval) {
    red[number] = eval.value.x, green[number] = eval.value.y, blue[number] = eval.value.z;
    pdfs[number] = eval.pdf, reflection_pdfs[number] = eval.reflection_pdf;
  }
#if !KINDLING_ON_GPU
  // Sets those of directions in lanes, which are zero at and below the horizon.
  void set_above(const Imath::Vec3<Lanes>& wi, const BsdfEvalOf<Lanes>& eval) {
    const LaneMask above = wi.z > 0.0f;
    const auto store = [&](Numbers& numbers, const Lanes& lanes) {
      select(above, lanes, Lanes(0.0f)).store(numbers.data());
    };
    store(red, eval.value.x), store(green, eval.value.y), store(blue, eval.value.z);
    store(pdfs, eval.pdf), store(reflection_pdfs, eval.reflection_pdf);
  }
#endif
  [[nodiscard]] Rgb value(size_t number) const { return {red[number], green[number], blue[number]}; }
  [[nodiscard]] BsdfEval operator[](size_t number) const {
    return {value(number), pdfs[number], reflection_pdfs[number]};
  }
};

} // namespace kindling
