// Reflectance of thin films by Belcour and Barla's fit.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/thin_film.h"

#include "renderer/base/lanes.h"
#include "renderer/base/on_gpu.h"
#include "renderer/bsdf/fresnel.h"
#include "renderer/sampling/sincos_turns.h"

#include <array>
#include <cstddef>
#include <numbers>

namespace kindling {

namespace {

// With these orders of arguments NaN becomes the lower bound.
float clamped(float x, float low, float high) { return std::min(std::max(low, x), high); }

// Returns e^-x for x >= 0, relative error below 1e-6: 2^-n with integer n by bit operations, the
// rest in [-1/2, 1/2] by a polynomial. Bitwise equal on every machine, unlike std::exp.
template <typename Real>
Real exp_of_minus(const Real& x) {
  const Real exponent = x * std::numbers::log2e_v<float>;
  const Real y = select(exponent < 125.0f, exponent, Real(125.0f)); // 125 for NaN
  constexpr float kRounding = 12582912.0f;                          // 1.5 * 2^23: adding it rounds to an integer
  const Real rounded = y + kRounding;
  const Real r = ((rounded - kRounding) - y) * std::numbers::ln2_v<float>;
  const Real p =
      1.0f + r * (1.0f + r * (1.0f / 2 + r * (1.0f / 6 + r * (1.0f / 24 + r * (1.0f / 120 + r * (1.0f / 720))))));
  return p * from_bits((127U + bits_of(kRounding) - bits_of(rounded)) << 23);
}

// One Gaussian of the observer fit in wave numbers: its Fourier transform is a damped cosine of the
// optical path difference. Positions are in 1/m and variances in 1/m^2 before the 2 pi of the
// phase; amplitudes are val sqrt(2 pi var) / 1.0685e-7 of KHR_materials_iridescence.
struct Lobe {
  float amplitude;
  float turns_per_nm;    // pos * 1e-9: phase = pos 2 pi OPD 1e-9
  float damping_per_nm2; // var (2 pi 1e-9)^2
};

constexpr double kTwoPiPerNm = 2.0 * std::numbers::pi * 1e-9;
constexpr Lobe observer_lobe(double value_times_root, double position, double variance) {
  return {static_cast<float>(value_times_root / 1.0685e-7), static_cast<float>(position * 1e-9),
          static_cast<float>(variance * kTwoPiPerNm * kTwoPiPerNm)};
}
// X, Y, Z and the second of X: val * sqrt(2 pi var), precomputed because the square root is not
// constexpr.
constexpr std::array kLobes{
    observer_lobe(9.04581417e-08, 1.6810e+06, 4.3278e+09), observer_lobe(1.06873709e-07, 1.7953e+06, 9.3046e+09),
    observer_lobe(1.06969938e-07, 2.2084e+06, 6.6121e+09), observer_lobe(1.64408286e-08, 2.2399e+06, 4.5282e+09)};
constexpr std::array<float, Lanes::kCount> lobes_in_lanes(float Lobe::*member) {
  std::array<float, Lanes::kCount> lanes{}; // those without a lobe are not read
  for (size_t i = 0; i < kLobes.size(); ++i) lanes[i] = kLobes[i].*member;
  return lanes;
}
constexpr std::array kAmplitudes = lobes_in_lanes(&Lobe::amplitude), kTurns = lobes_in_lanes(&Lobe::turns_per_nm),
                     kDampings = lobes_in_lanes(&Lobe::damping_per_nm2);

// The cosine of the phase times the remaining amplitude, for the first two harmonics of the optical
// path difference.
template <typename Real>
struct HarmonicsOf {
  Real first;
  Real second;
};
template <typename Real>
HarmonicsOf<Real> harmonics(const Real& amplitude, const Real& turns_per_nm, const Real& damping_per_nm2,
                            float opd_nm) {
  const Real c = sincos_turns(turns_per_nm * opd_nm).cos;
  const Real damping = exp_of_minus(damping_per_nm2 * opd_nm * opd_nm);
  const Real damping2 = damping * damping;
  return {amplitude * damping * c, amplitude * damping2 * damping2 * (2.0f * c * c - 1.0f)};
}

// Those of all lobes: together where there are lanes.
HarmonicsOf<std::array<float, Lanes::kCount>> all_harmonics(float opd_nm) {
  HarmonicsOf<std::array<float, Lanes::kCount>> all;
  if constexpr (KINDLING_ON_GPU) {
    for (size_t i = 0; i < kLobes.size(); ++i) {
      const HarmonicsOf<float> one = harmonics(kAmplitudes[i], kTurns[i], kDampings[i], opd_nm);
      all.first[i] = one.first;
      all.second[i] = one.second;
    }
  } else {
    const HarmonicsOf<Lanes> lanes =
        harmonics(Lanes::load(kAmplitudes.data()), Lanes::load(kTurns.data()), Lanes::load(kDampings.data()), opd_nm);
    lanes.first.store(all.first.data());
    lanes.second.store(all.second.data());
  }
  return all;
}

Rgb xyz_to_rec709(const V3f& xyz) {
  return {3.2404542f * xyz.x - 1.5371385f * xyz.y - 0.4985314f * xyz.z,
          -0.9692660f * xyz.x + 1.8760108f * xyz.y + 0.0415560f * xyz.z,
          0.0556434f * xyz.x - 0.2040259f * xyz.y + 1.0572252f * xyz.z};
}

constexpr float kFadedThickness = 0.03f; // nm

// Fades from no film to the full film by smoothstep(0, kFadedThickness, thickness). The extension's
// viewer fades the film's index instead, which leaves Schlick's Fresnel of an interface between
// equal indices: (1 - cos)^5.
Rgb fade(const Rgb& plain, const Rgb& film, float thickness_nm) {
  const float t = thickness_nm * (1.0f / kFadedThickness);
  return lerp(plain, film, t * t * (3.0f - 2.0f * t));
}

} // namespace

ThinFilm::ThinFilm(float outside_ior, float film_ior, const Rgb& base_f0, float thickness_nm)
    : thickness_nm_(clamped(thickness_nm, 0.0f, 1e5f)) { // interference vanishes beyond
  const float outside = clamped(outside_ior, 1.0f, 100.0f);
  film_ior_ = clamped(film_ior, 1.0f, 100.0f);
  const float eta = film_ior_ / outside;
  eta2_ = eta * eta;
  f0_12_ = dielectric_f0(eta);
  const bool shift_21 = film_ior_ >= outside;
  for (int c = 0; c < 3; ++c) {
    base_f0_[c] = clamped(base_f0[c], 0.0f, 1.0f);
    const float root = std::sqrt(std::min(base_f0_[c], 0.9999f)); // avoids an infinite index
    const float base_ior = (1.0f + root) / (1.0f - root);
    f0_23_[c] = dielectric_f0(base_ior / film_ior_);
    const bool shift_23 = base_ior < film_ior_;
    sign_[c] = shift_21 != shift_23 ? -1.0f : 1.0f;
  }
}

Rgb ThinFilm::fresnel(float cos_theta) const {
  const float cos_1 = clamped(cos_theta, 0.0f, 1.0f);
  if (thickness_nm_ < kFadedThickness) return fade(schlick_of_base(cos_1), film_fresnel(cos_1), thickness_nm_);
  return film_fresnel(cos_1);
}

Rgb ThinFilm::schlick_of_base(float cos_1) const {
  return {schlick_fresnel(base_f0_.x, 1.0f, cos_1), schlick_fresnel(base_f0_.y, 1.0f, cos_1),
          schlick_fresnel(base_f0_.z, 1.0f, cos_1)};
}

Rgb ThinFilm::film_fresnel(float cos_1) const {
  const float sin2_2 = (1.0f - cos_1 * cos_1) / eta2_;
  if (sin2_2 > 1.0f) return Rgb(1.0f);
  const float cos_2 = std::sqrt(1.0f - sin2_2);

  // Outside to film. Phases are 0 or pi: cos(m (phase + phi)) = cos(m phase) cos(m phi), and cos(m
  // phi) is +-1 for m = 1, 1 for m = 2.
  const float r12 = schlick_fresnel(f0_12_, 1.0f, cos_1);
  const float t121 = 1.0f - r12;

  const float opd_nm = 2.0f * film_ior_ * thickness_nm_ * cos_2;
  const auto [lobe, lobe2] = all_harmonics(opd_nm); // of the first and of the second order

  // As in the extension, the phase of the base's red channel applies to X, green's to Y, blue's to
  // Z.
  const V3f first(sign_.x * (lobe[0] + lobe[3]), sign_.y * lobe[1], sign_.z * lobe[2]);
  const Rgb s1 = xyz_to_rec709(first);
  const Rgb s2 = xyz_to_rec709({lobe2[0] + lobe2[3], lobe2[1], lobe2[2]});

  Rgb result;
  for (int c = 0; c < 3; ++c) {
    const float r23 = schlick_fresnel(f0_23_[c], 1.0f, cos_2);
    const float r123_squared = clamped(r12 * r23, 1e-5f, 0.9999f);
    const float r123 = std::sqrt(r123_squared);
    const float rs = t121 * t121 * r23 / (1.0f - r123_squared);
    const float c1 = (rs - t121) * r123;
    const float sum = r12 + rs + 2.0f * c1 * (s1[c] + r123 * s2[c]);
    result[c] = clamped(sum, 0.0f, 1.0f);
  }
  return result;
}

} // namespace kindling
