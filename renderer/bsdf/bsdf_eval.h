// The value and the densities of a BSDF in a direction, for one direction or for several in lanes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

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

// Those of several directions. Not initialized, so that it costs nothing.
struct BsdfEvals {
  std::array<Rgb, kEvalsTogether> values;
  std::array<float, kEvalsTogether> pdfs, reflection_pdfs;
  void set(size_t number, const BsdfEval& eval) {
    values[number] = eval.value, pdfs[number] = eval.pdf, reflection_pdfs[number] = eval.reflection_pdf;
  }
  // Sets those of the directions `wi`, which are zero at and below the horizon.
  void set_above(std::span<const V3f> wi, const BsdfEvalOf<Lanes>& eval) {
    assert(wi.size() <= kEvalsTogether);
    LaneVectors lane_values;
    LaneNumbers lane_pdfs, lane_reflection_pdfs;
    lane_values.store(eval.value);
    lane_pdfs.store(eval.pdf);
    lane_reflection_pdfs.store(eval.reflection_pdf);
    for (size_t i = 0; i < wi.size(); ++i)
      set(i, wi[i].z > 0.0f ? BsdfEval{lane_values[i], lane_pdfs[i], lane_reflection_pdfs[i]} : BsdfEval{});
  }
  [[nodiscard]] BsdfEval operator[](size_t number) const {
    return {values[number], pdfs[number], reflection_pdfs[number]};
  }
};

// Returns one to eight vectors in lanes; those that are left over have the last one.
[[nodiscard]] inline Imath::Vec3<Lanes> in_lanes(std::span<const V3f> vectors) {
  assert(!vectors.empty() && vectors.size() <= Lanes::kCount);
  LaneVectors lanes;
  for (size_t i = 0; i < Lanes::kCount; ++i) lanes.set(i, vectors[std::min(i, vectors.size() - 1)]);
  return lanes.load();
}

} // namespace kindling
