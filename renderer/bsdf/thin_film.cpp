// Reflectance of thin films by Belcour and Barla's fit.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/thin_film.h"

#include "renderer/base/lanes.h"
#include "renderer/base/on_gpu.h"
#include "renderer/bsdf/fast_pow.h"
#include "renderer/bsdf/fresnel.h"
#include "renderer/sampling/sincos_turns.h"

#include <array>
#include <cstddef>
#include <numbers>
#include <type_traits>

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
  const Real rounded = y + kIntegerRounder;
  const Real r = ((rounded - kIntegerRounder) - y) * std::numbers::ln2_v<float>;
  const Real p =
      1.0f + r * (1.0f + r * (1.0f / 2 + r * (1.0f / 6 + r * (1.0f / 24 + r * (1.0f / 120 + r * (1.0f / 720))))));
  return p * from_bits((127U + bits_of(kIntegerRounder) - bits_of(rounded)) << 23);
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
                            const Real& opd_nm) {
  const Real c = sincos_turns(turns_per_nm * opd_nm).cos;
  const Real damping = exp_of_minus(damping_per_nm2 * opd_nm * opd_nm);
  const Real damping2 = damping * damping;
  return {amplitude * damping * c, amplitude * damping2 * damping2 * (2.0f * c * c - 1.0f)};
}

// The harmonics of all lobes at one optical path difference: in lanes, where there are any.
template <typename Real>
HarmonicsOf<std::array<Real, kLobes.size()>> all_harmonics(const Real& opd_nm) {
  HarmonicsOf<std::array<Real, kLobes.size()>> all;
  if constexpr (KINDLING_ON_GPU || std::is_same_v<Real, Lanes>) {
    for (size_t i = 0; i < kLobes.size(); ++i) {
      const HarmonicsOf<Real> one = harmonics(Real(kAmplitudes[i]), Real(kTurns[i]), Real(kDampings[i]), opd_nm);
      all.first[i] = one.first;
      all.second[i] = one.second;
    }
  } else {
    const HarmonicsOf<Lanes> lanes = harmonics(Lanes::load(kAmplitudes.data()), Lanes::load(kTurns.data()),
                                               Lanes::load(kDampings.data()), Lanes(opd_nm));
    for (size_t i = 0; i < kLobes.size(); ++i) {
      all.first[i] = lanes.first[i];
      all.second[i] = lanes.second[i];
    }
  }
  return all;
}

template <typename Real>
Imath::Vec3<Real> xyz_to_rec709(const Imath::Vec3<Real>& xyz) {
  return {3.2404542f * xyz.x - 1.5371385f * xyz.y - 0.4985314f * xyz.z,
          -0.9692660f * xyz.x + 1.8760108f * xyz.y + 0.0415560f * xyz.z,
          0.0556434f * xyz.x - 0.2040259f * xyz.y + 1.0572252f * xyz.z};
}

constexpr float kFadedThickness = 0.03f; // nm

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

// Fades from no film to the full film by smoothstep(0, kFadedThickness, thickness). The extension's
// viewer fades the film's index instead, which leaves Schlick's Fresnel of an interface between
// equal indices: (1 - cos)^5.
template <typename Real>
Imath::Vec3<Real> ThinFilm::fresnel(const Real& cos_theta) const {
  const Real cos_1 = minimum(maximum(Real(0.0f), cos_theta), Real(1.0f)); // 0 for NaN
  const Imath::Vec3<Real> film = film_fresnel(cos_1);
  if (!(thickness_nm_ < kFadedThickness)) return film;
  const float t = thickness_nm_ * (1.0f / kFadedThickness);
  const float weight = t * t * (3.0f - 2.0f * t);
  const auto faded = [&](int c) {
    const Real plain = schlick_fresnel(base_f0_[c], 1.0f, cos_1);
    return Real(plain + (film[c] - plain) * weight);
  };
  return {faded(0), faded(1), faded(2)};
}

template <typename Real>
Imath::Vec3<Real> ThinFilm::film_fresnel(const Real& cos_1) const {
  const Real sin2_2 = (1.0f - cos_1 * cos_1) / eta2_;
  const auto total = sin2_2 > 1.0f;
  if (all(total)) return Imath::Vec3<Real>(Real(1.0f));
  const Real cos_2 = square_root(maximum(Real(1.0f - sin2_2), Real(0.0f)));

  // Outside to film. Phases are 0 or pi: cos(m (phase + phi)) = cos(m phase) cos(m phi), and cos(m
  // phi) is +-1 for m = 1, 1 for m = 2.
  const Real r12 = schlick_fresnel(f0_12_, 1.0f, cos_1);
  const Real t121 = 1.0f - r12;

  const Real opd_nm = 2.0f * film_ior_ * thickness_nm_ * cos_2;
  const auto [lobe, lobe2] = all_harmonics(opd_nm); // of the first and of the second order

  // As in the extension, the phase of the base's red channel applies to X, green's to Y, blue's to
  // Z.
  const Imath::Vec3<Real> first(sign_.x * (lobe[0] + lobe[3]), sign_.y * lobe[1], sign_.z * lobe[2]);
  const Imath::Vec3<Real> s1 = xyz_to_rec709(first);
  const Imath::Vec3<Real> s2 = xyz_to_rec709(Imath::Vec3<Real>(lobe2[0] + lobe2[3], lobe2[1], lobe2[2]));

  Imath::Vec3<Real> result;
  for (int c = 0; c < 3; ++c) {
    const Real r23 = schlick_fresnel(f0_23_[c], 1.0f, cos_2);
    const Real r123_squared = minimum(maximum(Real(1e-5f), Real(r12 * r23)), Real(0.9999f));
    const Real r123 = square_root(r123_squared);
    const Real rs = t121 * t121 * r23 / (1.0f - r123_squared);
    const Real c1 = (rs - t121) * r123;
    const Real sum = r12 + rs + 2.0f * c1 * (s1[c] + r123 * s2[c]);
    result[c] = select(total, Real(1.0f), minimum(maximum(Real(0.0f), sum), Real(1.0f)));
  }
  return result;
}

template Rgb ThinFilm::fresnel(const float&) const;
#if !KINDLING_ON_GPU
template Imath::Vec3<Lanes> ThinFilm::fresnel(const Lanes&) const;
#endif

} // namespace kindling
